"""Checks that a source of a motion sensor keeps its contract, with a device that a test plays."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise

from sar_tui.checks.check import Check, checked
from sar_tui.inputs.imu import ImuSource, Info, Sample, Status, Vector
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.loop.clock import host_now

COUNT = 120
"""Samples that a device measures at a time; more than a source may need to learn its rate."""
_MISSING = 7
_REST: Vector = (0.0, 0.0, 9.81)
_LOOK_S = 0.002


class SensorBench(ABC):
    """A device that a test plays to a source. Subclass it for yours, and pass it to `check_sensor`.

    Attributes:
        rate_hz: samples a second of the device.
        tells_absence: False if the source cannot tell that its device is gone.
        patience_s: longest wait for something before a check fails.
        statuses: all that the source has reported since it was started.
    """

    rate_hz = 100.0
    tells_absence = True
    patience_s = 10.0

    def __init__(self) -> None:
        self.statuses: list[Status] = []

    @abstractmethod
    def make(self) -> ImuSource:
        """Return a new source, which is not started."""

    @abstractmethod
    def plug_in(self) -> None:
        """Let the device be there. The source has been started."""

    @abstractmethod
    def unplug(self) -> None:
        """Let the device be gone, as if its cable was pulled. Harmless if it is not there."""

    @abstractmethod
    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        """Let the device measure one sample, at a time of its own clock, in m/s² and rad/s."""

    def is_heard(self) -> bool:
        """Return True once samples that the device measures will arrive."""
        return True

    def now(self) -> int:
        """Return the time of the host's clock, in ns."""
        return host_now()

    def wait(self, until: Callable[[], bool]) -> bool:
        """Let time pass until a condition holds, or patience ends; return True if it holds."""
        deadline = time.monotonic() + self.patience_s
        while not until():
            if time.monotonic() > deadline:
                return False
            time.sleep(_LOOK_S)
        return True


def check_sensor(bench: SensorBench) -> Iterator[Check]:
    """Yield a check for each part of the contract. The device is unplugged before and after."""
    for name, check in CHECKS.items():
        bench.unplug()
        yield checked(name, lambda check=check: check(bench))  # type: ignore[misc]
    bench.unplug()


class _Broken(Exception):
    """The contract is broken; the message says how."""


class _Tapped:
    """A source whose samples and statuses are kept, too."""

    def __init__(self, source: ImuSource, statuses: list[Status]) -> None:
        self.source = source
        self.samples: list[Sample] = []
        self.statuses = statuses

    @property
    def info(self) -> Info | None:
        return self.source.info

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        def keep(sample: Sample) -> None:
            self.samples.append(sample)
            sink(sample)

        def note(status: Status) -> None:
            self.statuses.append(status)
            on_status(status)

        self.source.start(keep, note)

    def stop(self) -> None:
        self.source.stop()

    def zero(self) -> None:
        self.source.zero()


class _Trial:
    """A source with its feed on a bench, and what has come of it."""

    def __init__(self, bench: SensorBench) -> None:
        self.bench = bench
        self.tap = _Tapped(bench.make(), bench.statuses)
        self.feed = ImuFeed(self.tap, bench.now)
        self.found: list[Status] = []
        self.times: list[int] = []
        self.begun = bench.now()

    def start(self) -> None:
        self.bench.statuses.clear()
        self.feed.start()

    def plug_in(self, times: int = 1) -> None:
        """Plug the device in, for the first time or again, and receive samples of it."""
        self.bench.plug_in()
        self.until(self.bench.is_heard, "the device was not heard")
        self.measure(range(COUNT))
        self.until_state("attached", times)
        self.until_samples(times * (COUNT - 1))

    def unplug(self) -> Status:
        """Unplug the device; return the report of that."""
        before = [status.state for status in self.tap.statuses].count("detached")
        self.bench.unplug()
        return self.until_state("detached", before + 1)

    def measure(self, numbers: Sequence[int]) -> None:
        for number in numbers:
            self.bench.measure(1000 * number / self.bench.rate_hz, _REST, _rate(number))
            self._drain()

    def until(self, happened: Callable[[], bool], otherwise: str) -> None:
        """Wait; raise _Broken with a sentence if it does not happen."""

        def look() -> bool:
            self._drain()
            return happened()

        if not self.bench.wait(look):
            reported = ", ".join(status.state for status in self.tap.statuses) or "nothing"
            raise _Broken(f"{otherwise[:1].upper()}{otherwise[1:]}. It reported {reported}.")

    def until_state(self, state: str, times: int = 1) -> Status:
        def happened() -> bool:
            return sum(status.state == state for status in list(self.tap.statuses)) >= times

        self.until(happened, f'it did not report "{state}"' + (" again" if times > 1 else ""))
        return [status for status in self.tap.statuses if status.state == state][times - 1]

    def until_samples(self, count: int) -> None:
        self.until(
            lambda: len(self.tap.samples) >= count, f"fewer than {count} samples were delivered"
        )

    def _drain(self) -> None:
        samples, statuses = self.feed.drain()
        self.times += samples["at"].tolist()
        self.found += statuses


@contextmanager
def _trial(bench: SensorBench) -> Iterator[_Trial]:
    trial = _Trial(bench)
    try:
        yield trial
    finally:
        trial.feed.stop()


def _need(condition: bool, otherwise: str) -> None:
    if not condition:
        raise _Broken(otherwise)


def _rate(number: int) -> Vector:
    """Return a rate by which a sample is known again."""
    return 0.5, -0.25, 0.125 * (number % 8)


def _starts_without_a_device(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.tap.stop()
        trial.tap.zero()
        trial.start()
        _need(trial.tap.info is None, "It has an info without a device.")
        trial.until(
            lambda: any(each.state in ("detached", "error") for each in trial.tap.statuses),
            "it did not report that the device is missing",
        )
        _need(bool(trial.tap.statuses[0].detail), "It does not say what it waits for.")


def _is_described(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        trial.tap.zero()
        info = trial.tap.info
        if info is None:
            raise _Broken("It has no info after it was attached.")
        _need(bool(info.source and info.model), "Its info has no source, or no model.")
        _need(
            abs(info.rate_hz - bench.rate_hz) < 0.1 * bench.rate_hz,
            f"Its info says {info.rate_hz:g} samples a second; it measures {bench.rate_hz:g}.",
        )


def _delivers_each_sample(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        samples = list(trial.tap.samples)
    first = round(samples[0].rate[2] / 0.125)
    for number, sample in enumerate(samples, first):
        expected = _rate(number)
        near = all(abs(a - b) < 0.002 for a, b in zip(sample.rate, expected, strict=True))
        _need(near, f"Sample {number} has the rate {sample.rate}; measured was {expected} rad/s.")
        size = sum(axis * axis for axis in sample.acceleration) ** 0.5
        _need(
            not abs(size - 9.81) > 0.1, f"An acceleration of 9.81 m/s² was delivered as {size:.3g}."
        )


def _has_the_clock_of_the_device(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        samples, ended = list(trial.tap.samples), bench.now()
    step = 1000 / bench.rate_hz
    for before, after in pairwise(samples):
        _need(
            abs(after.device_ms - before.device_ms - step) < 0.2,
            f"Its samples are {after.device_ms - before.device_ms:.3f} ms apart on the device's "
            f"clock, not {step:.3f}.",
        )
        _need(before.host_ns <= after.host_ns, "Its host_ns goes back.")
    in_time = trial.begun <= samples[0].host_ns and samples[-1].host_ns <= ended
    _need(in_time, "Its host_ns is not the time of arrival: use host_now().")
    _need(all(a < b for a, b in pairwise(trial.times)), "Its mapped times do not increase.")


def _shows_gaps(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        began = len(trial.tap.samples)
        trial.measure(range(COUNT + _MISSING, 2 * COUNT + _MISSING))
        trial.until_samples(began + COUNT - 1)
        lost = trial.feed.lost
        _need(lost == _MISSING, f"{_MISSING} samples are missing, and {lost} were found to be.")


def _shows_saturation(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        if info := trial.tap.info:
            if not info.rate_range_rad_s:
                return
            beyond = (1.01 * info.rate_range_rad_s, 0.0, 0.0)
            bench.measure(1000 * COUNT / bench.rate_hz, _REST, beyond)
            trial.measure(range(COUNT + 1, COUNT + 5))
            trial.until(
                lambda: any(status.state == "saturated" for status in trial.found),
                "a rate beyond its range was not reported",
            )


def _is_detached(bench: SensorBench) -> None:
    if not bench.tells_absence:
        return
    with _trial(bench) as trial:
        trial.start()
        trial.plug_in()
        status = trial.unplug()
        _need(bool(status.detail), "It does not say what it waits for after the device was gone.")
        _need(trial.tap.info is None, "It has an info after the device was gone.")


def _is_attached_again(bench: SensorBench) -> None:
    if not bench.tells_absence:
        return
    with _trial(bench) as trial:
        trial.start()
        for times in (1, 2):
            trial.plug_in(times)
            trial.unplug()
        _need(all(a < b for a, b in pairwise(trial.times)), "Its mapped times do not increase.")


def _stops(bench: SensorBench) -> None:
    with _trial(bench) as trial:
        for _ in range(2):
            trial.start()
            trial.plug_in()
            trial.tap.stop()
            trial.tap.stop()
            delivered = len(trial.tap.samples), len(trial.tap.statuses)
            trial.tap.zero()
            bench.unplug()
            now = len(trial.tap.samples), len(trial.tap.statuses)
            _need(now == delivered, "It delivers or reports after it was stopped.")


def _sentence(check: Callable[[SensorBench], None]) -> Callable[[SensorBench], str]:
    def problem(bench: SensorBench) -> str:
        try:
            check(bench)
        except _Broken as broken:
            return str(broken)
        return ""

    return problem


CHECKS: dict[str, Callable[[SensorBench], str]] = {
    name: _sentence(check)
    for name, check in {
        "starts without a device, and says what it waits for": _starts_without_a_device,
        "is described when it is attached": _is_described,
        "delivers each sample once, in order and in its unit": _delivers_each_sample,
        "has the clock of the device and the time of arrival": _has_the_clock_of_the_device,
        "lets missing samples be found": _shows_gaps,
        "lets samples beyond its range be found": _shows_saturation,
        "is detached when the device is gone": _is_detached,
        "is attached again when the device is back": _is_attached_again,
        "stops, and starts again": _stops,
    }.items()
}
