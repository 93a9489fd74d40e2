"""Keeps the voice: one child process, one part at a time, and an end to each part whatever the child does."""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Literal, NamedTuple

from sar_tui.framework.clock import host_now
from sar_tui.framework.messages import PartState
from sar_tui.outputs.sound.child import PROGRAM, Child
from sar_tui.outputs.sound.protocol import Ended, Reply, Say, Setup, Started, Stop, Tone, Warm

Kind = Literal["say", "tone"]

PATIENCE_S = 10.0
"""How long a voice may take to begin, and for speech a little more by the length of the text."""
_A_LETTER_S = 0.02
_STOP_S = 0.05
"""A voice that is not still this long after it was told so is killed."""
_OVERTIME_S = 5.0
"""A voice that sounds for this much longer than it should is killed."""
_MOST_FAILURES = 3
_CLOSED_S = 3.0

_NO_CHILD = "The voice cannot be started ({}): restart the program, or this computer."
_SILENT = "The voice did not begin within {:.0f} s and was ended."
_STUCK = "The voice did not come to an end and was ended."
_LOST = "The voice stopped working in the middle of it."
_LOST_BEFORE = "The voice stopped working before it began."
_GIVEN_UP = {
    "say": "Speech is off for the rest of this session, for it failed three times in a row: {}",
    "tone": "Tones are off for the rest of this session, for they failed three times in a row: {}",
}


class Ask(NamedTuple):
    """A part that is asked for. One with a ``problem`` is known to be impossible, and fails when its turn comes."""

    kind: Kind
    action: str
    request: Say | Tone
    problem: str = ""


class News(NamedTuple):
    """What became of one: since ``at`` (ns, `host_now`), and as it starts for how many ``seconds`` it will sound."""

    ask: Ask
    state: PartState
    at: int
    detail: str = ""
    seconds: float = 0.0


class Supervisor:
    """Does what is asked for in its order. All of its state belongs to one thread, on which ``told`` is called too.

    The child is started at once, and again for the next part whenever it died, hung or would not be still.

    Args:
        setup: what the child is told first.
        told: hears of each part at most that it started, and once that it is over.
        program: the child's command line.
        patience_s: how long a part may take to begin.
    """

    def __init__(
        self,
        setup: Setup,
        told: Callable[[News], object],
        program: Sequence[str] = PROGRAM,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._setup, self._told = setup, told
        self._program, self._patience_s = program, patience_s
        self._inbox: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._asked: deque[Ask] = deque()
        self._current: Ask | None = None
        self._has_started = self._is_stopping = self._is_closed = False
        self._due: float | None = None
        self._latest = 0
        self._child: Child | None = None
        self._warm: dict[Kind, Warm] = {}
        self._failures: dict[Kind, int] = {"say": 0, "tone": 0}
        self._given_up: dict[Kind, str] = {}
        self._thread = threading.Thread(target=self._run, name="voice keeper", daemon=True)
        self._thread.start()

    def ask(self, ask: Ask) -> None:
        """Do this, after what was asked for before."""
        self._inbox.put(lambda: self._asked.append(ask))

    def stop(self, kind: Kind, action: str = "") -> None:
        """Be still: the parts of a kind, of one action or of all."""
        self._inbox.put(lambda: self._stop(kind, action))

    def warm(self, kind: Kind, request: Warm) -> None:
        """Get ready for what is to come; each new child too."""
        self._inbox.put(lambda: self._get_ready(kind, request))

    def close(self) -> None:
        """Be still, and end the child and the thread. Nothing is told of parts under way. Harmless twice."""
        self._inbox.put(self._close)
        self._thread.join(_CLOSED_S)

    # --- on the keeper's thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._is_closed:
            try:
                left = None if self._due is None else max(0.0, self._due - time.monotonic())
                do = self._inbox.get(timeout=left)
            except queue.Empty:
                self._overdue()
            else:
                do()
            if not self._is_closed:
                self._next()
        self._end_child()

    def _close(self) -> None:
        self._is_closed = True

    def _next(self) -> None:
        """Begin what is asked for next, if nothing is under way."""
        while self._current is None and self._asked:
            self._current = ask = self._asked.popleft()
            self._has_started = self._is_stopping = False
            if reason := ask.problem or self._given_up.get(ask.kind):
                self._over("failed", reason, at_fault=False)
            elif child := self._ready_child():
                length = len(ask.request.text) if isinstance(ask.request, Say) else 0
                self._due = time.monotonic() + self._patience_s + _A_LETTER_S * length
                child.send(ask.request)

    def _ready_child(self) -> Child | None:
        """The child, started if need be. None if it cannot be, and then the part has failed."""
        if self._child is None:
            try:
                self._child = Child(self._setup, self._hear, self._program)
            except OSError as error:
                if self._current:
                    self._over("failed", _NO_CHILD.format(error.strerror or error))
                return None
            for request in self._warm.values():
                self._child.send(request)
        return self._child

    def _get_ready(self, kind: Kind, request: Warm) -> None:
        self._warm[kind] = request
        if self._child:
            self._child.send(request)
        else:
            self._ready_child()

    def _stop(self, kind: Kind, action: str) -> None:
        def is_meant(ask: Ask) -> bool:
            return ask.kind == kind and action in ("", ask.action)

        current = self._current
        if current and is_meant(current) and not self._is_stopping and self._child:
            self._is_stopping = True
            self._due = time.monotonic() + _STOP_S
            self._child.send(Stop(current.request.job))
        waiting = [ask for ask in self._asked if is_meant(ask)]
        self._asked = deque(ask for ask in self._asked if not is_meant(ask))
        for ask in waiting:
            self._tell(ask, "aborted", host_now())

    def _hear(self, child: Child, reply: Reply | None) -> None:
        """On the child's listening thread: hand on what it tells."""
        self._inbox.put(lambda: self._heard(child, reply))

    def _heard(self, child: Child, reply: Reply | None) -> None:
        current = self._current
        if child is not self._child:
            return
        if reply is None:
            self._lost()
        elif isinstance(reply, Started) and current and reply.job == current.request.job:
            self._has_started = True
            if not self._is_stopping:
                self._due = time.monotonic() + reply.seconds + _OVERTIME_S
            self._tell(current, "started", reply.at, seconds=reply.seconds)
        elif isinstance(reply, Ended) and current and reply.job == current.request.job:
            self._over(reply.state, reply.detail, reply.at, reply.at_fault)

    def _lost(self) -> None:
        """The child is gone by itself."""
        self._end_child()
        if self._is_stopping:
            self._over("aborted")
        else:
            self._over("failed", _LOST if self._has_started else _LOST_BEFORE)

    def _overdue(self) -> None:
        """The child is late: to be still, to begin, or to end."""
        self._end_child()
        if self._is_stopping:
            self._over("aborted")
        else:
            self._over("failed", _STUCK if self._has_started else _SILENT.format(self._patience_s))

    def _over(self, state: PartState, detail: str = "", at: int | None = None, at_fault: bool = True) -> None:
        """The part under way, if any, is over."""
        ask, self._current, self._due = self._current, None, None
        if ask is None:
            return
        if state == "done":
            self._failures[ask.kind] = 0
        elif state == "failed" and at_fault:
            self._failures[ask.kind] += 1
            if self._failures[ask.kind] == _MOST_FAILURES:
                self._given_up[ask.kind] = _GIVEN_UP[ask.kind].format(detail)
        self._tell(ask, state, host_now() if at is None else at, detail)

    def _tell(self, ask: Ask, state: PartState, at: int, detail: str = "", seconds: float = 0.0) -> None:
        """Times never go back, though a child's may have been on their way while something else was told."""
        self._latest = max(self._latest, at)
        with suppress(Exception):  # whatever becomes of the news, the parts to come need this thread
            self._told(News(ask, state, self._latest, detail, seconds))

    def _end_child(self) -> None:
        child, self._child = self._child, None
        if child:
            child.kill()
