"""A guard around a plug-in's sensor: errors and values of a wrong type are reported, and do not end
the program.
"""

from collections.abc import Callable
from math import isfinite, nan
from numbers import Integral, Real
from typing import Any, TypeVar

import msgspec

from sar_tui.inputs.imu import ImuSource, Info, Sample, Status, Vector
from sar_tui.loop.clock import host_now
from sar_tui.plugin_calls import PLUGIN_ERRORS

_T = TypeVar("_T", bound=msgspec.Struct)
_LAST_NS = 2**63 - 1
_UNREADABLE = Sample(0, nan, (), (), ())  # type: ignore[arg-type]
"""Stands for a sample of a wrong type: the feed leaves it out, and reports it, as any sample of a
wrong length.
"""


class GuardedSource:
    """A source that keeps its contract, whatever the source of a plug-in does.

    Args:
        plug_in: the source of the plug-in.
        name: its name, for the reports.
    """

    def __init__(self, plug_in: ImuSource, name: str) -> None:
        self.plug_in = plug_in
        self._name = name
        self._report: Callable[[Status], None] = lambda status: None

    @property
    def info(self) -> Info | None:
        """Description of the sensor; None until it is attached, or if it cannot be read."""
        try:
            return _read_info(self.plug_in.info)
        except PLUGIN_ERRORS:
            return None

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Start delivering samples; a failure is a status."""
        self._report = on_status

        def deliver(sample: object) -> None:
            sink(_read_sample(sample))

        try:
            self.plug_in.start(deliver, self._status)
        except PLUGIN_ERRORS as error:
            self._fail("cannot be started", error)

    def stop(self) -> None:
        """Stop delivering; a failure is a status."""
        try:
            self.plug_in.stop()
        except PLUGIN_ERRORS as error:
            self._fail("cannot be stopped", error)

    def zero(self) -> None:
        """Take the present angular rate as zero; a failure is a status."""
        try:
            self.plug_in.zero()
        except PLUGIN_ERRORS as error:
            self._fail("cannot be zeroed", error)

    def _status(self, status: Any) -> None:
        """Pass a status on if it can be read, and the description of a sensor that is attached,
        too.
        """
        try:
            read = _read_status(status)
            if read.state == "attached":
                _read_info(self.plug_in.info)
        except PLUGIN_ERRORS as error:
            self._fail("does not keep its contract", error)
        else:
            self._report(read)

    def _fail(self, what: str, error: BaseException) -> None:
        why = f"{type(error).__name__}: {error}"
        self._report(
            Status(state="error", at=host_now(), detail=f"The sensor {self._name} {what} ({why}).")
        )


def _read_info(info: Any) -> Info | None:
    """Return a description with every field of its type. Raises an error if it is none."""
    if info is None:
        return None
    read = _converted(info, Info)
    if not all(map(isfinite, (read.rate_hz, read.rate_range_rad_s, read.acceleration_range_m_s2))):
        raise ValueError("a number in its Info is not finite")
    return read


def _read_status(status: Any) -> Status:
    """Return a status with every field of its type. Raises an error if it is none."""
    read = _converted(status, Status)
    if abs(read.at) > _LAST_NS or abs(read.count) > _LAST_NS or not isfinite(read.duration_ms):
        raise ValueError("a number in its Status is too large")
    return read


def _converted(value: Any, kind: type[_T]) -> _T:
    if not isinstance(value, kind):
        raise TypeError(f"{type(value).__name__} in place of {kind.__name__}")
    fields = {name: _plain(each) for name, each in msgspec.structs.asdict(value).items()}
    return msgspec.convert(fields, kind)


def _plain(value: Any) -> Any:
    """Return a number of a library as Python's."""
    if isinstance(value, Integral):
        return value if isinstance(value, bool) else int(value)
    return float(value) if isinstance(value, Real) else value


def _read_sample(sample: Any) -> Sample:
    """Return a sample of numbers of Python, or one that the feed leaves out."""
    try:
        host_ns, device_ms, acceleration, rate, field = sample
        if (
            isinstance(host_ns, Integral)
            and isinstance(device_ms, Real)
            and 0 <= int(host_ns) <= _LAST_NS
        ):
            vectors = _vector(acceleration), _vector(rate), _vector(field)
            return Sample(int(host_ns), float(device_ms), *vectors)
    except (TypeError, ValueError, OverflowError):
        pass
    return _UNREADABLE._replace(host_ns=host_now())


def _vector(values: Any) -> Vector:
    """Return three floats. Raises TypeError or ValueError if they are not three numbers."""
    if not all(isinstance(value, Real) for value in values):
        raise TypeError
    x, y, z = values
    return float(x), float(y), float(z)
