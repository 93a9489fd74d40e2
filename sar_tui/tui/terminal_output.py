"""Output to a terminal that may stop taking it: a frozen ssh client, a suspended terminal emulator.

Textual writes from a thread of its own, and waits for it when the queue is full and at the end: a
terminal that takes nothing would stop the whole program, also for a signal that asks it to end.
"""

import contextlib
import os
import select
import threading
from collections.abc import Callable
from typing import Any

from textual.driver import Driver

try:
    import termios
except ImportError:  # Windows, whose driver has no file
    termios = None  # type: ignore[assignment]

STALLED_AFTER_S = 1.0
"""A terminal that has taken nothing for this long is stalled."""
_LOOK_S = 0.2
_CANCEL = b"\x18"
"""Ends an escape sequence that was cut off (CAN, ECMA-48)."""
RESET = (
    b"\x18\x1b[?2026l\x1b[?2004l\x1b[?7h\x1b[?2048l\x1b[?1000l\x1b[?1003l\x1b[?1015l\x1b[?1006l\x1b[?1016l\x1b[<u"
    b"\x1b[?1049l\x1b[?25h\x1b[?1004l"
)
"""Undoes what Textual's driver sets, in its own order."""


class TerminalOutput:
    """File for Textual's driver that writes to a terminal, and drops output while the terminal is
    stalled.

    Args:
        fileno: file descriptor of the terminal. The terminal is opened once more, as the flag that
            keeps a write from blocking is shared by all who have inherited a descriptor, the shell
            included.
        recovered: called on another thread when a stalled terminal takes output again; what it
            shows is out of date.
        gone: called once, on another thread, when the terminal can no longer be written to.
        encoding: of the terminal.

    Attributes:
        is_stalled: True while output is dropped.

    Raises:
        OSError: it is no terminal, or cannot be opened.
    """

    def __init__(
        self,
        fileno: int,
        recovered: Callable[[], object],
        gone: Callable[[], object],
        encoding: str = "utf-8",
    ) -> None:
        self._tty = _open_again(fileno)
        self._fileno, self._encoding = fileno, encoding
        self._recovered = recovered
        self._gone: Callable[[], object] | None = gone
        self._pending: list[str] = []
        self._is_ending = threading.Event()
        self._waiting: threading.Thread | None = None
        self.is_stalled = False

    def fileno(self) -> int:
        """Return the file descriptor that was given."""
        return self._fileno

    def isatty(self) -> bool:
        """Return True."""
        return True

    def write(self, text: str) -> int:
        """Keep a text for the next flush."""
        self._pending.append(text)
        return len(text)

    def flush(self) -> None:
        """Write what is pending, or drop it if the terminal takes nothing for
        ``STALLED_AFTER_S``.
        """
        data = memoryview("".join(self._pending).encode(self._encoding, "backslashreplace"))
        self._pending.clear()
        while data and self._gone and not self.is_stalled:
            try:
                data = data[os.write(self._tty, data) :]
            except BlockingIOError:
                if not select.select([], [self._tty], [], STALLED_AFTER_S)[1]:
                    self._stall()
            except OSError:
                self._lose()

    def begin(self) -> None:
        """Begin, also after the app was suspended."""
        self._is_ending.clear()

    def end(self) -> None:
        """Begin to end: a terminal that is stalled now, or from now on, gets only what `restore`
        writes.
        """
        self._is_ending.set()
        if self._waiting:
            self._waiting.join()

    def restore(self) -> None:
        """Restore a terminal that did not take the driver's last output; it will take this when it
        goes on.
        """
        if self.is_stalled:
            with contextlib.suppress(termios.error):
                termios.tcflush(self._tty, termios.TCOFLUSH)  # makes room in the terminal's buffer
            with contextlib.suppress(OSError):
                os.write(self._tty, RESET)

    def _stall(self) -> None:
        self.is_stalled = True
        self._waiting = threading.Thread(
            target=self._wait_for_terminal, name="terminal-stalled", daemon=True
        )
        self._waiting.start()

    def _wait_for_terminal(self) -> None:
        while not self._is_ending.is_set():
            if select.select([], [self._tty], [], _LOOK_S)[1]:
                try:
                    os.write(self._tty, _CANCEL)
                except BlockingIOError:
                    continue
                except OSError:
                    self._lose()
                    return
                self.is_stalled = False
                self._recovered()
                return

    def _lose(self) -> None:
        gone, self._gone = self._gone, None
        if gone:
            gone()


def _open_again(fileno: int) -> int:
    """Return a new descriptor of a terminal. After ``su``, only the controlling terminal can be
    opened.
    """
    flags = os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK
    try:
        return os.open(os.ttyname(fileno), flags)
    except PermissionError:
        return os.open("/dev/tty", flags)


def unblocked(
    driver: type[Driver], recovered: Callable[[], object], gone: Callable[[], object]
) -> type[Driver]:
    """Return a driver class that a stalled terminal does not block. Without a known file (Windows,
    a browser) or a terminal it writes as before.

    Args:
        driver: the class Textual chose.
        recovered, gone: see `TerminalOutput`.
    """

    class Unblocked(driver):  # type: ignore[valid-type, misc]
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self._output: TerminalOutput | None = None
            if os.name == "posix" and (file := getattr(self, "_file", None)) is not None:
                with contextlib.suppress(OSError, ValueError):
                    self._file = self._output = TerminalOutput(
                        file.fileno(), recovered, gone, file.encoding
                    )

        def start_application_mode(self) -> None:
            if self._output:
                self._output.begin()
            super().start_application_mode()

        def stop_application_mode(self) -> None:
            if self._output:
                self._output.end()
            super().stop_application_mode()

        def close(self) -> None:
            super().close()
            if self._output:
                self._output.restore()

    return Unblocked
