"""A topic of sensor_msgs/Imu behind a rosbridge server as a source."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from sar_tui.drivers import rosbridge
from sar_tui.inputs import delivery
from sar_tui.inputs.delivery import LOOKED_AT
from sar_tui.inputs.imu import Sample, SourceError, Status
from sar_tui.inputs.ros import RosImuSource
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND
from tests.fake_rosbridge import RosBridge, hide_roslibpy, ros_bridge, wait_until

BORN_NS = 1_760_000_000 * SECOND
"""A stamp of a ROS clock, which shows the time of day."""
TOPIC = "/imu/data"


def imu(
    ns: int,
    rate: tuple[Any, Any, Any] = (0.1, -0.2, 0.3),
    acceleration: tuple[Any, Any, Any] = (0.0, 0.5, 9.81),
    *,
    ros: int = 2,
    **others: Any,
) -> dict[str, Any]:
    """Return a sensor_msgs/Imu in rosbridge's form, stamped ``ns``."""
    seconds, nanoseconds = divmod(ns, SECOND)
    names = ("sec", "nanosec") if ros == 2 else ("secs", "nsecs")
    message: dict[str, Any] = {
        "header": {
            "stamp": dict(zip(names, (seconds, nanoseconds), strict=True)),
            "frame_id": "imu_link",
        },
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        "orientation_covariance": [-1.0] + [0.0] * 8,
        "angular_velocity": dict(zip("xyz", rate, strict=True)),
        "angular_velocity_covariance": [0.0] * 9,
        "linear_acceleration": dict(zip("xyz", acceleration, strict=True)),
        "linear_acceleration_covariance": [0.0] * 9,
    }
    return message | others


class Bench:
    """A source, and its reports."""

    def __init__(self, server: RosBridge, options: str = "") -> None:
        self.server = server
        self.source = RosImuSource(f"//{server.host}{TOPIC}{options}")
        self.samples: list[Sample] = []
        self.statuses: list[Status] = []
        self.sent_ns = BORN_NS

    def start(self) -> None:
        """Start the source, and wait until it is connected."""
        self.source.start(self.samples.append, self.statuses.append)
        self.wait_until_connected()

    def wait_until_connected(self) -> None:
        wait_until(lambda: self.server.has_subscriber(TOPIC), "the topic is subscribed to")

    def send(self, count: int = 1, *, step_ns: int = 10 * MS, **facts: Any) -> None:
        for _ in range(count):
            self.server.publish(TOPIC, imu(self.sent_ns, **facts))
            self.sent_ns += step_ns

    def wait_for(self, state: str, times: int = 1) -> Status:
        wait_until(lambda: self.states.count(state) >= times, f"it is {state}")
        return [status for status in self.statuses if status.state == state][times - 1]

    @property
    def states(self) -> list[str]:
        return [status.state for status in list(self.statuses)]


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rosbridge, "FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(rosbridge, "LONGEST_RETRY_S", 0.05)


@pytest.fixture
def connect() -> Iterator[Callable[..., Bench]]:
    """Make sources that have subscribed, and stop them at the end."""
    benches: list[Bench] = []
    with ros_bridge() as server:

        def connect(options: str = "") -> Bench:
            benches.append(Bench(server, options))
            benches[-1].start()
            return benches[-1]

        yield connect
        for bench in benches:
            bench.source.stop()


@pytest.mark.parametrize("ros", [1, 2])
def test_samples_have_sensor_and_host_times_and_none_is_lost(
    connect: Callable[..., Bench], ros: int
) -> None:
    bench = connect()
    before = host_now()
    bench.send(LOOKED_AT + 10, step_ns=4 * MS, ros=ros)
    wait_until(lambda: len(bench.samples) == LOOKED_AT + 10)
    assert [sample.device_ms for sample in bench.samples] == [
        4.0 * n for n in range(LOOKED_AT + 10)
    ]
    assert all(before < sample.host_ns < host_now() for sample in bench.samples)
    assert bench.samples[0].rate == (0.1, -0.2, 0.3)
    assert bench.samples[0].acceleration == (0.0, 0.5, 9.81)
    assert all(math.isnan(axis) for axis in bench.samples[0].field)
    info = bench.source.info
    assert info is not None
    assert info.rate_hz == pytest.approx(250)
    assert info.model == "sensor_msgs/Imu (imu_link)"
    assert info.source == f"ros://{bench.server.host}{TOPIC}"
    assert info.has_acceleration


def test_lost_samples_do_not_change_the_measured_rate(connect: Callable[..., Bench]) -> None:
    bench = connect()
    for _ in range(LOOKED_AT):
        bench.send(3)
        bench.sent_ns += 70 * MS
    bench.wait_for("attached")
    assert bench.source.info is not None
    assert bench.source.info.rate_hz == pytest.approx(100)


def test_the_hosts_clock_replaces_zero_stamps_and_constant_ones_are_reported(
    connect: Callable[..., Bench],
) -> None:
    constant = connect()
    constant.send(LOOKED_AT, step_ns=0)
    assert "do not increase" in constant.wait_for("error").detail
    assert constant.samples == []
    constant.source.stop()
    wait_until(lambda: not constant.server.has_subscriber(TOPIC))
    bench = connect("?rate=100")
    for _ in range(3):
        bench.server.publish(TOPIC, imu(0))
    wait_until(lambda: len(bench.samples) == 3)
    assert bench.source.info is not None
    assert bench.source.info.rate_hz == 100.0, "it is known, so it is not measured"
    first, *others = bench.samples
    assert first.device_ms == 0.0
    assert [sample.device_ms for sample in others] == [
        (sample.host_ns - first.host_ns) / 1e6 for sample in others
    ]


def test_by_its_covariance_a_sensor_without_an_accelerometer_is_used_and_one_without_a_gyroscope_not(
    connect: Callable[..., Bench],
) -> None:
    bench = connect("?rate=100")
    bench.send(5, angular_velocity_covariance=[-1.0] + [0.0] * 8)
    bench.send(linear_acceleration_covariance=[-1] + [0] * 8)
    wait_until(lambda: len(bench.samples) == 1)
    assert bench.states == ["detached", "detached", "error", "attached"]
    assert "Use one with a gyroscope." in bench.wait_for("error").detail
    assert all(math.isnan(axis) for axis in bench.samples[0].acceleration)
    assert bench.source.info is not None
    assert not bench.source.info.has_acceleration


@pytest.mark.parametrize(
    "wrong",
    [
        "not a message",
        {},
        {"header": {"stamp": {"sec": 1, "nanosec": 0}}},
        imu(BORN_NS) | {"angular_velocity": {"x": 1.0, "y": 2.0}},
        imu(BORN_NS) | {"angular_velocity": [1.0, 2.0, 3.0]},
        imu(BORN_NS) | {"header": {"stamp": {"sec": 10**400, "nanosec": 0}}},
        imu(BORN_NS) | {"header": {"stamp": {"sec": "soon"}}},
        imu(BORN_NS) | {"linear_acceleration": None},
        imu(BORN_NS) | {"angular_velocity_covariance": "unknown"},
    ],
)
def test_messages_that_are_not_imu_are_left_out_and_reported_once_in_a_row(
    connect: Callable[..., Bench], wrong: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(delivery, "COMPLAIN_AGAIN", 0)
    bench = connect("?rate=100")
    bench.send()
    for _ in range(3):
        bench.server.publish(TOPIC, wrong)
    bench.send()
    bench.server.publish(TOPIC, wrong)
    bench.send()
    wait_until(lambda: len(bench.samples) == 3)
    assert bench.states == ["detached", "detached", "attached", "error", "error"]
    assert bench.wait_for("error").detail.startswith(
        "The messages on /imu/data are not sensor_msgs/Imu ("
    )


def test_what_is_no_measurement_is_not_a_number(connect: Callable[..., Bench]) -> None:
    bench = connect("?rate=100")
    for nothing in (None, math.nan, math.inf, -math.inf, 1e300):
        bench.send(rate=(0.5, nothing, 0.0), acceleration=(nothing, 0.0, 9.81))
    wait_until(lambda: len(bench.samples) == 5)
    for sample in bench.samples:
        (x, y, z), acceleration = sample.rate, sample.acceleration
        assert (x, math.isnan(y), z) == (0.5, True, 0.0)
        assert (math.isnan(acceleration[0]), acceleration[1:]) == (True, (0.0, 9.81))


def test_it_is_detached_while_the_bridge_is_away(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.wait_for("detached", 2)
    assert "Waiting for the ROS bridge" in bench.statuses[0].detail
    assert "Waiting for samples on /imu/data" in bench.statuses[1].detail
    bench.send(LOOKED_AT)
    bench.wait_for("attached")
    bench.server.leave()
    assert bench.wait_for("detached", 3).detail.endswith("was lost. Waiting for it.")
    assert bench.source.info is None
    bench.server.arrive()
    bench.wait_until_connected()
    bench.sent_ns += 60 * SECOND
    bench.send(LOOKED_AT)
    bench.wait_for("attached", 2)
    wait_until(lambda: len(bench.samples) == 2 * LOOKED_AT)
    assert bench.samples[LOOKED_AT].device_ms == 0.0


def test_after_a_stop_nothing_arrives_until_a_restart(connect: Callable[..., Bench]) -> None:
    bench = connect("?rate=100")
    bench.send()
    wait_until(lambda: len(bench.samples) == 1)
    bench.source.stop()
    bench.source.stop()
    bench.source.zero()
    assert bench.source.info is None
    reported = list(bench.statuses)
    wait_until(lambda: not bench.server.has_subscriber(TOPIC))
    assert bench.statuses == reported
    bench.start()
    bench.send()
    wait_until(lambda: len(bench.samples) == 2)
    assert bench.samples[1].device_ms == 0.0


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    hide_roslibpy(monkeypatch)
    statuses: list[Status] = []
    source = RosImuSource("//127.0.0.1/imu")
    source.start(lambda sample: None, statuses.append)
    wait_until(lambda: len(statuses) == 2)
    assert statuses[1].state == "error"
    assert "pip install -e '.[ros]'" in statuses[1].detail
    source.stop()


@pytest.mark.parametrize(
    "address",
    ["robot", "//robot", "//robot/imu?rate=fast", "//robot/imu?rate=0", "//robot/imu?hz=5"],
)
def test_an_invalid_address_is_refused_with_an_example(address: str) -> None:
    with pytest.raises(SourceError, match="Use ros://HOST/TOPIC"):
        RosImuSource(address)
