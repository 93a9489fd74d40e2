"""The contract of sensors: every included source keeps it, and broken ones are told how."""

import uuid
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import pytest

from sar_tui.api.sensor import ImuSource, Info, Sample, Status, Vector, host_now
from sar_tui.api.testing import SensorBench, check_sensor
from sar_tui.drivers import rosbridge
from sar_tui.inputs import delivery, lines, lsl, phyphox
from sar_tui.model.units import SECOND
from tests.inputs.benches import (
    LslBench,
    PhidgetBench,
    SerialBench,
    phone_bench,
    ros_bench,
    udp_bench,
)
from tests.inputs.test_lsl_in import need_streams, outlet

Make = Callable[[Path], AbstractContextManager[SensorBench]]


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delivery, "RETRY_S", 0.01)
    monkeypatch.setattr(lines, "_READ_S", 0.01)
    monkeypatch.setattr(lines, "SILENCE", 3 * SECOND)
    monkeypatch.setattr(phyphox, "POLL_S", 0.001)
    monkeypatch.setattr(rosbridge, "FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(rosbridge, "LONGEST_RETRY_S", 0.05)
    monkeypatch.setattr(lsl, "LOOK_S", 5.0)


def serial_bench(folder: Path) -> AbstractContextManager[SensorBench]:
    pytest.importorskip("serial")
    return nullcontext(SerialBench(str(folder / "board")))


def lsl_bench(_: Path) -> AbstractContextManager[SensorBench]:
    name = f"sar-tui-test-{uuid.uuid4().hex[:8]}"
    stream = outlet(name)
    need_streams(name)
    del stream
    return nullcontext(LslBench(name))


BENCHES: dict[str, Make] = {
    "phidget": lambda _: nullcontext(PhidgetBench()),
    "phyphox": lambda _: phone_bench(),
    "ros": lambda _: ros_bench(),
    "udp": lambda _: udp_bench(),
    "serial": serial_bench,
    "lsl": lsl_bench,
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] if n == "lsl" else []) for n in BENCHES]
)
def test_an_included_source_keeps_the_contract(name: str, tmp_path: Path) -> None:
    with BENCHES[name](tmp_path) as bench:
        assert [check.line for check in check_sensor(bench) if not check.ok] == []


# --- sources that break it


class Toy:
    """A source that a test plays by hand, with a fault."""

    def __init__(self, fault: str) -> None:
        self.fault = fault
        self.info: Info | None = None
        self.is_running = False

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        self._sink, self._on_status, self.is_running = sink, on_status, True
        self.report("detached", "" if self.fault == "silent" else "Waiting.")

    def report(self, state: Any, detail: str = "") -> None:
        self._on_status(Status(state=state, at=host_now(), detail=detail))

    def stop(self) -> None:
        self.is_running = self.fault == "unstoppable"
        self.info = None

    def zero(self) -> None:
        if self.fault == "no zero":
            raise RuntimeError("no such command")

    def attach(self) -> None:
        rate_hz = 50.0 if self.fault == "rate" else 100.0
        self.info = Info(source="toy", model="Toy", rate_hz=rate_hz, rate_range_rad_s=10.0)
        self.report("attached")

    def detach(self) -> None:
        if self.fault != "loyal":
            self.info = None
            self.report("detached", "Plug it in.")
        elif self.is_running:
            self.is_running = True

    def put(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        if not self.is_running:
            return
        x, y, z = rate
        if self.fault == "degrees":
            x, y, z = 57.3 * x, 57.3 * y, 57.3 * z
        if self.fault == "clips":
            x = min(x, 9.0)
        stamp = device_ms / 1000 if self.fault == "seconds" else device_ms
        host_ns = 0 if self.fault == "host" else host_now()
        self._sink(Sample(host_ns, stamp, acceleration, (x, y, z)))
        if self.fault == "twice":
            self._sink(Sample(host_ns, stamp + 0.1, acceleration, (x, y, z)))


class ToyBench(SensorBench):
    patience_s = 0.01

    def __init__(self, fault: str = "") -> None:
        super().__init__()
        self.fault = fault
        self.toy = Toy(fault)
        self.is_there = False

    def make(self) -> ImuSource:
        self.toy = Toy(self.fault)
        return self.toy

    def plug_in(self) -> None:
        self.is_there = True
        self.toy.attach()

    def unplug(self) -> None:
        if self.is_there and self.toy.is_running:
            self.toy.detach()
        self.is_there = False

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        self.toy.put(device_ms, acceleration, rate)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("silent", "It does not say what it waits for."),
        ("no zero", "It raised RuntimeError: no such command."),
        ("rate", "Its info says 50 samples a second; it measures 100."),
        ("degrees", "measured was (0.5, -0.25, 0.0) rad/s."),
        ("twice", "measured was (0.5, -0.25, 0.125) rad/s."),
        ("seconds", "0.010 ms apart on the device's clock, not 10.000."),
        ("host", "Its host_ns is not the time of arrival"),
        ("clips", "A rate beyond its range was not reported."),
        ("loyal", 'It did not report "detached" again.'),
        ("unstoppable", "It delivers or reports after it was stopped."),
    ],
)
def test_a_broken_contract_is_told_in_a_sentence(fault: str, said: str) -> None:
    problems = [problem for check in check_sensor(ToyBench(fault)) for problem in check.problems]
    assert [problem for problem in problems if said in problem], problems


def test_a_source_without_a_fault_passes() -> None:
    assert all(check.ok for check in check_sensor(ToyBench()))
