"""A Phidget as a source: plugged in, refused, pulled out or faulty."""

import ctypes
import math
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from sar_tui.inputs import phidget
from sar_tui.inputs.imu import Sample, SourceError, Status
from sar_tui.inputs.phidget import NO_LIBRARY, NO_PACKAGE, NO_PERMISSION, PhidgetSource
from tests.drivers.fake_phidget import FakeChannel, PhidgetError

WAIT_S = 60.0
"""Time to wait for another thread before a test fails."""


class FakeSpatial(FakeChannel):
    """A channel with the methods of Phidget22's ``Spatial``."""

    def __init__(self) -> None:
        super().__init__()
        self.facts |= {
            "DeviceName": "PhidgetSpatial Precision 3/3/3",
            "DeviceSKU": "1044_1B",
            "DeviceSerialNumber": 473_001,
            "DeviceVersion": 530,
            "MinDataInterval": 4,
            "MaxAngularRate": [2000.0, 2000.0, 1000.0],
            "MaxAcceleration": [8.0, 8.0, 8.0],
            "MaxMagneticField": [8.0, 8.0, 8.0],
        }
        self.closed = threading.Event()

    def note(self, name: str, arguments: tuple[Any, ...]) -> None:
        super().note(name, arguments)
        if name == "close":
            self.closed.set()

    def send(
        self, acceleration: list[float], rate: list[float], field: list[float], timestamp: float
    ) -> None:
        self.handlers["SpatialData"](self, acceleration, rate, field, timestamp)


class Bench:
    """A source on a fake channel, and its reports."""

    def __init__(self, address: str = "", denied: Callable[[], bool] = lambda: False) -> None:
        self.channels: list[FakeSpatial] = []
        self.source = PhidgetSource(address, make=self.make, denied=denied)
        self.samples: list[Sample] = []
        self.statuses: list[Status] = []
        self.failing: dict[str, Exception] = {}
        self.reported = threading.Event()

    def make(self) -> FakeSpatial:
        channel = FakeSpatial()
        channel.failing = self.failing
        self.channels.append(channel)
        return channel

    def start(self) -> FakeSpatial:
        self.source.start(self.samples.append, self.receive_status)
        return self.channels[-1]

    def receive_status(self, status: Status) -> None:
        self.statuses.append(status)
        if status.state == "error":
            self.reported.set()

    @property
    def states(self) -> list[str]:
        return [status.state for status in self.statuses]


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.source.stop()


def test_an_attached_sensor_is_described_and_runs_at_its_highest_rate_each_time(
    bench: Bench,
) -> None:
    channel = bench.start()
    channel.plug_in()
    info = bench.source.info
    assert info is not None
    assert (info.model, info.serial, info.rate_hz) == (
        "PhidgetSpatial Precision 3/3/3 (1044_1B)",
        "473001",
        250.0,
    )
    assert info.rate_range_rad_s == pytest.approx(math.radians(1000))
    assert info.acceleration_range_m_s2 == pytest.approx(8 * 9.80665)
    assert (info.has_acceleration, info.has_field) == (True, True)
    assert channel.facts["DataInterval"] == 4
    assert bench.statuses[1].detail == "Firmware 530."
    channel.pull_out()
    assert bench.source.info is None
    channel.facts["MinDataInterval"] = 1
    for name in ("getMaxAngularRate", "getMaxAcceleration", "getMaxMagneticField"):
        bench.failing[name] = PhidgetError(20, "Unsupported")
    channel.plug_in()
    assert bench.states == ["detached", "attached", "detached", "attached"]
    info = bench.source.info
    assert info is not None
    assert (info.rate_hz, info.has_field) == (1000.0, False)
    assert (info.rate_range_rad_s, info.acceleration_range_m_s2) == (0.0, 0.0)
    assert channel.facts["DataInterval"] == 1


def test_samples_are_in_metres_radians_and_gauss_and_broken_ones_are_reported_once(
    bench: Bench,
) -> None:
    channel = bench.start()
    channel.plug_in()
    channel.send([1.0, 0.0, -0.5], [180.0, -90.0, 0.0], [0.1, 0.2, 1e300], 12.0)
    [sample] = bench.samples
    assert sample.acceleration == (9.80665, 0.0, -4.903325)
    assert sample.rate == pytest.approx((math.pi, -math.pi / 2, 0.0))
    assert sample.field[:2] == (0.1, 0.2)
    assert math.isnan(sample.field[2])
    assert sample.device_ms == 12.0
    assert sample.host_ns >= bench.statuses[-1].at
    for stamp in (16.0, 20.0, 24.0):
        channel.send([0.0], [0.0], [0.0], stamp)
    assert bench.states == ["detached", "attached", "error"]
    assert "ValueError" in bench.statuses[-1].detail


@pytest.mark.parametrize("sku", ["1041_0B", "1043_1B", "1049_0B"])
def test_a_model_without_a_gyroscope_is_refused_and_released(bench: Bench, sku: str) -> None:
    channel = bench.start()
    channel.facts["DeviceSKU"] = sku
    channel.plug_in()
    assert channel.closed.wait(WAIT_S)
    assert bench.states == ["detached", "error"]
    assert sku in bench.statuses[1].detail
    assert "no gyroscope" in bench.statuses[1].detail
    assert bench.source.info is None


def test_errors_are_reported_with_what_to_do_and_saturation_with_its_count(bench: Bench) -> None:
    channel = bench.start()
    channel.err(4096, "All is well.")
    channel.err(4105, "Gyroscope Saturation Detected.")
    assert bench.states == ["detached", "saturated"]
    saturated = bench.statuses[1]
    assert (saturated.count, saturated.detail) == (1, "Gyroscope Saturation Detected.")
    advice = {2: "Close the other program", 3: "network server", 1: "same version", 4099: "lost"}
    for code, what_to_do in advice.items():
        channel.err(code, "A packet was lost.")
        assert bench.statuses[-1].state == "error"
        assert bench.statuses[-1].detail.startswith("The sensor reports: A packet was lost.")
        assert what_to_do in bench.statuses[-1].detail


@pytest.mark.parametrize(
    ("call", "error", "detail"),
    [
        ("open", PhidgetError(1, "Access Denied"), NO_PERMISSION),
        ("open", PhidgetError(7, "Access Denied"), NO_PERMISSION),
        ("open", PhidgetError(28, "Unexpected"), "The sensor cannot be opened: Unexpected"),
        ("open", ModuleNotFoundError("No Phidget22"), NO_PACKAGE),
        ("open", OSError("libusb-1.0.so.0"), NO_LIBRARY.format("libusb-1.0.so.0")),
        (
            "setDataInterval",
            PhidgetError(52, "Not Attached", "It went away."),
            "The sensor cannot be used: Not Attached: It went away.",
        ),
    ],
)
def test_a_sensor_that_cannot_be_used_is_reported_with_the_reason(
    bench: Bench, call: str, error: Exception, detail: str
) -> None:
    bench.failing[call] = error
    channel = bench.start()
    if call != "open":
        channel.plug_in()
    assert bench.states == ["detached", "error"]
    assert bench.statuses[1].detail == detail


def test_missing_permission_for_an_attached_sensor_is_reported_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(phidget, "_LOOK_AGAIN_S", 0.0)
    looks = iter([False, True, False, True, True])
    bench = Bench(denied=lambda: next(looks))
    bench.start()
    assert bench.reported.wait(WAIT_S)
    assert [status.detail for status in bench.statuses[1:]] == [NO_PERMISSION]
    assert list(looks) == []
    bench.source.stop()


def test_zeroing_is_possible_only_when_attached(bench: Bench) -> None:
    bench.source.zero()
    channel = bench.start()
    bench.source.zero()
    assert ("zeroGyro", ()) not in channel.calls
    channel.plug_in()
    bench.source.zero()
    assert channel.calls[-1] == ("zeroGyro", ())
    bench.failing["zeroGyro"] = PhidgetError(20, "Unsupported")
    bench.source.zero()
    assert bench.states[-1] == "error"


def test_stop_releases_the_sensor_and_a_restart_opens_a_new_channel(bench: Bench) -> None:
    bench.source.stop()
    first = bench.start()
    first.plug_in()
    bench.source.stop()
    assert first.closed.is_set()
    assert set(first.handlers.values()) == {None}
    assert bench.source.info is None
    second = bench.start()
    assert first is not second
    second.plug_in()
    assert bench.states == ["detached", "attached", "detached", "attached"]


def test_stop_does_not_wait_for_a_hanging_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phidget, "_CLOSE_S", 0.01)
    free = threading.Event()
    bench = Bench()
    channel = bench.start()
    object.__setattr__(channel, "close", free.wait)
    bench.source.stop()
    assert not free.is_set()
    free.set()


def test_the_first_sensor_or_that_with_the_serial_number_is_opened() -> None:
    first, second = Bench(""), Bench("473001")
    assert "DeviceSerialNumber" not in {name[3:] for name, _ in first.start().calls}
    channel = second.start()
    assert channel.facts["DeviceSerialNumber"] == 473_001
    assert (channel.facts["IsLocal"], channel.facts["IsRemote"]) == (True, False)
    assert "473001" in second.statuses[0].detail
    first.source.stop()
    second.source.stop()


@pytest.mark.parametrize(
    ("address", "host", "port"),
    [
        ("//lab-pi:5000", "lab-pi", 5000),
        ("//192.168.1.7", "192.168.1.7", 5661),
        ("phidget://lab-pi", "lab-pi", 5661),
        ("//[::1]:5662", "::1", 5662),
    ],
)
def test_a_sensor_on_the_network_is_found_by_host_and_port(
    monkeypatch: pytest.MonkeyPatch, address: str, host: str, port: int
) -> None:
    from Phidget22.Net import Net

    added: list[Any] = []
    monkeypatch.setattr(Net, "addServer", lambda *arguments: added.append(arguments))
    monkeypatch.setattr(
        Net, "removeServer", lambda name: added.remove(next(a for a in added if a[0] == name))
    )
    bench = Bench(address)
    channel = bench.start()
    assert added == [(f"sar-tui {host}:{port}", host, port, "", 0)]
    assert (channel.facts["IsLocal"], channel.facts["IsRemote"]) == (False, True)
    assert host in bench.statuses[0].detail
    bench.source.stop()
    assert added == []


@pytest.mark.parametrize(("code", "states"), [(27, ["detached"]), (45, ["detached", "error"])])
def test_an_invalid_server_is_reported_and_adding_one_twice_is_no_error(
    monkeypatch: pytest.MonkeyPatch, code: int, states: list[str]
) -> None:
    from Phidget22.Net import Net

    def add(*_: Any) -> None:
        raise PhidgetError(code, "Network Unavailable")

    monkeypatch.setattr(Net, "addServer", add)
    bench = Bench("//lab-pi")
    bench.start()
    assert bench.states == states
    bench.source.stop()


@pytest.mark.parametrize(
    "address",
    ["first", "-1", "//", "//host:port", "//host:99999", "//me:secret@host", "http://x", "//[::1"],
)
def test_an_invalid_address_is_refused_with_the_valid_forms(address: str) -> None:
    with pytest.raises(SourceError, match="phidget://HOST:PORT"):
        PhidgetSource(address)


def test_a_native_library_that_does_not_load_is_reported_without_other_output(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from Phidget22.Phidget import Phidget

    def fail() -> str:
        raise OSError("libusb-1.0.so.0: cannot open shared object file")

    monkeypatch.setattr(Phidget, "getLibraryVersion", fail)
    monkeypatch.setattr(ctypes, "CDLL", lambda _: None)
    statuses: list[Status] = []
    PhidgetSource().start(lambda _: None, statuses.append)
    assert "libusb-1.0.so.0" in statuses[-1].detail
    assert capfd.readouterr().err == ""


def test_without_a_device_or_server_the_real_channel_waits(
    capfd: pytest.CaptureFixture[str],
) -> None:
    statuses: list[Status] = []
    for address in ("1", "//127.0.0.1:1"):
        source = PhidgetSource(address, denied=lambda: False)
        source.start(lambda _: None, statuses.append)
        source.zero()
        source.stop()
        assert source.info is None
    assert [status.state for status in statuses] == ["detached"] * 2
    assert capfd.readouterr().err == ""
