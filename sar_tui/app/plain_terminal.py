"""A terminal in which lines are appended, and single keys are read: nothing else is written to it.

Screen readers and braille lines follow it, because no text is ever drawn again.
"""

import asyncio
import os
import re
import select
import sys
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any, NamedTuple

from sar_tui.loop.clock import host_now
from sar_tui.model.visible_text import visible

_POLL_S = 0.1
"""Longest time until the reading thread notices that it is to end."""
_ALONE_S = 0.03
"""An escape byte that nothing has followed by then is the Escape key."""
_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|O[A-Za-z]|.)", re.DOTALL)
_SEQUENCES = {
    "A": "up",
    "B": "down",
    "C": "right",
    "D": "left",
    "H": "home",
    "F": "end",
    "24~": "f12",
}
"""Names of keys by the end of what a terminal sends for them (xterm, ECMA-48)."""
_NAMED = {
    "\r": "enter",
    "\n": "enter",
    "\t": "tab",
    " ": "space",
    "\x7f": "backspace",
    "\b": "backspace",
    "\x1b": "escape",
    "\x03": "ctrl+c",
    "\x11": "ctrl+q",
    "\x04": "ctrl+d",
}
_WINDOWS = {"H": "up", "P": "down", "M": "right", "K": "left", "\x86": "f12"}


class Key(NamedTuple):
    """A key that was pressed, the character that it types, and when it was read (ns)."""

    name: str
    character: str
    at: int


def parse(text: str, at: int) -> list[Key]:
    """Return the keys that a terminal has sent. What has no name is left out."""
    found, place = [], 0
    while place < len(text):
        if sequence := _SEQUENCE.match(text, place):
            name = next(
                (key for end, key in _SEQUENCES.items() if sequence[0][2:].endswith(end)), ""
            )
            place = sequence.end()
            found += [Key(name, "", at)] if name else []
            continue
        character, place = text[place], place + 1
        if name := _NAMED.get(character, character if character.isprintable() else ""):
            typed = character if character.isprintable() else ""
            found.append(Key(name, typed, at))
    return found


class PlainTerminal:
    """Appends lines to the standard output, and reads keys in a thread. A context manager that
    restores the terminal.

    Args:
        on_key: called with each key, on the loop's thread.
        on_lost: called there once if the terminal is gone.
    """

    def __init__(self, on_key: Callable[[Key], object], on_lost: Callable[[], object]) -> None:
        self._on_key, self._on_lost = on_key, on_lost
        self._loop = asyncio.get_running_loop()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._read, name="plain keys", daemon=True)
        self._before: list[Any] = []

    def write(self, text: str, end: str = "\n") -> int:
        """Append a text, and return when it had reached the terminal (ns)."""
        try:
            sys.stdout.write(f"{visible(text)}{end}")
            sys.stdout.flush()
        except (OSError, ValueError):
            self._loop.call_soon(self._on_lost)
        return host_now()

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
        self._is_over.set()
        if sys.platform != "win32":
            import contextlib
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
        number, rest = sys.stdin.fileno(), b""
        while not self._is_over.is_set():
            ready, _, _ = select.select([number], [], [], _ALONE_S if rest else _POLL_S)
            at = host_now()
            try:
                more = os.read(number, 1024) if ready else b""
            except OSError:
                more, ready = b"", [number]
            if ready and not more:
                self._loop.call_soon_threadsafe(self._on_lost)
                return
            text, whole = rest + more, bool(not ready)
            rest = b"" if whole else _unfinished(text)
            self._pass_on(text[: len(text) - len(rest)].decode(errors="ignore"), at)

    def _pass_on(self, text: str, at: int) -> None:
        for key in parse(text, at):
            self._loop.call_soon_threadsafe(self._on_key, key)

    def _read_console(self) -> None:
        if sys.platform == "win32":
            import msvcrt

            while not self._is_over.is_set():
                if not msvcrt.kbhit():
                    self._is_over.wait(0.005)
                    continue
                character, at = msvcrt.getwch(), host_now()
                if character in "\x00\xe0":
                    if name := _WINDOWS.get(msvcrt.getwch()):
                        self._loop.call_soon_threadsafe(self._on_key, Key(name, "", at))
                else:
                    self._pass_on(character, at)


def _unfinished(text: bytes) -> bytes:
    """Return the end of what was read that may be the beginning of a key."""
    if found := re.search(rb"\x1b(?:\[[0-?]*|O)?$", text):
        return found[0]
    for count in (1, 2, 3):  # a character of UTF-8 that was cut
        if len(text) >= count and text[-count] >= 0xC0:
            needed = 2 if text[-count] < 0xE0 else 3 if text[-count] < 0xF0 else 4
            return text[-count:] if needed > count else b""
    return b""
