"""A terminal in which lines are appended, and single keys are read: nothing else is written to it.

Screen readers and braille lines follow it, because no text is ever drawn again.
"""

import asyncio
import codecs
import contextlib
import os
import select
import sys
import threading
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Any

from textual.events import Key
from textual.message import Message

from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND
from sar_tui.model.visible_text import visible
from sar_tui.tui.terminal_input import TolerantParser

_POLL_S = 0.1
"""Longest time until the reading thread notices that it is to end."""
_CONSOLE_POLL_S = 0.005
"""Time between two looks for a key in a console of Windows, which has nothing to wait for."""
_CONSOLE = {
    "H": "up",
    "P": "down",
    "M": "right",
    "K": "left",
    "G": "home",
    "O": "end",
    "<": "f2",
    "\x86": "f12",
}
"""Names of the keys for which a console of Windows sends two characters, by the second."""


class PlainTerminal:
    """Appends lines to the standard output, and reads keys in a thread. A context manager that
    restores the terminal.

    Keys have the names and stamps that they have on any other screen.

    Args:
        on_input: called with each key, and with what else the parser reads, on the loop's thread.
        on_lost: called there once if the terminal is gone.

    Attributes:
        is_line_open: True after a text that did not end its line.
    """

    def __init__(
        self, on_input: Callable[[Message], object], on_lost: Callable[[], object]
    ) -> None:
        self._on_input, self._on_lost = on_input, on_lost
        self._loop = asyncio.get_running_loop()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._read, name="plain keys", daemon=True)
        self._parser = TolerantParser()
        self._before: list[Any] = []
        self.is_line_open = False

    def write(self, text: str) -> int:
        """Append a text as a line of its own, and return when it had reached the terminal (ns)."""
        self.end_line()
        self._append(f"{visible(text)}\n")
        return host_now()

    def extend(self, text: str) -> None:
        """Append a text without ending its line."""
        if text:
            self.is_line_open = True
            self._append(visible(text))

    def end_line(self) -> None:
        """End the line that was extended, if there is one."""
        if self.is_line_open:
            self.is_line_open = False
            self._append("\n")

    def _append(self, text: str) -> None:
        try:
            sys.stdout.write(text)
            sys.stdout.flush()
        except (OSError, ValueError):
            self._loop.call_soon_threadsafe(self._on_lost)

    def __enter__(self) -> "PlainTerminal":
        if sys.platform != "win32":
            import termios

            number = sys.stdin.fileno()
            self._before = list(termios.tcgetattr(number))
            raw = termios.tcgetattr(number)
            raw[0] &= ~(termios.IXON | termios.ICRNL)
            raw[3] &= ~(termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN)
            raw[6][termios.VMIN], raw[6][termios.VTIME] = 1, 0
            termios.tcsetattr(number, termios.TCSADRAIN, raw)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.end_line()
        self.restore()

    def restore(self) -> None:
        """Read no more, and let the terminal be as it was before."""
        self._is_over.set()
        if sys.platform != "win32":
            import termios

            with contextlib.suppress(termios.error, OSError):  # the terminal may be gone
                termios.tcsetattr(sys.stdin.fileno(), termios.TCSADRAIN, self._before)

    # --- on the reading thread

    def _read(self) -> None:
        if sys.platform == "win32":
            self._read_console()
        else:
            self._read_bytes()

    def _read_bytes(self) -> None:
        number = sys.stdin.fileno()
        decoder = codecs.getincrementaldecoder("utf-8")("surrogateescape")
        while not self._is_over.is_set():
            ready, _, _ = select.select([number], [], [], _POLL_S)
            at = host_now()
            try:
                data = os.read(number, 1024) if ready else b""
            except OSError:
                data = b""
            if ready and not data:
                self._loop.call_soon_threadsafe(self._on_lost)
                return
            text = decoder.decode(data)
            self._pass_on(self._parser.feed(text) if text else self._parser.tick(), at)

    def _read_console(self) -> None:
        if sys.platform == "win32":
            import msvcrt

            while not self._is_over.is_set():
                if not msvcrt.kbhit():
                    self._pass_on(self._parser.tick(), host_now())
                    self._is_over.wait(_CONSOLE_POLL_S)
                    continue
                character, at = msvcrt.getwch(), host_now()
                if character not in "\x00\xe0":
                    self._pass_on(self._parser.feed(character), at)
                elif name := _CONSOLE.get(msvcrt.getwch()):
                    self._pass_on([Key(name, None)], at)

    def _pass_on(self, messages: Iterable[Message], at: int) -> None:
        for message in messages:
            message.time = at / SECOND
            self._loop.call_soon_threadsafe(self._on_input, message)
