"""Runs the voice process: one part at a time. Every part ends, even if the process hangs or
dies.
"""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Literal, NamedTuple

from sar_tui.loop.clock import host_now
from sar_tui.model.messages import PartState
from sar_tui.outputs.sound.child import VOICE, SoundProgram
from sar_tui.outputs.sound.protocol import Ended, Reply, Say, Setup, Started, Stop, Tone, Warm

Kind = Literal["say", "tone"]

PATIENCE_S = 10.0
"""Time for a part to start. Speech gets a little more, by the length of its text."""
_A_LETTER_S = 0.02
_STOP_S = 0.05
"""A voice that has not stopped this long after the request is killed."""
_OVERTIME_S = 5.0
"""A voice that plays longer than expected by this much is killed."""
_MOST_FAILURES = 3
_CLOSED_S = 3.0

_NO_CHILD = "The voice cannot be started ({}): restart the program, or this computer."
_SILENT = "The voice did not begin within {:.0f} s and was ended."
_STUCK = "The voice did not come to an end and was ended."
_LOST = "The voice stopped working in the middle of it."
_LOST_BEFORE = "The voice stopped working before it began."
_GIVEN_UP = {
    "say": "Speech is off for the rest of this session because it failed three times in a row: {}",
    "tone": "Tones are off for the rest of this session because they failed three times in a row: "
    "{}",
}


class SoundJob(NamedTuple):
    """A requested part. One with a ``problem`` cannot be done, and fails when its turn comes."""

    kind: Kind
    action: str
    request: Say | Tone
    problem: str = ""


class PartEvent(NamedTuple):
    """A state of a part since ``at`` (ns, `host_now`); on ``started``, with its duration in
    ``seconds``.
    """

    job: SoundJob
    state: PartState
    at: int
    detail: str = ""
    seconds: float = 0.0


class Supervisor:
    """Performs requests in order. All its state belongs to one thread, which also calls
    ``on_event``.

    The process is started at once, and again for the next part after it died, hung or did not stop.

    Args:
        setup: the first message to the process.
        on_event: called at most once when a part starts, and once when it is over.
        program: the command line of the process.
        patience_s: time for a part to start.
    """

    def __init__(
        self,
        setup: Setup,
        on_event: Callable[[PartEvent], object],
        program: Sequence[str] = VOICE,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._on_event, self._patience_s = on_event, patience_s
        self._inbox: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._queue: deque[SoundJob] = deque()
        self._current: SoundJob | None = None
        self._has_started = self._is_stopping = self._is_closed = False
        self._due: float | None = None
        self._latest = 0
        self._voice = SoundProgram(program, setup, self._receive)
        self._failures: dict[Kind, int] = {"say": 0, "tone": 0}
        self._given_up: dict[Kind, str] = {}
        self._thread = threading.Thread(target=self._run, name="voice supervisor", daemon=True)
        self._thread.start()

    def add(self, job: SoundJob) -> None:
        """Queue a request."""
        self._inbox.put(lambda: self._queue.append(job))

    def stop(self, kind: Kind, action: str = "") -> None:
        """Stop the parts of a kind: those of one action, or all."""
        self._inbox.put(lambda: self._stop(kind, action))

    def warm(self, kind: Kind, request: Warm) -> None:
        """Prepare the process, and each later one, for coming parts."""
        self._inbox.put(lambda: self._prepare(kind, request))

    def close(self) -> None:
        """Stop, and end the process and the thread. Parts under way are not reported. May be called
        twice.
        """
        self._inbox.put(self._close)
        self._thread.join(_CLOSED_S)

    # --- on the supervisor's thread

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
        self._voice.end()

    def _close(self) -> None:
        self._is_closed = True

    def _next(self) -> None:
        """Begin the next request if nothing is under way."""
        while self._current is None and self._queue:
            self._current = job = self._queue.popleft()
            self._has_started = self._is_stopping = False
            if reason := job.problem or self._given_up.get(job.kind):
                self._over("failed", reason, at_fault=False)
            else:
                self._begin(job)

    def _begin(self, job: SoundJob) -> None:
        try:
            self._voice.start()
        except OSError as error:
            self._over("failed", _NO_CHILD.format(error.strerror or error))
            return
        length = len(job.request.text) if isinstance(job.request, Say) else 0
        self._due = time.monotonic() + self._patience_s + _A_LETTER_S * length
        self._voice.send(job.request)

    def _prepare(self, kind: Kind, request: Warm) -> None:
        with suppress(OSError):  # reported by the parts to come
            self._voice.prepare(kind, request)

    def _stop(self, kind: Kind, action: str) -> None:
        def is_meant(job: SoundJob) -> bool:
            return job.kind == kind and action in ("", job.action)

        current = self._current
        if current and is_meant(current) and not self._is_stopping:
            self._is_stopping = True
            self._due = time.monotonic() + _STOP_S
            self._voice.send(Stop(current.request.job))
        waiting = [job for job in self._queue if is_meant(job)]
        self._queue = deque(job for job in self._queue if not is_meant(job))
        for job in waiting:
            self._report(job, "aborted", host_now())

    def _receive(self, reply: Reply | None) -> None:
        """Pass a reply on, from the listening thread."""
        self._inbox.put(lambda: self._handle(reply))

    def _handle(self, reply: Reply | None) -> None:
        current = self._current
        if reply is None:
            if not self._voice.is_running:  # else it is of an earlier process
                self._lost()
        elif isinstance(reply, Started) and current and reply.job == current.request.job:
            self._has_started = True
            if not self._is_stopping:
                self._due = time.monotonic() + reply.seconds + _OVERTIME_S
            self._report(current, "started", reply.at, seconds=reply.seconds)
        elif isinstance(reply, Ended) and current and reply.job == current.request.job:
            self._over(reply.state, reply.detail, reply.at, reply.at_fault)

    def _lost(self) -> None:
        """Handle the end of a process that was not killed here."""
        if self._is_stopping:
            self._over("aborted")
        else:
            self._over("failed", _LOST if self._has_started else _LOST_BEFORE)

    def _overdue(self) -> None:
        """Handle a process that is late to stop, to start, or to end."""
        self._voice.end()
        if self._is_stopping:
            self._over("aborted")
        else:
            self._over("failed", _STUCK if self._has_started else _SILENT.format(self._patience_s))

    def _over(
        self, state: PartState, detail: str = "", at: int | None = None, at_fault: bool = True
    ) -> None:
        """End the part under way, if any."""
        job, self._current, self._due = self._current, None, None
        if job is None:
            return
        if state == "done":
            self._failures[job.kind] = 0
        elif state == "failed" and at_fault:
            self._failures[job.kind] += 1
            if self._failures[job.kind] == _MOST_FAILURES:
                self._given_up[job.kind] = _GIVEN_UP[job.kind].format(detail)
        self._report(job, state, host_now() if at is None else at, detail)

    def _report(
        self, job: SoundJob, state: PartState, at: int, detail: str = "", seconds: float = 0.0
    ) -> None:
        """Report a state. Times never decrease, even if a reply was under way while another state
        was reported.
        """
        self._latest = max(self._latest, at)
        with suppress(Exception):  # later parts need this thread, whatever the callback does
            self._on_event(PartEvent(job, state, self._latest, detail, seconds))
