"""A motion sensor that another program sends as a stream of the Lab Streaming Layer (LSL)."""

import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, Literal
from urllib.parse import parse_qsl, unquote

import msgspec
from msgspec import Meta

from sar_tui.drivers.lsl import NoLibrary, library
from sar_tui.inputs.delivery import Absent, Delivery, ReadSource, Unusable
from sar_tui.inputs.imu import (
    ACCELERATION_UNITS,
    NOTHING,
    RATE_UNITS,
    Info,
    Sample,
    SourceError,
    Vector,
)
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Sentence
from sar_tui.model.visible_text import visible

LOOK_S = 0.5
"""Time to look for the stream before saying that it is missing."""
_INFO_S = 2.0
"""Longest wait for the description of a stream."""
_PULL_S = 0.1
_MOST = 1024
_GAIN, _RATE_GAIN = 0.02, 0.0001
"""Parts of a deviation by which a stamp, and the time between two, are corrected."""
_FIRST_DEVIATION_S = 0.01
_FORGOTTEN = 0.002
"""Part of the largest deviation that is forgotten with each sample."""
_RESTART_S = 0.2
_NO_ADDRESS = (
    'There is no sensor "lsl:{address}". Use lsl://NAME with the name of the stream, and after '
    "it, if its channels do not say which is which, "
    "?columns=ax,ay,az,wx,wy,wz&rate=deg/s&acceleration=g."
)
_LABELS = {
    "w": re.compile(r"(?:gyro?(?:scope)?|rate|angular.*|omega|w)[ _.:-]*([xyz])"),
    "a": re.compile(r"(?:acc(?:el)?(?:eration|erometer)?|a)[ _.:-]*([xyz])"),
}
_UNITS = {
    "rad/s": "rad/s", "deg/s": "deg/s", "dps": "deg/s", "°/s": "deg/s", "degrees/second": "deg/s",
    "radians/second": "rad/s", "m/s2": "m/s2", "m/s^2": "m/s2", "m/s²": "m/s2", "g": "g",
    "meters/second^2": "m/s2",
}  # fmt: skip
_NO_CHANNELS = (
    "The channels of the stream {} do not say which is the angular rate: their labels are {}. Name "
    "them in order, with their units: lsl://{}?columns=ax,ay,az,wx,wy,wz&rate=deg/s&acceleration=g"
)
_NO_UNIT = (
    "The stream {} does not say the unit of its {}: add ?rate=deg/s or rad/s, and &acceleration=g "
    "or m/s2, to the name of the sensor."
)
_NOT_RISING = "The time stamps of the stream do not increase, so the sample rate is unknown."


class _Options(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Options after the question mark."""

    columns: Annotated[str, Meta(pattern=r"^[a-z0-9_]*(,[a-z0-9_]*)*$")] = ""
    rate: Literal["rad/s", "deg/s"] | None = None
    acceleration: Literal["m/s2", "g"] | None = None


class LslSource(ReadSource):
    """A stream of LSL as a source of samples. The sender's time stamps are the device's clock:
    evened out, if the stream has a nominal rate.

    Channels are known by their labels (``GyroX``, ``acc_x``, ``wz``) and units, or by the options.

    Args:
        address: ``//NAME[?columns=NAME,…&rate=UNIT&acceleration=UNIT]``. Raises SourceError for
            anything else.
    """

    def __init__(self, address: str) -> None:
        name, _, query = address.strip().removeprefix("//").partition("?")
        try:
            self._stream = unquote(name)
            options = dict(parse_qsl(query, strict_parsing=bool(query)))
            self._options = msgspec.convert(options, _Options)
        except ValueError as error:
            raise SourceError(Sentence(_NO_ADDRESS, address=address)) from error
        if not self._stream or "'" in self._stream:
            raise SourceError(Sentence(_NO_ADDRESS, address=address))
        super().__init__(Delivery(self._described, _NOT_RISING), "lsl")

    def _described(self, rate_hz: float, has_acceleration: bool) -> Info:
        return Info(
            source=f"lsl:{self._stream}",
            model=f"LSL stream {visible(self._stream)[:40]}",
            rate_hz=rate_hz,
            has_acceleration=has_acceleration,
        )

    def _read(self, stopped: threading.Event) -> None:
        try:
            pylsl = library()
        except NoLibrary as error:
            raise Unusable(str(error)) from error
        found = pylsl.resolve_byprop("name", self._stream, 1, LOOK_S)
        waiting = (
            f"Waiting for the LSL stream {visible(self._stream)}: start the program that sends it."
        )
        if not found:
            raise Absent(waiting)
        with _inlet(pylsl, found[0]) as inlet:
            try:
                info = inlet.info(_INFO_S)
                columns = Columns(self._stream, *_channels(info), self._options)
                if stopped.is_set():
                    return
                self.delivery.wait(waiting)
                even = EvenStamps(info.nominal_srate())
                while not stopped.is_set():
                    # a request for many would wait for all of them
                    chunk, stamps = inlet.pull_chunk(_PULL_S, 1)
                    rest, later = inlet.pull_chunk(0.0, _MOST)
                    came_ns = host_now()
                    if stopped.is_set():
                        return
                    for values, stamp_s in zip(chunk + rest, stamps + later, strict=True):
                        device_ms = even.ms(stamp_s)
                        self.delivery.put(Sample(came_ns, device_ms, *columns.read(values)))
            except RuntimeError as error:  # LSL's own: the stream is lost, or does not answer
                raise Absent(waiting) from error


@contextmanager
def _inlet(pylsl: Any, stream: Any) -> Iterator[Any]:
    """Open a stream. One that is lost is looked for anew by us, as its clock may be another."""
    inlet = pylsl.StreamInlet(stream, max_buflen=5, recover=False)
    try:
        yield inlet
    finally:
        inlet.close_stream()


class EvenStamps:
    """Evens out the time stamps of a stream, in ms since its first.

    Many senders stamp a chunk of samples when it arrives from the sensor, so that the stamps are
    early and late by some ms, and may go back. Each sample is taken to be due one interval after
    the one before; its deviation corrects it, and the interval, by a small part (a phase-locked
    loop of second order). A sample that is later than usual shows that others are missing: its
    stamp is taken as it is. Stamps that deviate by nothing stay as they are.

    Args:
        rate_hz: nominal rate of the stream; 0 if it has none: its stamps stay as they are, too.
    """

    def __init__(self, rate_hz: float) -> None:
        self._interval_s = 1 / rate_hz if rate_hz > 0 else 0.0
        self._largest_s = _FIRST_DEVIATION_S
        self._origin_s: float | None = None
        self._last_s = 0.0

    def ms(self, stamp_s: float) -> float:
        """Return the time of the next sample."""
        if self._origin_s is None:
            self._origin_s = self._last_s = stamp_s
        elif self._interval_s:
            self._last_s = self._evened(stamp_s)
        else:
            self._last_s = stamp_s
        return (self._last_s - self._origin_s) * 1000

    def _evened(self, stamp_s: float) -> float:
        due_s = self._last_s + self._interval_s
        deviation_s = stamp_s - due_s
        if not -_RESTART_S < deviation_s < self._interval_s / 2 + 3 * self._largest_s:
            return stamp_s
        self._largest_s = max(abs(deviation_s), (1 - _FORGOTTEN) * self._largest_s)
        self._interval_s += _RATE_GAIN * deviation_s
        return due_s + _GAIN * deviation_s


class Columns:
    """Channels of a stream that hold rate and acceleration, and their units.

    Args:
        name: of the stream.
        labels, units: of its channels.
        options: what the name of the sensor says of them. Raises Unusable if it is not enough.
    """

    def __init__(
        self, name: str, labels: Sequence[str], units: Sequence[str], options: _Options
    ) -> None:
        names = options.columns.split(",") if options.columns else [_known(each) for each in labels]
        where = {each: number for number, each in enumerate(names) if each}
        shown = visible(name)
        if not {"wx", "wy", "wz"} <= set(where) or len(names) > len(labels):
            listed = visible(", ".join(filter(None, labels))) or "missing"
            raise Unusable(_NO_CHANNELS.format(shown, listed, shown))
        self._rate = [where[f"w{axis}"] for axis in "xyz"]
        self._has_acceleration = {"ax", "ay", "az"} <= set(where)
        self._acceleration = [where.get(f"a{axis}", 0) for axis in "xyz"]
        rate = options.rate or _UNITS.get(units[self._rate[0]].strip().lower(), "")
        if rate not in RATE_UNITS:
            raise Unusable(_NO_UNIT.format(shown, "angular rate"))
        self._by_rate = RATE_UNITS[rate]
        given = options.acceleration or _UNITS.get(units[self._acceleration[0]].strip().lower(), "")
        if self._has_acceleration and given not in ACCELERATION_UNITS:
            raise Unusable(_NO_UNIT.format(shown, "acceleration"))
        self._by_acceleration = ACCELERATION_UNITS.get(given, 1.0)

    def read(self, values: Sequence[Any]) -> tuple[Vector, Vector]:
        """Return acceleration (m/s²) and rate (rad/s) of a sample."""
        x, y, z = (self._by_rate * float(values[each]) for each in self._rate)
        if not self._has_acceleration:
            return NOTHING, (x, y, z)
        ax, ay, az = (self._by_acceleration * float(values[each]) for each in self._acceleration)
        return (ax, ay, az), (x, y, z)


def _known(label: str) -> str:
    """Return the name of a channel as recordings have it: ``wx`` for ``GyroX``."""
    for kind, pattern in _LABELS.items():
        if match := pattern.fullmatch(label.strip().lower()):
            return kind + match[1]
    return ""


def _channels(info: Any) -> tuple[list[str], list[str]]:
    """Return the labels and the units of a stream's channels; empty where it has none."""
    labels, units = [], []
    channel = info.desc().child("channels").child("channel")
    for _ in range(info.channel_count()):
        labels.append(channel.child_value("label"))
        units.append(channel.child_value("unit"))
        channel = channel.next_sibling("channel")
    return labels, units
