"""What of a session goes out to its peers, and what a peer that comes late has to know of it."""

from collections import deque
from typing import Any

from sar_tui.framework import topics as t
from sar_tui.framework.bus import Record, Topic
from sar_tui.framework.messages import ImuBlock, Message
from sar_tui.framework.topics import IMU, PRESENCE, PROMPT, SHOWN, TRIAL, VOIDED

SENT: tuple[Topic[Any], ...] = (
    # how the session stands and what the participant sees
    t.SESSION, t.THEME, t.WAITING, t.LEVEL, t.ATTEMPT_STARTED, t.CUE, t.PROMPT, t.SHOWN, t.VOIDED, t.FOCUS,
    t.SENSOR, t.STORAGE, t.SESSION_ENDED,
    # how they do; keys and percepts stay here, for a trial tells what came of them
    t.TRIAL, t.MARKED, t.ATTEMPT_ENDED, t.FEEDBACK,
    # what the agent would say, says and has said
    t.PROPOSED, t.PENDING_APPROVAL, t.ARBITER_STATE, t.FILLER_DUE, t.LEVEL_DECIDED, t.MISSED,
    t.ACTION, t.DROPPED, t.HALT, t.ACTING,
    t.OUTPUT, t.REPORT, t.STOPPED,
    # what operators did, so that each sees what came of it, and what the others do
    t.OPERATOR, t.DECISION, t.REMARK, t.MODE, t.PROPOSAL_SEEN, t.NOTE_ADDED, t.PRESENCE, t.REFUSED,
)  # fmt: skip
"""Faults stay here, too: their traces tell of the machine, and WAITING tells of a session that is broken."""

_LATEST: tuple[Topic[Any], ...] = (
    *(topic for topic in SENT if topic.keep),
    t.ATTEMPT_STARTED, t.PROMPT, t.SHOWN, t.FOCUS, t.SENSOR, t.STORAGE, t.SESSION_ENDED, t.OUTPUT,
)  # fmt: skip
"""Of these a late peer is told the last, of each seat and output."""
_HISTORY: tuple[Topic[Any], ...] = (
    t.TRIAL, t.MARKED, t.ATTEMPT_ENDED, t.PROPOSED, t.PENDING_APPROVAL, t.ACTION, t.DROPPED, t.LEVEL_DECIDED,
    t.NOTE_ADDED,
)  # fmt: skip
"""Of each of these a late peer is told the last few."""
_REMEMBERED = 40
_MOST_WAITING = 2_000
_MOST_BLOCKS = 500

_sent = {topic.name for topic in SENT}
_latest = {topic.name for topic in _LATEST}


class SessionFeed:
    """A tap on the bus that only puts aside: what it costs the session is an append.

    Attributes:
        awaits_onset: a prompt is on its way to the screen, so that nothing else should be done now.
        missed: more has happened than was taken, and the oldest of it is gone.
    """

    def __init__(self) -> None:
        self._waiting: deque[Record] = deque()
        self._blocks: deque[ImuBlock] = deque(maxlen=_MOST_BLOCKS)
        self._last: dict[tuple[str, str, str], Record] = {}
        self._history: dict[str, deque[Record]] = {topic.name: deque(maxlen=_REMEMBERED) for topic in _HISTORY}
        self.awaits_onset = False
        self.missed = False

    @property
    def has_news(self) -> bool:
        """Whether there is something to take."""
        return bool(self._waiting or self._blocks)

    def hear(self, cascade: list[Record]) -> None:
        """Take on a cascade."""
        for record in cascade:
            name = record.topic.name
            if record.topic is IMU and isinstance(record.message, ImuBlock):
                self._blocks.append(record.message)
            elif name in _sent:
                self._waiting.append(record)
                if name in _latest:
                    self._last[_place(record.topic, record.message)] = record
                if name in self._history:
                    self._history[name].append(record)
                if record.topic is PROMPT:
                    self.awaits_onset = True
                elif record.topic in (SHOWN, VOIDED, TRIAL):
                    self.awaits_onset = False
        while len(self._waiting) > _MOST_WAITING:
            self._waiting.popleft()
            self.missed = True

    def keep(self, topic: Topic[Any], message: Message) -> None:
        """What a topic that is kept held before there was this tap: a resumed session's."""
        if topic is not PRESENCE:  # who was there then is not there now
            self._last.setdefault(_place(topic, message), Record(0, 0, topic, message))

    def forget(self) -> None:
        """Nobody is there to whom the news would go."""
        self._waiting.clear()
        self._blocks.clear()

    def take(self) -> list[Record]:
        """All that has happened since it was last asked."""
        taken = list(self._waiting)
        self._waiting.clear()
        self.missed = False
        return taken

    def take_samples(self) -> dict[str, bytes]:
        """The motion sensors' samples since, by seat."""
        taken: dict[str, bytes] = {}
        for block in self._blocks:
            taken[block.seat] = taken.get(block.seat, b"") + block.samples
        self._blocks.clear()
        return taken

    def story(self) -> list[Record]:
        """How things stand, and how they came to: for a peer that knows nothing yet."""
        told = [*self._last.values(), *(record for records in self._history.values() for record in records)]
        return sorted(told, key=lambda record: record.seq)


def _place(topic: Topic[Any], message: Message) -> tuple[str, str, str]:
    return topic.name, message.seat, getattr(message, "output", "")
