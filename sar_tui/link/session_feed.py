"""Messages of the bus that are sent to peers, and the snapshot for a peer that joins late."""

from collections import deque
from typing import Any

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import FRAME, IMU, PRESENCE, PROMPT, SHOWN, TRIAL, VOIDED
from sar_tui.model.messages import ImuBlock, Message

SENT: tuple[Topic[Any], ...] = (
    # state of the session, and what the participant sees
    t.SESSION, t.THEME, t.WAITING, t.LEVEL, t.GOAL, t.ATTEMPT_STARTED, t.CUE, t.PROMPT, t.FRAME, t.SHOWN,
    t.VOIDED, t.FOCUS, t.SENSOR, t.TRUNK_SENSOR, t.STORAGE, t.SESSION_ENDED,
    # results; keys and percepts are not sent, as a trial holds their outcome
    t.TRIAL, t.MARKED, t.ATTEMPT_ENDED, t.FEEDBACK, t.STEP_ENDED,
    # what the agent proposes and does
    t.PROPOSED, t.PENDING_APPROVAL, t.ARBITER_STATE, t.FILLER_DUE, t.LEVEL_DECIDED, t.LATE_DECISION,
    t.ACTION, t.DROPPED, t.HALT, t.ACTING,
    t.OUTPUT, t.REPORT, t.STOPPED, t.MARKERS,
    # what operators did, so that each sees the outcome and what the others do
    t.COMMAND, t.SETTING, t.DECISION, t.REMARK, t.MODE, t.PROPOSAL_SEEN, t.NOTE_ADDED, t.PRESENCE, t.REFUSED,
    t.ANSWERED,
)  # fmt: skip
"""Faults are not sent: their tracebacks reveal details of the machine, and WAITING says that a
session is broken.
"""

_LATEST: tuple[Topic[Any], ...] = (
    *(topic for topic in SENT if topic.keep),
    t.ATTEMPT_STARTED, t.PROMPT, t.SHOWN, t.FOCUS, t.SENSOR, t.TRUNK_SENSOR, t.STORAGE,
    t.SESSION_ENDED, t.OUTPUT,
)  # fmt: skip
"""A snapshot holds the last message of each seat and output."""
_HISTORY: tuple[Topic[Any], ...] = (
    t.TRIAL, t.MARKED, t.ATTEMPT_ENDED, t.PROPOSED, t.PENDING_APPROVAL, t.ACTION, t.DROPPED, t.LEVEL_DECIDED,
    t.NOTE_ADDED,
)  # fmt: skip
"""A snapshot holds the last ``_HISTORY_LENGTH`` messages of each topic."""
_HISTORY_LENGTH = 40
_MAX_PENDING = 2_000
_MAX_BLOCKS = 500

_sent_names = {topic.name for topic in SENT}
_latest_names = {topic.name for topic in _LATEST}


class SessionFeed:
    """Collects the bus's messages for peers; the session only pays for an append.

    Attributes:
        awaits_onset: True while a prompt is on its way to the screen, when nothing else should run.
        missed: True if messages were dropped because too many were pending.
    """

    def __init__(self) -> None:
        self._pending: deque[Record] = deque()
        self._blocks: deque[ImuBlock] = deque(maxlen=_MAX_BLOCKS)
        self._last: dict[tuple[str, str, str], Record] = {}
        self._history: dict[str, deque[Record]] = {
            topic.name: deque(maxlen=_HISTORY_LENGTH) for topic in _HISTORY
        }
        self.awaits_onset = False
        self.missed = False

    @property
    def has_news(self) -> bool:
        """True if messages or samples are pending."""
        return bool(self._pending or self._blocks)

    def add(self, cascade: list[Record]) -> None:
        """Add a cascade of messages."""
        for record in cascade:
            name = record.topic.name
            if record.topic is IMU and isinstance(record.message, ImuBlock):
                self._blocks.append(record.message)
            elif name in _sent_names:
                self._pending.append(record)
                if name in _latest_names:
                    self._last[_slot(record.topic, record.message)] = record
                if name in self._history:
                    self._history[name].append(record)
                if record.topic in (PROMPT, FRAME):
                    self.awaits_onset = True
                elif record.topic in (SHOWN, VOIDED, TRIAL):
                    self.awaits_onset = False
        while len(self._pending) > _MAX_PENDING:
            self._pending.popleft()
            self.missed = True

    def add_kept(self, topic: Topic[Any], message: Message) -> None:
        """Add the last value of a kept topic from before this tap, as in a resumed session."""
        if topic is not PRESENCE:  # nobody who was present then is present now
            self._last.setdefault(_slot(topic, message), Record(0, 0, topic, message))

    def clear(self) -> None:
        """Drop what is pending, as there are no peers."""
        self._pending.clear()
        self._blocks.clear()

    def take(self) -> list[Record]:
        """Return and remove the pending messages."""
        taken = list(self._pending)
        self._pending.clear()
        self.missed = False
        return taken

    def take_samples(self) -> dict[str, bytes]:
        """Return and remove the pending motion sensor samples, by seat."""
        taken: dict[str, bytes] = {}
        for block in self._blocks:
            taken[block.seat] = taken.get(block.seat, b"") + block.samples
        self._blocks.clear()
        return taken

    def snapshot(self) -> list[Record]:
        """Return the state of the session and its recent history, for a peer that has just
        joined.
        """
        records = [
            *self._last.values(),
            *(record for history in self._history.values() for record in history),
        ]
        return sorted(records, key=lambda record: record.seq)


def _slot(topic: Topic[Any], message: Message) -> tuple[str, str, str]:
    return topic.name, message.seat, getattr(message, "output", "")
