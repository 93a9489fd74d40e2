"""Shows a recorded session to nodes at its own pace: nothing they answer has an effect."""

from collections.abc import Sequence
from typing import Any

from sar_tui.loop.bus import Bus, M, Record, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.messages import AttemptStarted, Message, SessionStarted
from sar_tui.model.units import SECOND

_OPENING = 5 * SECOND
"""Time before the first message of a run in which its outputs are opened."""
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


class DisplayBus(Bus):
    """A bus that delivers recorded messages, and ignores what its nodes publish."""

    def show(self, record: Record) -> None:
        """Deliver a recorded message."""
        self._now = record.at
        self._deliver(record.topic, record.message)
        self._cascade.clear()
        self._derived.clear()  # faults of the nodes that show it

    def publish(self, topic: Topic[M], message: M) -> None:
        """Ignore a message: it is in the record already."""

    def post(self, topic: Topic[M], message: M) -> None:
        """Ignore an input: a replay takes none."""

    def report(self, owner: str, place: str, error: BaseException) -> None:
        """Ignore a fault."""


class Player:
    """Plays a record on a display bus.

    Args:
        records: of the session, without samples.
        speed: how many times as fast as it was.

    Attributes:
        bus: to which the nodes are attached that show it.
        clock: time in the record, for the nodes.
        speed: may be changed.
        paused: may be changed.
        attempt: the attempt that was begun last; 0 before the first.
    """

    def __init__(self, records: Sequence[Record], speed: float = 1.0) -> None:
        self._records = records
        self._next = 0
        self._beginnings = _beginnings(records)
        self.clock = VirtualClock(records[0].at if records else 0)
        self.bus = DisplayBus(self.clock)
        self.speed = speed
        self.paused = False
        self.attempt = 0

    @property
    def is_over(self) -> bool:
        """True if all was shown."""
        return self._next == len(self._records)

    @property
    def attempts(self) -> int:
        """Number of the last recorded attempt."""
        return max(
            (m.attempt for _, _, _, m in self._records if isinstance(m, AttemptStarted)), default=0
        )

    def advance(self, elapsed: int) -> None:
        """Show what falls into the next ``elapsed`` ns of real time."""
        if self.paused or self.is_over:
            return
        until = self.clock.now() + round(elapsed * self.speed)
        while not self.is_over and (at := self._due()) <= until:
            self.clock.advance(max(0, at - self.clock.now()))
            self._show_next()
        self.clock.advance(max(0, until - self.clock.now()))

    def skip_to(self, attempt: int) -> None:
        """Show at once all that comes before an attempt and its beginning; of the last one, its
        end.
        """
        while not self.is_over and self.attempt < attempt:
            self.clock.set(self._due())
            self._show_next()

    def faster(self, by: int) -> None:
        """Change the speed by steps."""
        place = min(range(len(SPEEDS)), key=lambda index: abs(SPEEDS[index] - self.speed))
        self.speed = SPEEDS[max(0, min(len(SPEEDS) - 1, place + by))]

    def _due(self) -> int:
        """Return the time of the next message. A run begins at once: it may be hours later, and on
        another clock.
        """
        at = self._records[self._next].at
        if self._next in self._beginnings:
            self.clock.set(at)
        return at

    def _show_next(self) -> None:
        record = self._records[self._next]
        self._next += 1
        message: Message | Any = record.message
        if isinstance(message, AttemptStarted):
            self.attempt = message.attempt
        self.bus.show(record)


def _beginnings(records: Sequence[Record]) -> set[int]:
    """Return the places of the first message of each run: outputs are opened shortly before it is
    announced.
    """
    found = set()
    for announced, record in enumerate(records):
        if isinstance(record.message, SessionStarted):
            first = announced
            while first and 0 <= record.at - records[first - 1].at < _OPENING:
                first -= 1
            found.add(first)
    return found
