"""A motion sensor that sends a line of text for each sample: over UDP, or a serial line."""

import contextlib
import errno
import socket
import threading
from abc import abstractmethod
from contextlib import closing
from importlib.util import find_spec
from typing import TYPE_CHECKING, Protocol

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.drivers.serial_port import open_port, split_port, why_not
from sar_tui.inputs.delivery import Absent, Delivery, ReadSource, Unusable
from sar_tui.inputs.imu import Info, Sample, SourceError
from sar_tui.inputs.line_format import Lines, Units, units_of
from sar_tui.inputs.network_address import bracketed, split_address
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Sentence
from sar_tui.model.units import SECOND

if TYPE_CHECKING:
    import serial

SILENCE = 3 * SECOND
"""A sensor that has sent no line for this long is gone."""

_READ_S = 0.1
_NO_UDP = (
    'There is no sensor "udp:{address}". Use udp://:PORT or udp://HOST:PORT, such as udp://:5005, '
    "and after it, if no header names the units, ?t=us&rate=deg/s&acceleration=g."
)
_NO_SERIAL = (
    'There is no sensor "serial:{address}". Use serial://PORT[@BAUD], such as '
    "serial:///dev/ttyUSB0@500000, and after it, if no header names the units, "
    "?t=us&rate=deg/s&acceleration=g."
)
_NOT_RISING = "The times in the lines do not increase, so the sample rate is unknown."


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
            if stopped.is_set():
                return
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
                elif came_ns - heard_ns > SILENCE:
                    heard_ns = came_ns
                    self.delivery.wait(waiting)
                    lines = Lines(self._units)
                    line.forget()


# --- UDP


class UdpSource(LineSource):
    """A sensor that sends its lines to a UDP port of this computer, one or more in a datagram.

    Args:
        address: ``//[HOST]:PORT[?UNITS]``; HOST is the address of this computer at which to listen,
            by default one that only this computer reaches. Raises SourceError for anything else.
    """

    def __init__(self, address: str) -> None:
        try:
            host, port, query = split_address(address, "udp")
            units = units_of(query)
        except ValueError:
            port = None
        if not port:
            raise SourceError(Sentence(_NO_UDP, address=address))
        self._host, self._port = host or "127.0.0.1", port
        super().__init__(f"udp://{bracketed(self._host)}:{port}", units)

    def open(self) -> Line:
        """Listen on the port. Raises Unusable."""
        try:
            found = socket.getaddrinfo(
                self._host, self._port, type=socket.SOCK_DGRAM, flags=socket.AI_PASSIVE
            )
            # a name may have several addresses; boards send to the one of IPv4
            family, kind, _, _, place = min(found, key=lambda each: each[0] != socket.AF_INET)
            port = socket.socket(family, kind)
            with contextlib.ExitStack() as unless_bound:
                unless_bound.callback(port.close)
                port.bind(place)
                port.settimeout(_READ_S)
                unless_bound.pop_all()
        except OSError as error:
            raise Unusable(
                f"{self.place} cannot be listened on ({error.strerror}). Name an address of this "
                "computer, such as udp://0.0.0.0:5005, and a port that no other program uses."
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
            found, units = split_port(place), units_of(query)
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
                f"The serial port {self._name} is gone: plug the board in again."
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
