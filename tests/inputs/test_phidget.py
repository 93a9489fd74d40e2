"""A Phidget as a source: plugged in, refused, pulled out or faulty."""

import ctypes
import math
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from sar_tui.drivers.phidget import usb_denied
from sar_tui.inputs import phidget
from sar_tui.inputs.imu import Sample, SourceError, Status
from sar_tui.inputs.phidget import NO_PERMISSION, PhidgetSource

WAIT_S = 60.0
"""Time to wait for another thread before a test fails."""


class PhidgetError(Exception):
    """Like Phidget22's exception: a code and two texts."""

    def __init__(self, code: int, description: str, details: str = "") -> None:
        super().__init__(code)
        self.code, self.description, self.details = code, description, details


class FakeSpatial:
    """A channel with the methods of Phidget22's ``Spatial``, which can be plugged in and out."""

    def __init__(self) -> None:
        self.handlers: dict[str, Any] = {}
        self.calls: list[tuple[str, Any]] = []
        self.facts: dict[str, Any] = {
            "DeviceName": "PhidgetSpatial Precision 3/3/3",
            "DeviceSKU": "1044_1B",
            "DeviceSerialNumber": 473_001,
            "DeviceVersion": 530,
            "MinDataInterval": 4,
            "MaxAngularRate": [2000.0, 2000.0, 1000.0],
            "MaxAcceleration": [8.0, 8.0, 8.0],
            "MaxMagneticField": [8.0, 8.0, 8.0],
        }
        self.failing: dict[str, Exception] = {}
        self.closed = threading.Event()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def method(*arguments: Any) -> Any:
            self.calls.append((name, *arguments) if arguments else (name, None))
            if name in self.failing:
                raise self.failing[name]
            if name.startswith("setOn"):
                self.handlers[name[5:-7]] = arguments[0]
            elif name.startswith("set"):
                self.facts[name[3:]] = arguments[0]
            elif name.startswith("get"):
                return self.facts[name[3:]]
            elif name == "close":
                self.closed.set()
            return None

        return method

    def plug_in(self) -> None:
        self.handlers["Attach"](self)

    def pull_out(self) -> None:
        self.handlers["Detach"](self)

    def send(
        self, acceleration: list[float], rate: list[float], field: list[float], timestamp: float
    ) -> None:
        self.handlers["SpatialData"](self, acceleration, rate, field, timestamp)

    def err(self, code: int, description: str) -> None:
        self.handlers["Error"](self, code, description)


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


def test_an_attached_sensor_is_described_and_runs_at_its_highest_rate(bench: Bench) -> None:
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
    assert bench.states == ["detached", "attached"]
    assert bench.statuses[1].detail == "Firmware 530."


def test_until_attached_it_reports_what_it_waits_for(bench: Bench) -> None:
    bench.start()
    assert bench.states == ["detached"]
    assert "plug it in" in bench.statuses[0].detail
    assert bench.source.info is None


def test_samples_are_in_metres_radians_and_gauss(bench: Bench) -> None:
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


def test_a_sensor_may_be_detached_and_attached_again(bench: Bench) -> None:
    channel = bench.start()
    channel.plug_in()
    channel.pull_out()
    assert bench.source.info is None
    channel.facts["MinDataInterval"] = 1
    channel.plug_in()
    assert bench.states == ["detached", "attached", "detached", "attached"]
    assert bench.source.info is not None
    assert bench.source.info.rate_hz == 1000.0
    assert channel.facts["DataInterval"] == 1


def test_unavailable_ranges_are_unknown(bench: Bench) -> None:
    for name in ("getMaxAngularRate", "getMaxAcceleration", "getMaxMagneticField"):
        bench.failing[name] = PhidgetError(20, "Unsupported")
    bench.start().plug_in()
    info = bench.source.info
    assert info is not None
    assert (info.rate_range_rad_s, info.acceleration_range_m_s2, info.has_field) == (
        0.0,
        0.0,
        False,
    )


def test_saturation_is_reported(bench: Bench) -> None:
    channel = bench.start()
    channel.plug_in()
    channel.err(4105, "Gyroscope Saturation Detected.")
    assert (bench.statuses[-1].state, bench.statuses[-1].count) == ("saturated", 1)
    assert bench.statuses[-1].detail == "Gyroscope Saturation Detected."


@pytest.mark.parametrize(
    ("code", "advice"),
    [(2, "Close the other program"), (3, "network server"), (1, "same version"), (4099, "lost")],
)
def test_an_error_is_reported_with_what_to_do(bench: Bench, code: int, advice: str) -> None:
    channel = bench.start()
    channel.err(code, "A packet was lost.")
    assert bench.statuses[-1].state == "error"
    assert bench.statuses[-1].detail.startswith("The sensor reports: A packet was lost.")
    assert advice in bench.statuses[-1].detail


def test_a_cleared_error_is_not_reported(bench: Bench) -> None:
    bench.start().err(4096, "All is well.")
    assert bench.states == ["detached"]


def test_a_handler_that_fails_is_reported_once(bench: Bench) -> None:
    channel = bench.start()
    channel.plug_in()
    for stamp in (0.0, 4.0, 8.0):
        channel.send([0.0], [0.0], [0.0], stamp)
    assert bench.states == ["detached", "attached", "error"]
    assert "ValueError" in bench.statuses[-1].detail


def test_a_sensor_that_cannot_be_set_up_is_reported(bench: Bench) -> None:
    bench.failing["setDataInterval"] = PhidgetError(52, "Device not Attached", "It went away.")
    bench.start().plug_in()
    assert bench.states == ["detached", "error"]
    assert "Device not Attached: It went away." in bench.statuses[-1].detail


@pytest.mark.parametrize("code", [1, 7])
def test_missing_permission_is_reported_with_the_udev_rule(bench: Bench, code: int) -> None:
    bench.failing["open"] = PhidgetError(code, "Access Denied")
    bench.start()
    assert bench.statuses[-1] == Status(
        state="error", at=bench.statuses[-1].at, detail=NO_PERMISSION
    )
    for part in (
        "/etc/udev/rules.d/",
        'SUBSYSTEM=="usb", ATTRS{idVendor}=="06c2", TAG+="uaccess"',
        "plug it in again",
    ):
        assert part in NO_PERMISSION


def test_any_other_failure_to_open_is_reported(bench: Bench) -> None:
    bench.failing["open"] = PhidgetError(28, "Unexpected Error")
    bench.start()
    assert bench.statuses[-1].detail == "The sensor cannot be opened: Unexpected Error"


@pytest.mark.parametrize(
    ("error", "cure"),
    [
        (ModuleNotFoundError("No module named 'Phidget22'"), "pip install phidget22"),
        (OSError("libusb-1.0.so.0: cannot open shared object file"), "libusb-package"),
    ],
)
def test_a_missing_driver_is_reported_with_how_to_install_it(error: Exception, cure: str) -> None:
    def make() -> Any:
        raise error

    statuses: list[Status] = []
    source = PhidgetSource(make=make)
    source.start(lambda _: None, statuses.append)
    assert [status.state for status in statuses] == ["detached", "error"]
    assert cure in statuses[1].detail
    source.zero()
    source.stop()


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


@pytest.mark.parametrize(
    ("may", "vendor", "denied"),
    [(False, "06c2", True), (True, "06c2", False), (False, "046d", False)],
)
def test_permissions_are_read_from_the_linux_device_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, may: bool, vendor: str, denied: bool
) -> None:
    device = tmp_path / "devices" / "1-2"
    device.mkdir(parents=True)
    for name, text in (("idVendor", vendor), ("busnum", "1"), ("devnum", "7")):
        (device / name).write_text(f"{text}\n")
    node = tmp_path / "bus" / "001" / "007"
    node.parent.mkdir(parents=True)
    node.touch()
    monkeypatch.setattr("os.access", lambda path, _mode: may or path != node)
    assert usb_denied(tmp_path / "devices", tmp_path / "bus") is denied
    assert not usb_denied(tmp_path / "nothing", tmp_path / "bus")


def test_zeroing_is_possible_only_when_attached(bench: Bench) -> None:
    bench.source.zero()
    channel = bench.start()
    bench.source.zero()
    assert ("zeroGyro", None) not in channel.calls
    channel.plug_in()
    bench.source.zero()
    assert channel.calls[-1] == ("zeroGyro", None)
    bench.failing["zeroGyro"] = PhidgetError(20, "Unsupported")
    bench.source.zero()
    assert bench.states[-1] == "error"


def test_stop_releases_the_sensor_and_no_more_reports_arrive(bench: Bench) -> None:
    bench.source.stop()
    channel = bench.start()
    channel.plug_in()
    bench.source.stop()
    assert channel.closed.is_set()
    assert set(channel.handlers.values()) == {None}
    assert bench.source.info is None
    bench.source.stop()


def test_stop_does_not_wait_for_a_hanging_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phidget, "_CLOSE_S", 0.01)
    free = threading.Event()
    bench = Bench()
    channel = bench.start()
    object.__setattr__(channel, "close", free.wait)
    bench.source.stop()
    assert not free.is_set()
    free.set()


def test_a_restart_opens_a_new_channel(bench: Bench) -> None:
    first = bench.start()
    bench.source.stop()
    second = bench.start()
    assert first is not second
    second.plug_in()
    assert bench.states == ["detached", "detached", "attached"]


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


def test_phidget22_is_loaded_only_when_a_sensor_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "Phidget22.Devices.Spatial", None)
    statuses: list[Status] = []
    source = PhidgetSource()
    source.start(lambda _: None, statuses.append)
    assert "pip install phidget22" in statuses[-1].detail


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
