"""A motion sensor that sends a line of text for each sample: over UDP, or a serial line.

A line is ``time, three rates, three accelerations``, or without the accelerations. A header line,
``# t=us rate=deg/s acceleration=g``, names the units; it is repeated, as the sensor may have begun
earlier than its listener.
"""

import contextlib
import errno
import re
import socket
import threading
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import closing
from importlib.util import find_spec
from typing import TYPE_CHECKING, Literal, Protocol
from urllib.parse import parse_qsl, urlsplit

import msgspec

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.drivers.serial_port import open_port, split_port, why_not
from sar_tui.inputs.delivery import Absent, Delivery, ReadSource, Unusable
from sar_tui.inputs.imu import ACCELERATION_UNITS, NOTHING, RATE_UNITS, Info, Sample, SourceError
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Sentence
from sar_tui.model.units import SECOND
from sar_tui.model.visible_text import visible

if TYPE_CHECKING:
    import serial

HEADER = "# t=us rate=deg/s acceleration=g"
"""Example of a header."""
SILENCE = 3 * SECOND
"""A sensor that has sent no line for this long is gone."""
WITHOUT_UNITS = 200
"""Lines without a header before it is asked for."""

_READ_S = 0.1
_LONGEST = 500
_TIME_MS = {"s": 1000.0, "ms": 1.0, "us": 0.001}
_WRAPS = (1 << 30, 1 << 32)
"""Sizes of the counters of boards: ``ticks_us`` of MicroPython, ``micros`` of Arduino."""
_WRAP_MS = 10_000.0
"""A step across that is shorter than this."""
_NO_UDP = (
    'There is no sensor "udp:{address}". Use udp://:PORT or udp://HOST:PORT, such as udp://:5005, '
    "and after it, if no header names the units, ?t=us&rate=deg/s&acceleration=g."
)
_NO_SERIAL = (
    'There is no sensor "serial:{address}". Use serial://PORT[@BAUD], such as '
    "serial:///dev/ttyUSB0@500000, and after it, if no header names the units, "
    "?t=us&rate=deg/s&acceleration=g."
)
_NO_LINE = (
    'This is no line of a time, three rates and three accelerations: "{}". Such lines are left out.'
)
_NO_HEADER = (
    'This header is not valid: "{}". It names the units: t=s, ms or us; rate=rad/s or deg/s; '
    "acceleration=m/s2 or g."
)
_NO_UNITS = (
    f'The lines do not name their units: send the line "{HEADER}" once a second, or add '
    "?t=us&rate=deg/s&acceleration=g to the name of the sensor."
)
_NOT_RISING = "The times in the lines do not increase, so the sample rate is unknown."


class Units(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Units of the numbers in a line."""

    t: Literal["s", "ms", "us"]
    rate: Literal["rad/s", "deg/s"]
    acceleration: Literal["m/s2", "g"] = "m/s2"


class Line(Protocol):
    """An open connection to a sensor."""

    def read(self) -> bytes:
        """Return what has arrived, after a tenth of a second at most. Raises Absent."""
        ...

    def forget(self) -> None:
        """Forget the sensor, which has fallen silent."""
        ...

    def close(self) -> None:
        """Close it."""
        ...


class LineSource(ReadSource):
    """A sensor that sends lines. Those that are broken are missing: the feed finds them in the
    time stamps.

    Args:
        place: the name of its connection.
        units: of its lines; None if their header names them.
    """

    def __init__(self, place: str, units: Units | None) -> None:
        self.place = place
        self._units = units
        super().__init__(Delivery(self._described, _NOT_RISING), "lines")

    @abstractmethod
    def open(self) -> Line:
        """Open the connection. Raises Absent or Unusable."""

    def _described(self, rate_hz: float, has_acceleration: bool) -> Info:
        return Info(
            source=self.place,
            model="Lines of text",
            rate_hz=rate_hz,
            has_acceleration=has_acceleration,
        )

    def _read(self, stopped: threading.Event) -> None:
        waiting = f"Waiting for lines of a sensor on {self.place}."
        with closing(self.open()) as line:
            self.delivery.wait(waiting)
            lines = Lines(self._units)
            heard_ns = host_now()
            while not stopped.is_set():
                received = line.read()
                came_ns = host_now()
                if stopped.is_set():
                    return
                for found in lines.take(received, came_ns):
                    if isinstance(found, Sample):
                        self.delivery.put(found)
                    else:
                        self.delivery.complain(found)
                if received:
                    heard_ns = came_ns
                elif self.info and came_ns - heard_ns > SILENCE:
                    self.delivery.wait(waiting)
                    lines = Lines(self._units)
                    line.forget()


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
        if len(numbers) not in (4, 7) or not abs(numbers[0]) < 1e15:
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


def _units(query: str) -> Units | None:
    """Return the units in an address; None if it names none. Raises ValueError."""
    if not query:
        return None
    options = dict(parse_qsl(query, keep_blank_values=True, strict_parsing=True))
    return msgspec.convert(options, Units)


# --- UDP


class UdpSource(LineSource):
    """A sensor that sends its lines to a UDP port of this computer, one or more in a datagram.

    Args:
        address: ``//[HOST]:PORT[?UNITS]``; HOST is the address of this computer at which to listen,
            by default one that only this computer reaches. Raises SourceError for anything else.
    """

    def __init__(self, address: str) -> None:
        try:
            parts = urlsplit(address.strip())
            if (
                parts.scheme not in ("", "udp")
                or parts.username
                or parts.path not in ("", "/")
                or not parts.port
            ):
                raise ValueError
            units = _units(parts.query)
            self._host, self._port = parts.hostname or "127.0.0.1", parts.port
        except ValueError as error:
            raise SourceError(Sentence(_NO_UDP, address=address)) from error
        super().__init__(f"udp://{self._host}:{self._port}", units)

    def open(self) -> Line:
        """Listen on the port. Raises Unusable."""
        try:
            family, kind, _, _, place = socket.getaddrinfo(
                self._host, self._port, type=socket.SOCK_DGRAM, flags=socket.AI_PASSIVE
            )[0]
            port = socket.socket(family, kind)
            with contextlib.ExitStack() as unless_bound:
                unless_bound.callback(port.close)
                port.bind(place)
                port.settimeout(_READ_S)
                unless_bound.pop_all()
        except OSError as error:
            raise Unusable(
                f"The address {self.place} cannot be listened on ({error.strerror}). Close other "
                "programs that use it, or name another one."
            ) from error
        return _Datagrams(port)


class _Datagrams:
    """Datagrams of one sender: a second one at the same port would mix its samples in."""

    def __init__(self, port: socket.socket) -> None:
        self._port = port
        self._sender: object = None

    def read(self) -> bytes:
        try:
            datagram, sender = self._port.recvfrom(65535)
        except TimeoutError:
            return b""
        except OSError as error:  # on Windows, that an earlier reply was not received
            raise Absent(f"The network port fails ({error.strerror}).") from error
        self._sender = self._sender or sender
        return datagram + b"\n" if sender == self._sender else b""

    def forget(self) -> None:
        self._sender = None

    def close(self) -> None:
        self._port.close()


# --- a serial line


class SerialSource(LineSource):
    """A sensor on a serial line, such as the USB port of a microcontroller.

    Args:
        address: ``[//]PORT[@BAUD][?UNITS]``. Raises SourceError for anything else.
    """

    def __init__(self, address: str) -> None:
        place, _, query = address.strip().removeprefix("//").partition("?")
        try:
            found, units = split_port(place), _units(query)
        except ValueError:
            found = None
        if not found:
            raise SourceError(Sentence(_NO_SERIAL, address=address))
        self._port, self._baud = found
        super().__init__(f"serial:{self._port}", units)

    def open(self) -> Line:
        """Open the port. Raises Absent or Unusable."""
        if find_spec("serial") is None:
            raise Unusable(
                "A sensor on a serial line needs a package that is not installed here: "
                f"{pip_install_extra('serial')}"
            )
        try:
            return _Port(open_port(self._port, self._baud, _READ_S), self._port)
        except (OSError, ValueError) as error:  # serial.SerialException is an OSError
            if getattr(error, "errno", None) == errno.ENOENT:
                raise Absent(
                    f"Waiting for the serial port {self._port}: plug the board in."
                ) from error
            raise Unusable(
                f"The serial port {self._port} cannot be opened ({why_not(error)}). See that you "
                "may use it (on Linux: the group dialout), and close other programs that use it."
            ) from error


class _Port:
    def __init__(self, line: "serial.Serial", name: str) -> None:
        self._line = line
        self._name = name
        self._is_whole = False

    def read(self) -> bytes:
        try:
            received: bytes = self._line.read(max(1, self._line.in_waiting))
        except OSError as error:
            raise Absent(
                f"The serial port {self._name} is gone ({why_not(error)}): plug the board in again."
            ) from error
        if not self._is_whole and received:  # the first line may have begun before
            _, end, received = received.partition(b"\n")
            self._is_whole = bool(end)
        return received

    def forget(self) -> None:
        self._is_whole = False

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._line.close()
