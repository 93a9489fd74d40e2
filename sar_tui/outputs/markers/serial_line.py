"""Markers on a serial line: a byte each for trigger boxes, or a line of JSON each."""

import contextlib
import time
from importlib.util import find_spec
from typing import TYPE_CHECKING, NoReturn
from urllib.parse import parse_qsl

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.drivers.serial_port import open_port, split_port, why_not
from sar_tui.outputs.markers.marker import CODES, Marker, MarkerError

if TYPE_CHECKING:
    import serial

_PREFIX = "serial:"
_PULSE_MS = 10
_LONGEST_PULSE_MS = 1000
_WRITE_SECONDS = 0.5
"""Longest wait for a line that takes no more bytes."""


class SerialLine:
    """Sends markers to ``serial:PORT[@BAUD][?OPTION=VALUE&…]``. Raises MarkerError if the address
    is invalid.

    Options: ``form`` is ``bytes`` (default: the code of the event) or ``lines`` (JSON); ``pulse``:
    milliseconds after which a 0 follows each code, 0 for none; the name of an event: another code
    for it, 0 for none.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        place, _, options = address.removeprefix(_PREFIX).partition("?")
        if not address.startswith(_PREFIX) or not (found := split_port(place)):
            self._refuse("use serial:PORT or serial:PORT@BAUD, such as serial:/dev/ttyUSB0@115200")
        self._port, self._baud = found
        self._codes = dict(CODES)
        self._pulse_ms, self._sends_lines = _PULSE_MS, False
        for name, value in parse_qsl(options, keep_blank_values=True):
            self._set(name, value)
        self._line: serial.Serial | None = None

    def _set(self, name: str, value: str) -> None:
        number = int(value) if value.isascii() and value.isdigit() and len(value) < 6 else -1
        if name == "form" and value in ("bytes", "lines"):
            self._sends_lines = value == "lines"
        elif name == "pulse" and 0 <= number <= _LONGEST_PULSE_MS:
            self._pulse_ms = number
        elif name in CODES and 0 <= number <= 255:
            self._codes[name] = number
        elif name in CODES:
            self._refuse(f"the code of {name} is a number from 0 to 255")
        else:
            self._refuse(
                "form=bytes or form=lines, pulse=MILLISECONDS, or an event with its code, but "
                f"not {name}={value}"
            )

    def _refuse(self, how: str) -> NoReturn:
        raise MarkerError(f"{self.address!r} is no address for markers: {how}.")

    def check(self) -> None:
        """Raise MarkerError if the package or the port is missing, or the port is not ours to
        open.
        """
        if find_spec("serial") is None:
            raise MarkerError(no_package())
        self.open("", "")
        self.close()

    def open(self, session: str, task: str) -> str:
        try:
            self._line = open_port(self._port, self._baud, 0, _WRITE_SECONDS)
        except (OSError, ValueError) as error:  # serial.SerialException is an OSError
            raise MarkerError(
                f"The serial port {self._port} cannot be opened ({why_not(error)}). Plug the "
                "trigger box in, see that you may use it (on Linux: the group dialout), and close "
                "other programs that use it."
            ) from error
        return ""

    def send(self, marker: Marker) -> bool:
        assert self._line
        try:
            if self._sends_lines:
                self._line.write(f"{marker.text}\n".encode())
            elif code := self._codes[marker.event]:
                self._line.write(bytes([code]))
                if self._pulse_ms:
                    time.sleep(self._pulse_ms / 1000)
                    self._line.write(b"\0")
        except OSError as error:
            raise MarkerError(
                f"The serial port {self._port} takes no markers ({why_not(error)})."
            ) from error
        return True

    def close(self) -> str:
        line, self._line = self._line, None
        if line:
            with contextlib.suppress(OSError):
                line.close()
        return ""


def no_package() -> str:
    """Return the sentence that says how to install what is missing."""
    return (
        "Markers on a serial line need a package that is not installed here: "
        f"{pip_install_extra('serial')}"
    )
