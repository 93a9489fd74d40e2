"""Parts in sequence on a virtual clock: nothing is played, but each takes as long as it would
sound.
"""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from sar_tui.loop.clock import Handle, VirtualClock
from sar_tui.model.messages import PartState
from sar_tui.model.units import SECOND
from sar_tui.outputs.sound.supervisor import Kind, SoundJob


class _TimedJob(NamedTuple):
    job: SoundJob
    seconds: float


class VirtualPlayback:
    """A queue of parts with known durations. ``on_state`` is called when each starts and when it is
    over.
    """

    def __init__(
        self, clock: VirtualClock, on_state: Callable[[SoundJob, PartState], object]
    ) -> None:
        self._clock, self._on_state = clock, on_state
        self._queue: deque[_TimedJob] = deque()
        self._end: Handle | None = None

    def add(self, job: SoundJob, seconds: float) -> None:
        """Add a part with its duration to the end of the queue."""
        self._queue.append(_TimedJob(job, seconds))
        self._begin()

    def stop(self, kind: Kind, action: str = "") -> None:
        """Abort the parts of a kind, of one action or of all."""
        meant = [
            entry
            for entry in self._queue
            if entry.job.kind == kind and action in ("", entry.job.action)
        ]
        if meant and self._end and meant[0] is self._queue[0]:
            self._end.cancel()
            self._end = None
        self._queue = deque(entry for entry in self._queue if entry not in meant)
        for entry in meant:
            self._on_state(entry.job, "aborted")
        self._begin()

    def _begin(self) -> None:
        if self._queue and self._end is None:
            job, seconds = self._queue[0]
            self._end = self._clock.call_at(self._clock.now() + round(seconds * SECOND), self._over)
            self._on_state(job, "started")

    def _over(self) -> None:
        self._end = None
        job, _ = self._queue.popleft()
        self._on_state(job, "done")
        self._begin()
