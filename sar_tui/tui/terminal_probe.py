"""Probe of the terminal: it is asked for its cursor's position, which it answers only if it is
really there.

A program keeps running in its pseudo-terminal while ssh is frozen, or a browser's network is gone,
and no system call fails. Only the terminal itself can answer (DSR 6, ECMA-48), through the whole
way there and back.
"""

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND

if TYPE_CHECKING:
    from sar_tui.link.peer import TerminalState

QUERY = "\x1b[6n"
"""Every terminal answers it, xterm.js in a browser and the Linux console too, and Textual's parser
knows the answer.
"""
INTERVAL_S = 0.15
"""Several queries fit into the shortest ``operator_lost_ms``."""
MAX_UNANSWERED = 8
"""Queries on their way at a time: over a slow line several are. More would only fill a terminal
that takes nothing.
"""
_RETRY = SECOND
"""Time between two queries of a terminal that answers none (ns)."""
_LAST_ANSWER_S = 0.5
"""Longest wait at the end for an answer that is on its way."""
_MULTIPLEXERS = ("TMUX", "STY", "ZELLIJ")
"""Environment variables of tmux, GNU screen and Zellij, which answer themselves."""
_RELAYS = (b"mosh-server",)
"""Programs that answer themselves and set no variable."""
_MAX_ANCESTORS = 32


class TerminalProbe:
    """Asks the terminal whether it is there, and remembers when it last answered.

    Args:
        write: writes to the terminal.
        now: a clock (ns).
        is_relayed: returns True if another program answers in place of the terminal; called once,
            at the first query.
    """

    def __init__(
        self,
        write: Callable[[str], object],
        now: Callable[[], int] = host_now,
        is_relayed: Callable[[], bool] = lambda: False,
    ) -> None:
        self._write, self._now, self._find_relay = write, now, is_relayed
        self._is_relayed: bool | None = None
        self._asked = 0
        self._answered: int | None = None
        self._unanswered = 0
        self._longest_silence = 0
        self._on_their_way = 0
        self._all_answered = threading.Event()
        self._lock = threading.Lock()

    def ask(self) -> None:
        """Ask once, or not at all while too many queries wait for an answer. To be called every
        ``INTERVAL_S``.
        """
        if self._is_relayed is None:
            self._is_relayed = self._find_relay()
        now = self._now()
        if self._unanswered < MAX_UNANSWERED or now - self._asked >= _RETRY:
            with self._lock:
                self._asked = now
                self._unanswered += 1
                self._on_their_way += 1
                self._all_answered.clear()
            self._write(QUERY)

    def answered(self) -> None:
        """Note an answer. May be called on another thread."""
        now = self._now()
        with self._lock:
            if self._answered is not None:
                self._longest_silence = max(self._longest_silence, now - self._answered)
            self._answered, self._unanswered = now, 0
            self._on_their_way = max(0, self._on_their_way - 1)
            if not self._on_their_way:
                self._all_answered.set()

    def await_answers(self) -> None:
        """Wait a moment for the answers that are on their way, which would otherwise be typed into
        the shell.
        """
        silence = self.state().silence
        if self._on_their_way and silence is not None and silence < _RETRY:
            self._all_answered.wait(_LAST_ANSWER_S)

    def state(self) -> "TerminalState":
        """Return the evidence that the terminal is there."""
        silence = None if self._answered is None else max(0, self._now() - self._answered)
        from sar_tui.link.peer import TerminalState  # only an app with a link needs it

        return TerminalState(silence, bool(self._is_relayed))

    def take_longest_silence(self) -> int:
        """Return the longest time (ns) between two answers since the last call."""
        longest, self._longest_silence = self._longest_silence, 0
        return longest


def is_relayed() -> bool:
    """Return True if a program between this one and the terminal answers in the terminal's
    place.
    """
    return any(name in os.environ for name in _MULTIPLEXERS) or any(
        name in _RELAYS for name in _ancestors()
    )


def _ancestors() -> list[bytes]:
    """Return the names of the programs that this one was started from; none where the system does
    not tell.
    """
    found: list[bytes] = []
    process = os.getpid()
    while sys.platform == "linux" and process > 1 and len(found) < _MAX_ANCESTORS:
        try:
            head, _, tail = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")
            process = int(tail.split()[1])
        except (OSError, ValueError, IndexError):
            break
        found.append(head.partition(b"(")[2])
    return found
