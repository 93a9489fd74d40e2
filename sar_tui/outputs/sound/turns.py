"""Deeds that sound one after another on a clock that jumps: nothing is heard, but each lasts as long as it would."""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from sar_tui.framework.clock import SECOND, Handle, VirtualClock
from sar_tui.framework.messages import PartState
from sar_tui.outputs.sound.supervisor import Ask, Kind


class _Turn(NamedTuple):
    ask: Ask
    seconds: float


class Turns:
    """A queue of parts whose length is known. ``told`` hears when each starts and when it is over."""

    def __init__(self, clock: VirtualClock, told: Callable[[Ask, PartState], object]) -> None:
        self._clock, self._told = clock, told
        self._turns: deque[_Turn] = deque()
        self._end: Handle | None = None

    def add(self, ask: Ask, seconds: float) -> None:
        """Let it sound for so long, after all that was added before."""
        self._turns.append(_Turn(ask, seconds))
        self._begin()

    def stop(self, kind: Kind, action: str = "") -> None:
        """Abort the parts of a kind, of one action or of all."""
        meant = [turn for turn in self._turns if turn.ask.kind == kind and action in ("", turn.ask.action)]
        if meant and self._end and meant[0] is self._turns[0]:
            self._end.cancel()
            self._end = None
        self._turns = deque(turn for turn in self._turns if turn not in meant)
        for turn in meant:
            self._told(turn.ask, "aborted")
        self._begin()

    def _begin(self) -> None:
        if self._turns and self._end is None:
            ask, seconds = self._turns[0]
            self._end = self._clock.call_at(self._clock.now() + round(seconds * SECOND), self._over)
            self._told(ask, "started")

    def _over(self) -> None:
        self._end = None
        ask, _ = self._turns.popleft()
        self._told(ask, "done")
        self._begin()
