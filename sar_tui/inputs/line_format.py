"""Lines of text from a motion sensor, and what they mean.

A line is ``time, three rates, three accelerations``, or without the accelerations. A header line,
``# t=us rate=deg/s acceleration=g``, names the units; it is repeated, as the sensor may have begun
earlier than its listener.
"""

import re
from collections.abc import Iterator
from typing import Literal
from urllib.parse import parse_qsl

import msgspec

from sar_tui.inputs.imu import ACCELERATION_UNITS, NOTHING, RATE_UNITS, Sample
from sar_tui.model.visible_text import visible

HEADER = "# t=us rate=deg/s acceleration=g"
"""Example of a header."""
WITHOUT_UNITS = 200
"""Lines without a header before it is asked for."""

_LONGEST = 500
_LATEST = 2.0**53
"""Above this, a time has lost its last digits. That of a clock in microseconds is below."""
_TIME_MS = {"s": 1000.0, "ms": 1.0, "us": 0.001}
_WRAPS = (1 << 30, 1 << 32)
"""Sizes of the counters of boards: ``ticks_us`` of MicroPython, ``micros`` of Arduino."""
_WRAP_MS = 10_000.0
"""A step across that is shorter than this."""
_NO_LINE = (
    'This is no line of a time, three rates and three accelerations: "{}". Such lines are left out.'
)
_NO_HEADER = (
    'This header is not valid: "{}". It names the units: t=s, ms or us; rate=rad/s or deg/s; '
    "acceleration=m/s2 or g."
)
_NO_UNITS = (
    f'The lines do not name their units: send the line "{HEADER}" once a second, or add '
    "?t=us&rate=deg/s&acceleration=g to the name of the sensor, in quotation marks."
)


class Units(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Units of the numbers in a line."""

    t: Literal["s", "ms", "us"]
    rate: Literal["rad/s", "deg/s"]
    acceleration: Literal["m/s2", "g"] = "m/s2"


def units_of(query: str) -> Units | None:
    """Return the units that an address names after its question mark; None if it names none.

    Raises ValueError.
    """
    if not query:
        return None
    options = dict(parse_qsl(query, keep_blank_values=True, strict_parsing=True))
    return msgspec.convert(options, Units)


class Lines:
    """Reads samples from lines, whatever else they hold.

    Args:
        units: of the lines; None if a header names them.
    """

    def __init__(self, units: Units | None = None) -> None:
        self._units = units
        self._rest = b""
        self._unread = 0
        self._origin: float | None = None
        self._last = self._wrapped = 0.0

    def take(self, received: bytes, host_ns: int) -> Iterator[Sample | str]:
        """Yield samples in order, and between them what is wrong, as sentences."""
        *lines, rest = (self._rest + received).split(b"\n")
        self._rest = rest if len(rest) <= _LONGEST else b""
        if not self._rest and rest:
            lines.append(rest)
        for line in lines:
            found = self._line(line.strip(), host_ns)
            if found:
                yield found

    def _line(self, line: bytes, host_ns: int) -> Sample | str | None:
        if line.startswith(b"#"):
            return self._header(line)
        if not line:
            return None
        try:
            numbers = [float(each) for each in re.split(rb"[,;\s]+", line)]
        except ValueError:
            numbers = []
        if len(numbers) not in (4, 7) or not abs(numbers[0]) < _LATEST:
            return _NO_LINE.format(_shown(line))
        if self._units is None:
            self._unread += 1
            return _NO_UNITS if self._unread > WITHOUT_UNITS else None
        by_rate = RATE_UNITS[self._units.rate]
        by_acceleration = ACCELERATION_UNITS[self._units.acceleration]
        x, y, z = (by_rate * each for each in numbers[1:4])
        acceleration = NOTHING
        if len(numbers) == 7:
            ax, ay, az = (by_acceleration * each for each in numbers[4:])
            acceleration = ax, ay, az
        return Sample(host_ns, self._time_ms(numbers[0], self._units), acceleration, (x, y, z))

    def _header(self, line: bytes) -> str | None:
        pairs = [each.partition(b"=") for each in line[1:].split()]
        if not any(sign for _, sign, _ in pairs):
            return None  # a comment
        try:
            named = {name.decode(): value.decode() for name, _, value in pairs}
            units = msgspec.convert(named, Units)
        except (UnicodeDecodeError, msgspec.ValidationError):
            return _NO_HEADER.format(_shown(line))
        if units != self._units:
            self._units, self._origin = units, None
        return None

    def _time_ms(self, time: float, units: Units) -> float:
        """Return a time in ms since the first one, across an overflow of the board's counter."""
        in_ms = _TIME_MS[units.t]
        if self._origin is None:
            self._origin, self._wrapped = time, 0.0
        elif time < self._last:
            for size in _WRAPS:
                if 0 < (time + size - self._last) * in_ms < _WRAP_MS:
                    self._wrapped += size
        self._last = time
        return (time + self._wrapped - self._origin) * in_ms


def _shown(line: bytes) -> str:
    return visible(line[:60].decode("utf-8", "replace"))
