"""A program at the far end of a real pseudo-terminal: its output read and stamped, keys typed, on POSIX systems."""

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

if sys.platform != "win32":
    import fcntl
    import termios

_HIDDEN = frozenset("SSH_CONNECTION SSH_CLIENT SSH_TTY TMUX TMUX_PANE STY ZELLIJ TERM_PROGRAM COLUMNS LINES".split())
"""What would tell the program of another terminal than the one it is at."""

_KEYS = {
    "enter": b"\r",
    "space": b" ",
    "tab": b"\t",
    "escape": b"\x1b",
    "up": b"\x1b[A",
    "down": b"\x1b[B",
    "right": b"\x1b[C",
    "left": b"\x1b[D",
    "f1": b"\x1bOP",
    "f2": b"\x1bOQ",
}

_SEQUENCE = re.compile(rb"\x1b(?:\[[0-?]*[ -/]*(?:[@-~]|$)|[\]PX^_].*?(?:\x1b\\|\x07|$)|[ -/]*(?:[0-~]|$))", re.DOTALL)
"""An escape sequence, whole or cut off by the end (ECMA-48: CSI, the strings, the rest)."""


class NoTerminal(RuntimeError):
    """This system has no pseudo-terminals."""


def encode(key: str) -> bytes:
    """What a terminal sends for a key: a character, a name (``left``, ``enter``), or ``ctrl+q``.

    Raises:
        ValueError: no such key.
    """
    if len(key) == 1:
        return key.encode()
    if key.startswith("ctrl+") and len(key) == 6:
        return bytes([ord(key[-1].upper()) & 0x1F])
    if key in _KEYS:
        return _KEYS[key]
    raise ValueError(f"There is no key {key}.")


def visible(output: bytes) -> str:
    """What of an output can be seen: no escape sequences, control characters or blanks at the ends."""
    text = _SEQUENCE.sub(b"", output).decode(errors="ignore")
    return "".join(character for character in text if character.isprintable()).strip()


class Terminal:
    """A terminal with a program in it. Use it as a context: what still runs at the end is killed.

    Nothing is read but by ``read`` and what calls it, or that of another (see ``together``); a program whose output
    nobody reads stands still.

    Args:
        command: the program and its arguments.
        columns, rows: how large the terminal is.
        environment: added to this program's own, from which SSH's and the multiplexers' variables are taken out.

    Attributes:
        output: all that the program has written so far.
        read_at: when the last of it was read, in ns of ``time.monotonic_ns``.
        started_at: when the program was started, on the same clock.
        ended: whether the program has let go of the terminal.

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
        self._beside: list[Terminal] = []
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
                preexec_fn=_take_terminal,  # noqa: PLW1509  one system call, and no other way to a controlling terminal
            )
        except BaseException:
            os.close(self._file)
            raise
        finally:
            os.close(far)

    def __enter__(self) -> "Terminal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def resize(self, columns: int, rows: int) -> None:
        """Make the terminal another size; the program is told by SIGWINCH."""
        fcntl.ioctl(self._file, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def modes(self) -> list[object]:
        """How the terminal is set (`termios.tcgetattr`): whether it echoes, edits lines, sends signals."""
        return list(termios.tcgetattr(self._file))

    def read(self, until: int) -> bool:
        """Read once, and stamp it; False if nothing came until then (ns), or the program has let go.

        What terminals beside it have to say meanwhile is read, too.
        """
        while not self.ended:
            left = max(0, until - time.monotonic_ns())
            ready = select.select([each for each in (self, *self._beside) if not each.ended], [], [], left / 1e9)[0]
            for each in ready:
                each._take()
            if self in ready:
                break
            if not left:
                return False
        return not self.ended

    def fileno(self) -> int:
        """The near end of the terminal, to be waited for."""
        return self._file

    def _take(self) -> None:
        """Read what is there."""
        try:
            data = os.read(self._file, 65536)
        except OSError:  # Linux says EIO where other systems say end of file
            data = b""
        self.read_at = time.monotonic_ns()
        self.ended = not data
        self.output += data

    def write(self, data: bytes) -> int:
        """Type; returns the stamp taken right before."""
        at = time.monotonic_ns()
        os.write(self._file, data)
        return at

    def press(self, key: str) -> int:
        """Press a key by its name (see ``encode``); returns the stamp taken right before."""
        return self.write(encode(key))

    def wait_for(self, text: str, *, since: int = 0, seconds: float = 60) -> int:
        """Read until the output holds ``text`` after position ``since``; returns the position after it.

        Raises:
            TimeoutError: it did not come, or the program has ended; the message tells what can be seen.
        """
        wanted, until = text.encode(), time.monotonic_ns() + round(seconds * 1e9)
        while (found := self.output.find(wanted, since)) < 0:
            if not self.read(until):
                seen = visible(bytes(self.output[since:]))[-600:]
                raise TimeoutError(f"The terminal does not show {text!r}; what came is: {seen!r}")
        return found + len(wanted)

    def settle(self, *, silence_ms: float = 150, seconds: float = 20) -> None:
        """Read until nothing has come for a while (or, at most, so many seconds)."""
        until = time.monotonic_ns() + round(seconds * 1e9)
        while self.read(min(until, time.monotonic_ns() + round(silence_ms * 1e6))):
            pass

    def wait(self, *, seconds: float = 60) -> int:
        """Read until the program has ended; returns its exit code, negative for a signal.

        Raises:
            TimeoutError: it goes on.
        """
        until = time.monotonic_ns() + round(seconds * 1e9)
        while self.read(until):
            pass
        try:
            return self.process.wait(max(0.0, (until - time.monotonic_ns()) / 1e9))
        except subprocess.TimeoutExpired:
            seen = visible(bytes(self.output))[-600:]
            raise TimeoutError(f"The program does not end; what came last is: {seen!r}") from None

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send a signal to the program and what it has started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, number)

    def hang_up(self) -> None:
        """Take the terminal away, as a closed window does."""
        if self._file >= 0:
            os.close(self._file)
            self._file, self.ended = -1, True

    def close(self) -> None:
        """End the program, if it has not ended, and the terminal."""
        if self.process.poll() is None:
            self.kill()
        self.hang_up()
        self.process.wait()


def together(*terminals: Terminal) -> None:
    """Whenever one of these is read, so are the others: none stands still because somebody looks at another."""
    for terminal in terminals:
        terminal._beside = [other for other in terminals if other is not terminal]


def _take_terminal() -> None:
    """Make standard input the controlling terminal of a new session: for its signals, and for hanging up."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
