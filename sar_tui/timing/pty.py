"""A program in a pseudo-terminal: its output is read with time stamps, and keys are typed. POSIX
only.
"""

import contextlib
import os
import re
import select
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from types import TracebackType

from sar_tui.model.units import MS
from sar_tui.rules.keys import QUIET, UNREAD

if sys.platform != "win32":
    import fcntl
    import termios

_HIDDEN = frozenset(
    "SSH_CONNECTION SSH_CLIENT SSH_TTY TMUX TMUX_PANE STY ZELLIJ TERM_PROGRAM COLUMNS LINES".split()
)
"""Environment variables that describe the terminal of this process, not that of the program."""

_KEYS = {
    "enter": b"\r",
    "space": b" ",
    "tab": b"\t",
    "backspace": b"\x7f",
    "escape": b"\x1b",
    "up": b"\x1b[A",
    "down": b"\x1b[B",
    "right": b"\x1b[C",
    "left": b"\x1b[D",
    "f1": b"\x1bOP",
    "f2": b"\x1bOQ",
    "f12": b"\x1b[24~",
}

_READING = max(QUIET, UNREAD) + 100 * MS
"""Time from what a person sees to the key that they press for it."""

_SEQUENCE = re.compile(
    rb"\x1b(?:\[[0-?]*[ -/]*(?:[@-~]|$)|[\]PX^_].*?(?:\x1b\\|\x07|$)|[ -/]*(?:[0-~]|$))", re.DOTALL
)
"""An escape sequence, complete or cut off by the end of the output (ECMA-48: CSI, strings,
others).
"""


class NoTerminal(RuntimeError):
    """This system has no pseudo-terminals."""


def encode(key: str) -> bytes:
    """Return the bytes that a terminal sends for a key: a character, a name (``left``, ``enter``),
    or ``ctrl+q``.

    Raises:
        ValueError: there is no such key.
    """
    if len(key) == 1:
        return key.encode()
    if key.startswith("ctrl+") and len(key) == 6:
        return bytes([ord(key[-1].upper()) & 0x1F])
    if key in _KEYS:
        return _KEYS[key]
    raise ValueError(f"There is no key {key}.")


def visible(output: bytes) -> str:
    """Return the visible text of an output: without escape sequences, control characters and outer
    blanks.
    """
    text = _SEQUENCE.sub(b"", output).decode(errors="ignore")
    return "".join(character for character in text if character.isprintable()).strip()


class Terminal:
    """A terminal with a program in it. A context manager: a program that still runs at its end is
    killed.

    Output is read only by ``read`` and the methods that call it (see also ``read_together``). A
    program whose output is not read blocks.

    Args:
        command: the program and its arguments.
        columns, rows: size of the terminal.
        environment: added to this program's own, without the variables of SSH and of multiplexers.

    Attributes:
        output: everything that the program has written so far.
        read_at: time of the last read, in ns of ``time.monotonic_ns``.
        started_at: time of the program's start, on the same clock.
        ended: True if the program has closed the terminal.

    Raises:
        NoTerminal: on Windows.
        OSError: there is no such program.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        columns: int = 80,
        rows: int = 24,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        if sys.platform == "win32":
            raise NoTerminal("Windows has no pseudo-terminals that a program can be timed in.")
        self.output = bytearray()
        self.ended = False
        self._read_with: list[Terminal] = []
        self._file, far = os.openpty()
        try:
            self.resize(columns, rows)
            inherited = {name: value for name, value in os.environ.items() if name not in _HIDDEN}
            self.started_at = self.read_at = time.monotonic_ns()
            self.process = subprocess.Popen(
                command,
                stdin=far,
                stdout=far,
                stderr=far,
                env=inherited | {"TERM": "xterm-256color"} | dict(environment or {}),
                start_new_session=True,
                preexec_fn=_take_terminal,  # noqa: PLW1509  system calls alone, and no other way to a controlling terminal
            )
        except BaseException:
            os.close(self._file)
            raise
        finally:
            os.close(far)

    def __enter__(self) -> "Terminal":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def resize(self, columns: int, rows: int) -> None:
        """Change the size of the terminal; the program gets SIGWINCH."""
        fcntl.ioctl(self._file, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def modes(self) -> list[object]:
        """Return the terminal's modes (`termios.tcgetattr`): echo, line editing, signals."""
        return list(termios.tcgetattr(self._file))

    def read(self, until: int) -> bool:
        """Wait for output until a time (ns), and read it; False if there was none or the terminal
        was closed.

        Terminals that are read together with this one (see ``read_together``) are read, too.
        """
        while not self.ended:
            left = max(0, until - time.monotonic_ns())
            ready = select.select(
                [each for each in (self, *self._read_with) if not each.ended], [], [], left / 1e9
            )[0]
            for each in ready:
                each._take()
            if self in ready:
                break
            if not left:
                return False
        return not self.ended

    def fileno(self) -> int:
        """Return the file descriptor to wait for."""
        return self._file

    def _take(self) -> None:
        """Read the available output."""
        try:
            data = os.read(self._file, 65536)
        except OSError:  # Linux says EIO where other systems say end of file
            data = b""
        self.read_at = time.monotonic_ns()
        self.ended = not data
        self.output += data

    def write(self, data: bytes) -> int:
        """Type bytes, and return the time just before (ns)."""
        at = time.monotonic_ns()
        os.write(self._file, data)
        return at

    def press(self, key: str) -> int:
        """Press a key by its name (see ``encode``), and return the time just before (ns)."""
        return self.write(encode(key))

    def confirm(self, key: str = "enter") -> int:
        """Press a key after a while, as somebody who has read the screen and whose last key is up;
        return the time.
        """
        until = time.monotonic_ns() + _READING
        while self.read(until):
            pass
        return self.press(key)

    def wait_for(self, text: str, *, since: int = 0, seconds: float = 60) -> int:
        """Read until the output contains ``text`` after position ``since``, in whatever colours;
        return the position after it.

        Raises:
            TimeoutError: it did not appear, or the program has ended. The message quotes the
                visible output.
        """
        letters = (re.escape(text[at : at + 1].encode()) for at in range(len(text)))
        wanted = re.compile(rb"(?:\x1b\[[\d;]*m)*".join(letters))
        until = time.monotonic_ns() + round(seconds * 1e9)
        while (found := wanted.search(self.output, since)) is None:
            if not self.read(until):
                seen = visible(bytes(self.output[since:]))[-600:]
                raise TimeoutError(f"The terminal does not show {text!r}. Its output is: {seen!r}")
        return found.end()

    def settle(self, *, silence_ms: float = 150, seconds: float = 20) -> None:
        """Read until there is no output for ``silence_ms``, at most for ``seconds``."""
        until = time.monotonic_ns() + round(seconds * 1e9)
        while self.read(min(until, time.monotonic_ns() + round(silence_ms * 1e6))):
            pass

    def wait(self, *, seconds: float = 60) -> int:
        """Read until the program has ended; return its exit code, negative for a signal.

        Raises:
            TimeoutError: it does not end.
        """
        until = time.monotonic_ns() + round(seconds * 1e9)
        while self.read(until):
            pass
        try:
            return self.process.wait(max(0.0, (until - time.monotonic_ns()) / 1e9))
        except subprocess.TimeoutExpired:
            seen = visible(bytes(self.output))[-600:]
            raise TimeoutError(f"The program does not end. Its last output is: {seen!r}") from None

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send a signal to the program and its child processes."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, number)

    def hang_up(self) -> None:
        """Close the terminal, as closing its window does."""
        if self._file >= 0:
            os.close(self._file)
            self._file, self.ended = -1, True

    def close(self) -> None:
        """Kill the program if it still runs, and close the terminal."""
        if self.process.poll() is None:
            self.kill()
        self.hang_up()
        self.process.wait()


def read_together(*terminals: Terminal) -> None:
    """Read all of these terminals whenever one of them is read, so that no program blocks."""
    for terminal in terminals:
        terminal._read_with = [other for other in terminals if other is not terminal]


def _take_terminal() -> None:
    """Make standard input the controlling terminal of a new session, with the signals' default
    actions.

    Signals that this program ignores (under ``nohup``, or in the background) would be ignored by
    the new one, too.
    """
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
