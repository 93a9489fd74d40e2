"""A phone with phyphox as a source: every sample once, at its time, whatever happens to the phone."""

import math
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from random import Random
from xml.etree import ElementTree

import numpy as np
import pytest

from sar_tui.inputs import delivery, phyphox
from sar_tui.inputs.imu import Sample, SourceError, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.phyphox import Alignment, PhyphoxSource, experiment_file
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.analysis import AnalysisParameters, Window, analyse
from sar_tui.motion.synthesis import PROFILES, TABLE_4_1, SimulatedHand
from tests.fake_rosbridge import wait_until
from tests.inputs.fake_phone import STOCK, Experiment, Phone, phone

BATCH = 10


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phyphox, "POLL_S", 0.001)
    monkeypatch.setattr(delivery, "RETRY_S", 0.01)


class Bench:
    """A phone, a source and its reports. The host's time is the phone's."""

    def __init__(self, phone: Phone) -> None:
        self.phone = phone
        self.source = PhyphoxSource(f"//127.0.0.1:{phone.port}", phone.now)
        self.samples: list[Sample] = []
        self.statuses: list[Status] = []

    def start(self) -> None:
        """Start the source, and wait until it reads."""
        self.source.start(self.samples.append, self.statuses.append)
        self.wait_until_read()

    def wait_until_read(self) -> None:
        wait_until(lambda: self.phone.measuring, "it measures")
        self.wait_for_queries(2)

    def wait_for_queries(self, count: int) -> None:
        """Wait until this many further queries have been answered."""
        asked = len(self.phone.requests)
        wait_until(
            lambda: sum(path.startswith("/get") for path in self.phone.requests[asked:]) > count,
            "it asks",
        )

    def measure(self, count: int, **facts: object) -> None:
        """Measure samples, a few at a time, each few read before the next."""
        for _ in range(count // BATCH):
            self.phone.measure(BATCH, **facts)  # type: ignore[arg-type]
            self.wait_for_queries(1)

    def wait_for(self, state: str, times: int = 1) -> Status:
        wait_until(lambda: self.states.count(state) >= times, f"it is {state}")
        return [status for status in self.statuses if status.state == state][times - 1]

    def measure_until(self, state: str, times: int = 1) -> Status:
        """Let the phone measure until a state is reported."""

        def is_reported() -> bool:
            self.phone.measure(1)
            return self.states.count(state) >= times

        wait_until(is_reported, f"it is {state}")
        return self.wait_for(state, times)

    def wait_for_samples(self, count: int) -> None:
        wait_until(lambda: len(self.samples) >= count, f"{count} samples")

    @property
    def states(self) -> list[str]:
        return [status.state for status in list(self.statuses)]

    @property
    def times(self) -> list[float]:
        return [sample.device_ms for sample in self.samples]


@pytest.fixture
def connect() -> Iterator[Callable[..., Bench]]:
    """Make phones with sources that read them, and stop both at the end."""
    with ExitStack() as stack:

        def connect(experiment: Experiment = Experiment(), *, start: bool = True) -> Bench:  # noqa: B008
            bench = Bench(stack.enter_context(phone(experiment)))
            stack.callback(bench.source.stop)
            if start:
                bench.start()
            return bench

        yield connect


@pytest.mark.parametrize("rate_hz", [50, 208, 500])
def test_every_sample_comes_once_with_the_phones_time(
    connect: Callable[..., Bench], rate_hz: int
) -> None:
    bench = connect()
    bench.measure(300, step_s=1 / rate_hz, rate=lambda t: (t, -t, 2 * t))
    bench.wait_for_samples(299)
    info = bench.source.info
    assert info is not None
    assert info.rate_hz == pytest.approx(rate_hz, rel=0.01)
    assert info.model == "Test 5 (phyphox)"
    assert info.source == f"phyphox://127.0.0.1:{bench.phone.port}"
    assert info.rate_range_rad_s == pytest.approx(34.906586)
    assert info.acceleration_range_m_s2 == pytest.approx(78.4532)
    expected = [1000 * n / rate_hz for n in range(1, len(bench.times) + 1)]
    assert bench.times == pytest.approx(expected, abs=0.01)
    assert bench.samples[0].acceleration == (0.0, 0.0, 9.81)
    assert bench.states == ["attached"]


def test_the_measurement_is_started_and_stopped_and_our_own_experiment_cleared_before(
    connect: Callable[..., Bench],
) -> None:
    bench = connect(start=False)
    bench.phone.measuring = True
    bench.phone.measure(20)
    bench.phone.measuring = False
    bench.start()
    bench.measure(60)
    bench.wait_for("attached")
    bench.source.stop()
    commands = [path for path in bench.phone.requests if path.startswith("/control")]
    assert commands == [f"/control?cmd={each}" for each in ("clear", "start", "stop")]
    assert bench.times[0] == pytest.approx(10.0, abs=0.01)


def test_a_measurement_under_way_is_joined_at_its_newest_sample_and_goes_on_afterwards(
    connect: Callable[..., Bench],
) -> None:
    bench = connect(STOCK, start=False)
    bench.phone.measuring = True
    bench.phone.measure(500)
    bench.start()
    bench.measure(60)
    bench.wait_for_samples(60)
    bench.source.stop()
    assert bench.phone.measuring
    assert not any("control" in path for path in bench.phone.requests)
    assert bench.times[0] == pytest.approx(5010.0, abs=0.01)
    info = bench.statuses[0]
    assert info.state == "attached"
    assert all(math.isnan(axis) for axis in bench.samples[0].acceleration)


def test_eight_digits_and_thresholds_lose_no_sample_after_hours(
    connect: Callable[..., Bench],
) -> None:
    bench = connect(start=False)
    bench.phone.measuring = True
    bench.phone.pass_time(8000.0)
    bench.start()
    bench.measure(400, step_s=0.002)
    bench.wait_for_samples(399)
    assert np.diff(bench.times) == pytest.approx(2.0, abs=0.11)


def test_samples_that_wait_on_the_phone_while_the_network_is_down_are_not_lost(
    connect: Callable[..., Bench],
) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for_samples(90)
    bench.phone.leave()
    bench.phone.measure(150)
    bench.phone.arrive()
    bench.measure(50)
    bench.wait_for_samples(299)
    assert np.diff(bench.times) == pytest.approx(10.0, abs=0.01)
    assert bench.states == ["attached"]


def test_a_phone_that_stays_away_is_detached_and_found_again_at_its_newest_sample(
    connect: Callable[..., Bench],
) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for("attached")
    bench.phone.leave()
    waiting = bench.measure_until("detached").detail
    assert "Waiting for the phone at 127.0.0.1" in waiting
    assert bench.source.info is None
    read, newest = len(bench.samples), 1000 * bench.phone.t
    bench.phone.arrive()
    bench.wait_for_queries(3)
    bench.measure(100)
    bench.wait_for("attached", 2)
    assert bench.times[read] > newest > 4000.0, "what it measured in between is not of now"


def test_a_locked_phone_is_started_again_when_it_is_back(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for("attached")
    bench.phone.lock()
    bench.measure_until("detached")
    bench.phone.arrive()
    bench.wait_until_read()
    bench.measure(100)
    bench.wait_for("attached", 2)


def test_a_pause_at_the_phone_attaches_it_anew_as_its_clock_was_stopped(
    connect: Callable[..., Bench],
) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for("attached")
    with bench.phone._lock:
        bench.phone.measuring = False
        bench.phone.pass_time(0.6)
        bench.phone.measuring = True
    assert "began anew" in bench.measure_until("detached").detail
    bench.wait_for_queries(3)
    bench.measure(100)
    bench.wait_for("attached", 2)


@pytest.mark.parametrize("another_asks_first", [False, True])
def test_a_cleared_buffer_is_noticed_also_when_another_program_got_the_full_reply(
    connect: Callable[..., Bench], another_asks_first: bool
) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for("attached")
    with bench.phone._lock:
        bench.phone.clear()
        if another_asks_first:
            bench.phone.answer("/get?gyr_time=full")
    bench.measure_until("detached")
    bench.wait_for_queries(3)
    bench.measure(100)
    bench.wait_for("attached", 2)
    assert bench.times[-1] == pytest.approx(1000 * bench.phone.t, abs=200)


def test_another_experiment_attaches_it_anew_or_is_refused(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.measure(100)
    bench.wait_for("attached")
    bench.phone.open(Experiment("Sound", (("audio", ()),)))
    wanted = 'The experiment "Sound" on the phone does not send the gyroscope'
    assert bench.wait_for("error").detail.startswith(wanted)
    assert bench.states == ["attached", "detached", "error"]
    bench.phone.open(STOCK)
    bench.wait_until_read()
    bench.measure(100)
    bench.wait_for("attached", 2)


@pytest.mark.parametrize(
    ("how", "state", "said"),
    [
        ("refuses", "error", "does not start to measure"),
        ("timed", "detached", "timed run"),
        ("page", "detached", "Allow remote access"),
        ("linear", "error", "does not send the gyroscope"),
    ],
)
def test_a_phone_that_cannot_be_used_says_why_once(
    connect: Callable[..., Bench], how: str, state: str, said: str
) -> None:
    bench = connect(start=False)
    match how:
        case "refuses":
            bench.phone.starts = False
        case "timed":
            bench.phone.is_timed = True
        case "page":
            bench.phone.fault = lambda path: "<html>It works!</html>"
        case "linear":
            bench.phone.open(Experiment("g", (("linear_acceleration", ACC),)))
    bench.source.start(bench.samples.append, bench.statuses.append)
    assert said in bench.wait_for(state).detail
    asked = len(bench.phone.requests)
    wait_until(lambda: len(bench.phone.requests) > asked + 4)
    assert bench.states == [state]


ACC = ("accX", "accY", "accZ", "acc_time")


def test_broken_replies_are_asked_for_again(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.measure(100)
    random = Random(1)

    def fault(path: str) -> str | None:
        match random.randrange(5):
            case 0:
                raise ConnectionError
            case 1:
                return '{"buffer":{"gyrX":{"size":0,"upd'
            case 2:
                return ""
        return None

    bench.phone.fault = fault
    bench.measure(300)
    bench.phone.fault = lambda path: None
    bench.wait_for_samples(399)
    assert np.diff(bench.times) == pytest.approx(10.0, abs=0.01)
    assert bench.states == ["attached"]


def test_a_gyroscope_that_sends_nothing_is_told(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.phone.pass_time(1.0)
    assert "its gyroscope sends nothing" in bench.wait_for("detached").detail
    bench.measure(100)
    bench.wait_for("attached")
    assert bench.states == ["detached", "attached"]


def test_what_is_no_number_is_not_a_number(connect: Callable[..., Bench]) -> None:
    bench = connect()
    bench.measure(60)
    bench.phone.measure(1, rate=lambda t: (math.nan, 1.0, math.inf))
    bench.measure(20)
    bench.wait_for_samples(61)
    x, y, z = bench.samples[60].rate
    assert (math.isnan(x), y, math.isnan(z)) == (True, 1.0, True)


def test_the_acceleration_is_interpolated_at_the_times_of_the_gyroscope(
    connect: Callable[..., Bench],
) -> None:
    bench = connect()
    bench.measure(200, offset_s=0.004, acceleration=lambda t: (t, 0.0, 9.81))
    bench.wait_for_samples(190)
    for sample in bench.samples[1:]:
        assert sample.acceleration[0] * 1000 == pytest.approx(sample.device_ms, abs=0.1)


def test_an_accelerometer_that_falls_silent_does_not_hold_the_gyroscope_up() -> None:
    aligned = Alignment(0.1)
    aligned.hear([(0.0, (1.0, 0.0, 0.0)), (0.02, (3.0, 0.0, 0.0))])
    rates = [(n / 100, (0.0, 0.0, float(n))) for n in range(40)]
    found = {round(100 * t): a[0] for t, _, a in aligned.put(rates)}
    assert [found[n] for n in (0, 1, 2, 12)] == [1.0, 2.0, 3.0, 3.0]
    assert math.isnan(found[13])
    assert max(found) == 29, "the newest wait for a later acceleration"


def test_a_simulated_reach_is_found_at_its_time_despite_a_slow_network() -> None:
    """A sample's time is late by the least delay of the network, whatever the others are."""
    random, begun = Random(7), 3 * SECOND
    hand = SimulatedHand(PROFILES["steady"], 200.0, 3)
    hand.move(begun, TABLE_4_1[2].shape)
    with phone() as it:
        it.play(hand.samples(0, 8 * SECOND))
        it.latency_ns = lambda: round((6 + random.expovariate(1 / 10)) * MS)
        feed = ImuFeed(PhyphoxSource(f"//127.0.0.1:{it.port}", it.now), it.now)
        feed.start()
        wait_until(lambda: it.now_s > 8.2)
        feed.stop()
        samples = feed.drain().samples
    assert (feed.lost, feed.dropped) == (0, 0)
    assert len(samples) == feed.received > 1500
    late_ms = (samples["at"] - it.began_ns) / MS - samples["device_ms"]
    late_ms -= late_ms.min()
    settled = samples["device_ms"] > 1500
    assert np.percentile(late_ms[settled], 99) < 6.0, "half an interval between two requests"
    first = int(samples["at"][0])
    window = Window(from_ns=first, started_ns=first, to_ns=2**62)
    found = analyse(samples, window, AnalysisParameters())
    assert found.onset_ns is not None
    late = found.onset_ns - it.began_ns - begun
    assert 0 < late < 40 * MS


def test_a_phone_that_is_nowhere_is_waited_for_in_one_sentence_whatever_port_is_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: list[int] = []

    def refused(address: tuple[str, int], *_: object) -> None:
        tried.append(address[1])
        raise ConnectionRefusedError

    monkeypatch.setattr(socket, "create_connection", refused)
    statuses: list[Status] = []
    source = PhyphoxSource("//192.0.2.20")
    source.start(lambda sample: None, statuses.append)
    wait_until(lambda: len(tried) >= 4)
    source.stop()
    assert tried[:4] == [8080, 80, 8080, 80]
    assert [status.state for status in statuses] == ["detached"]
    assert statuses[0].detail.startswith("Waiting for the phone at 192.0.2.20: open the experiment")


def test_a_name_that_the_network_does_not_know_is_told_as_such(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def unknown(*_: object, **__: object) -> None:
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    statuses: list[Status] = []
    source = PhyphoxSource("//my-phone:8080")
    source.start(lambda sample: None, statuses.append)
    wait_until(lambda: bool(statuses))
    source.stop()
    assert "no device of the name my-phone: use the address" in statuses[0].detail


def test_our_own_experiment_measures_with_both_sensors_into_buffers_of_a_few_seconds() -> None:
    root = ElementTree.fromstring(experiment_file())
    assert root.findtext("title") == phyphox.TITLE
    containers = {each.text: int(each.get("size", "1")) for each in root.iter("container")}
    assert set(containers.values()) == {5000}
    for kind in ("gyroscope", "accelerometer"):
        (sensor,) = root.findall(f"input/sensor[@type='{kind}']")
        assert {each.get("component") for each in sensor} == set("xyzt")
        assert {each.text for each in sensor} <= set(containers)
    used = {each.text for each in root.iter("input") if each.text and each.text.strip()}
    assert used <= set(containers)


@pytest.mark.parametrize(
    "address",
    [
        "",
        "//",
        "192.168.1.20",
        "//user@host",
        "//host:0",
        "//host:port",
        "//a/b",
        "//a?b",
        "//192.168..20",
    ],
)
def test_an_invalid_address_is_refused_with_an_example(address: str) -> None:
    with pytest.raises(SourceError, match="Use phyphox://HOST"):
        PhyphoxSource(address)
