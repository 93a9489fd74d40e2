"""Serial ports: their addresses, and opening them."""

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import serial

BAUD = 115200


def split_port(text: str) -> tuple[str, int] | None:
    """Split ``PORT[@BAUD]`` into both; None if it is invalid."""
    port, at, baud = text.rpartition("@")
    has_baud = bool(at) and baud.isascii() and baud.isdigit()
    found = (port, int(baud)) if has_baud else (text, BAUD)
    return found if found[0] and 0 < found[1] < 10_000_000 else None


def open_port(port: str, baud: int, read_s: float, write_s: float | None = None) -> "serial.Serial":
    """Open a port for this program alone.

    Raises OSError or ValueError (`why_not` has the reason), and ImportError without pyserial.

    Args:
        read_s: longest wait for a byte.
        write_s: longest wait for a line that takes no more bytes.
    """
    import serial

    return serial.Serial(port, baud, timeout=read_s, write_timeout=write_s, exclusive=True)


def why_not(error: Exception) -> str:
    """Return the system's words for an error, which pyserial puts into a sentence of its own."""
    original = error.__context__ if isinstance(error.__context__, OSError) else error
    number = getattr(original, "errno", None)
    return os.strerror(number) if isinstance(number, int) else str(error)
