"""Node that links the bus to the broker process: sends messages to peers, and publishes the
operator's acts.
"""

import functools
import secrets
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

import msgspec

from sar_tui.link import protocol
from sar_tui.link.admission import DECLINED, VISIT_ENDED, ReportThrottle, role_of
from sar_tui.link.broker_process import (
    BrokerEnded,
    Channel,
    OutgoingAnswers,
    OutgoingBatch,
    OutgoingSamples,
    OutgoingSnapshot,
)
from sar_tui.link.peer import Welcome
from sar_tui.link.presence import ControlLock, needs_control
from sar_tui.link.protocol import (
    ActReceived,
    Admit,
    AnswersRequested,
    BrokerEvent,
    Deny,
    PeerJoined,
    PeerLeft,
    PeerUnproven,
    ProtocolError,
    RequestRefused,
    SnapshotRequested,
    VisitAsked,
)
from sar_tui.loop import topics as t
from sar_tui.loop.bus import Bus, Record, Topic
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import (
    ANSWERED,
    COMMAND,
    DECISION,
    FRAME,
    IMU,
    MODE,
    NOTE_ADDED,
    PRESENCE,
    PROMPT,
    PROPOSAL_SEEN,
    PROTOCOL,
    PROTOCOL_TICKED,
    REASON,
    REFUSED,
    REMARK,
    SHOWN,
    TRIAL,
    VISIT,
    VISIT_DECIDED,
    VOIDED,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import ImuBlock, Message
from sar_tui.model.units import MS, SECOND

BATCH_DELAY = 40 * MS
"""Messages are sent this long after the first of a batch."""
MAX_PROMPT_DELAY = 500 * MS
"""Nothing is sent while a prompt is on its way to the screen, but no longer than this."""
MAX_ACT_AGE = 60 * SECOND
"""Older stamps of acts are moved up to this age, as they must be wrong."""
_CHECK_INTERVAL = SECOND
_MAX_ANSWERS = 5_000
"""Number of acts of a peer whose answers are remembered: those of minutes, even in a flood."""


class LinkNode(Node):
    """Connects the bus to the broker process, and decides which operator is in control.

    Args:
        channel: connection to the broker process.

    Attributes:
        welcome: description of the session, to be set before it starts; each peer gets it with its
            own name and role.
        trial_mark: returns the trial that a mark is put on now, and the mark that is on it.
    """

    welcome: Welcome

    name = "link"
    emits: ClassVar[tuple[Topic[Any], ...]] = (
        COMMAND,
        DECISION,
        REMARK,
        MODE,
        PROPOSAL_SEEN,
        NOTE_ADDED,
        PROTOCOL,
        PROTOCOL_TICKED,
        REASON,
        PRESENCE,
        REFUSED,
        VISIT,
    )

    def __init__(self, channel: Channel) -> None:
        super().__init__()
        self.trial_mark: Callable[[], TrialMark] = TrialMark
        self._channel = channel
        self._agreed: set[str] = set()
        """Those whom the participant lets watch, if it is a visit."""
        self._asking: set[str] = set()
        self._visit_refusal = ""
        self._feed = SessionFeed()
        self._control = ControlLock()
        self._run = secrets.token_hex(8)
        self._answers: defaultdict[str, dict[str, m.ActAnswered | None]] = defaultdict(dict)
        """Answers to the acts of this run by peer and id; None while the session has not
        answered."""
        self._number = 0
        self._refused: ReportThrottle[tuple[str, str, str]] = ReportThrottle()
        self._need_snapshot: dict[str, None] = {}
        self._is_scheduled = self._is_detached = False
        self._delayed_since: int | None = None

    def attach(self, bus: Bus) -> None:
        """Join a bus and start to listen to the broker process."""
        super().attach(bus)
        for topic in SENT:
            if topic.keep:
                bus.subscribe(topic, functools.partial(self._feed.add_kept, topic), self.name)
        bus.tap(self._tapped)
        self._channel.listen(lambda event: bus.clock.call_soon(lambda: self.receive(event)))
        self._check()

    def detach(self) -> None:
        """Send what is pending and ignore the broker process from now on. Its opener closes it."""
        if hasattr(self, "bus") and not self._is_detached:
            self._send()
            self._is_detached = True

    # --- from the broker process

    def receive(self, event: BrokerEvent | BrokerEnded) -> None:  # noqa: PLR0912
        """Handle an event of the broker process, on the bus' own thread."""
        if self._is_detached:
            return
        match event:
            case VisitAsked(name=name, withdrawn=is_withdrawn):
                self._visit_asked(name, is_withdrawn=is_withdrawn)
            case PeerJoined(name=name):
                self._peer_joined(name)
            case PeerLeft(name=name, state=state, detail=detail):
                self._peer_left(name, state, detail)
            case PeerUnproven(name=name, detail=detail):
                self._peer_unproven(name, detail)
            case SnapshotRequested(name=name):
                self._need_snapshot[name] = None
                self._schedule(0)
            case ActReceived(name=name, topic=protocol.TAKE_CONTROL):
                self._take_control(name)
            case ActReceived():
                self._act_received(event)
            case AnswersRequested(name=name, ids=ids):
                self._answers_requested(name, ids)
            case RequestRefused(name=name, what=what, why=why, count=count):
                self._report_refused(name, what, why, count)
            case BrokerEnded(detail=detail, is_final=is_final):
                for name in list(self._control.peers):
                    self._peer_left(name, "lost", detail)
                if is_final:
                    self._refuse("link", "the link", detail)

    def _visit_asked(self, name: str, *, is_withdrawn: bool) -> None:
        """Ask the participant whether somebody may watch, unless they have answered: the broker
        process, which was started again, may not know.
        """
        if name in self._agreed:
            self._channel.send(Admit(name))
        elif self._visit_refusal:
            self._channel.send(Deny(self._visit_refusal))
        elif is_withdrawn == (name in self._asking):
            self._asking ^= {name}
            state: Any = "withdrawn" if is_withdrawn else "asked"
            self.emit(VISIT, m.VisitRequested(actor=name, state=state))

    @on(VISIT_DECIDED)
    def visit_decided(self, decided: m.VisitDecided) -> None:
        """Let those watch whom the participant agreed to, or nobody."""
        if not self._channel.is_visit:
            return
        self._asking.clear()
        if decided.outcome == "agreed":
            for name in decided.peers:
                self._agreed.add(name)
                self._channel.send(Admit(name))
            return
        self._agreed.clear()
        self._visit_refusal = DECLINED if decided.outcome == "declined" else VISIT_ENDED
        for name in list(self._control.peers):
            self._peer_left(name, "left", VISIT_ENDED)
        self._channel.send(Deny(self._visit_refusal))

    def _peer_joined(self, name: str) -> None:
        role = role_of(name)
        if role is None or name in self._control.peers:
            return
        if self._channel.is_visit and name not in self._agreed:
            return
        holder = self._control.holder
        self._control.join(name, role)
        self._report_presence(name, role, "joined")
        self._report_holder(holder)

    def _peer_left(self, name: str, state: str, detail: str) -> None:
        if (role := self._control.peers.get(name)) is None:
            return
        holder = self._control.holder
        self._control.leave(name)
        self._need_snapshot.pop(name, None)
        self._report_presence(name, role, "left" if state == "left" else "lost", detail)
        self._report_holder(holder)

    def _peer_unproven(self, name: str, detail: str) -> None:
        if role := self._control.peers.get(name):
            self._report_presence(name, role, "unproven", detail)

    def _take_control(self, name: str) -> None:
        holder = self._control.holder
        if self._control.take(name):
            self._report_holder(holder)
        else:
            self._refuse(
                name, protocol.TAKE_CONTROL, "Only an operator who is connected can take it."
            )

    def _act_received(self, received: ActReceived) -> None:
        """Publish an act with its sender's name and a plausible stamp, or answer why not. An id is
        accepted once.
        """
        name, topic, id = received.name, received.topic, received.id
        if topic == PROPOSAL_SEEN.name and name != self._control.holder:
            return  # each operator's panel shows proposals
        if id and id in self._answers[name]:
            self._answers_requested(name, (id,))
            return
        try:
            act = self._checked(received)
        except ProtocolError as error:
            self._refuse(name, topic, str(error))
            if id:
                self._remember(name, id, self._refusal(name, id, str(error)))
                self._answers_requested(name, (id,))
            return
        now = self.bus.clock.now()
        at = now if not act.at else min(now, max(act.at, now - MAX_ACT_AGE))
        act = msgspec.structs.replace(act, actor=name, at=at)
        if id and isinstance(act, m.OperatorAct):
            act = msgspec.structs.replace(act, id=id)
            self._remember(name, id, None)
        self.emit(protocol.OPERATOR_TOPICS[topic], act)

    def _checked(self, received: ActReceived) -> Any:
        """Return the act of the operator in control, or anybody's stop. Raises ProtocolError if it
        may not be published.
        """
        act: Any = protocol.decode_act(received.topic, received.message)
        if received.name != self._control.holder and needs_control(act):
            raise ProtocolError("Another operator is in control.")
        if self.welcome.participants and act.seat not in self.welcome.participants:
            raise ProtocolError("There is no such seat in this session.")
        is_mark = isinstance(act, m.SessionCommand) and act.command == "mark"
        if is_mark and all(mark.name != act.reason for mark in self.welcome.marks):
            raise ProtocolError("There is no such mark in this task.")
        return act

    # --- answers
    # -----------------------------------------------------------------------------------------------

    @on(ANSWERED)
    def answered(self, answer: m.ActAnswered) -> None:
        """Remember the session's answer to an act, as its message may be lost on the way."""
        if answer.id in self._answers[answer.actor]:
            self._remember(answer.actor, answer.id, answer)

    def _answers_requested(self, name: str, ids: Iterable[str]) -> None:
        """Send a peer the answers to its acts, except to those under way. An act that has not
        arrived until now is refused from now on.
        """
        answers = self._answers[name]
        for id in ids:
            if id not in answers:
                self._remember(name, id, self._refusal(name, id, "It did not arrive."))
        known = [answer for id in ids if (answer := answers[id])]
        if known:
            self._channel.send(OutgoingAnswers(name, known))

    def _refusal(self, name: str, id: str, why: str) -> m.ActAnswered:
        now = self.bus.clock.now()
        return m.ActAnswered(id=id, actor=name, outcome="refused", why=why, at=now)

    def _remember(self, name: str, id: str, answer: m.ActAnswered | None) -> None:
        answers = self._answers[name]
        answers[id] = answer
        if len(answers) > _MAX_ANSWERS:
            del answers[next(iter(answers))]

    def _refuse(self, name: str, what: str, why: str) -> None:
        """Report that a request was refused, at most once a second if it is repeated."""
        if count := self._refused.add((name, what, why), self.bus.clock.now()):
            self._report_refused(name, what, why, count)

    def _report_refused(self, name: str, what: str, why: str, count: int) -> None:
        self.emit(REFUSED, m.PeerRequestRefused(actor=name, what=what, why=why, count=count))

    def _report_holder(self, before: str) -> None:
        """Report who is in control, if that changed."""
        holder = self._control.holder
        if holder and holder != before:
            self._report_presence(holder, "operator", "baton")

    def _report_presence(self, name: str, role: m.Role, state: Any, detail: str = "") -> None:
        changed = m.OperatorChanged(
            actor=name,
            role=role,
            state=state,
            operated=bool(self._control.holder),
            holder=self._control.holder,
            detail=detail,
            peers=dict(self._control.peers),
        )
        self.emit(PRESENCE, changed)

    # --- to the peers

    def _tapped(self, cascade: list[Record]) -> None:
        self._feed.add(cascade)
        if not self._control.peers:
            self._feed.clear()
        elif self._feed.has_news:
            self._schedule(BATCH_DELAY)

    def _schedule(self, delay: int) -> None:
        if not self._is_scheduled and not self._is_detached:
            self._is_scheduled = True
            clock = self.bus.clock
            clock.call_at(clock.now() + delay, self._send_due)

    def _send_due(self) -> None:
        """Send, or wait a little longer if a prompt is on its way to the screen."""
        self._is_scheduled = False
        if self._is_detached:
            return
        now = self.bus.clock.now()
        self._delayed_since = (self._delayed_since or now) if self._feed.awaits_onset else None
        if self._delayed_since is not None and now - self._delayed_since < MAX_PROMPT_DELAY:
            self._schedule(BATCH_DELAY)
            return
        self._send()

    def _send(self) -> None:
        """Send pending messages, and snapshots to new peers; after a loss, to all peers."""
        missed = self._feed.missed
        if records := self._feed.take():
            self._number += 1
            missed |= not self._channel.send(OutgoingBatch(self._number, records))
        for seat, samples in self._feed.take_samples().items():
            self._channel.send(OutgoingSamples(seat, samples))
        if missed:
            self._need_snapshot |= dict.fromkeys(self._control.peers)
        snapshot = self._feed.snapshot() if self._need_snapshot else []
        for name in list(self._need_snapshot):
            role = role_of(name) or "observer"
            welcome = msgspec.structs.replace(
                self.welcome,
                name=name,
                role=role,
                run=self._run,
                trial_mark=self.trial_mark(),
            )
            if self._channel.send(OutgoingSnapshot(name, self._number, welcome, snapshot)):
                del self._need_snapshot[name]
        if self._need_snapshot:
            self._schedule(SECOND)

    def _check(self) -> None:
        """Check regularly that the broker process answers, and report what was refused since."""
        if not self._is_detached:
            self._channel.check()
            clock = self.bus.clock
            for (name, what, why), count in self._refused.due(clock.now()):
                self._report_refused(name, what, why, count)
            clock.call_at(clock.now() + _CHECK_INTERVAL, self._check)


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
    t.PROTOCOL, t.PROTOCOL_DUE, t.PROTOCOL_TICKED, t.REASON, t.ANSWERED, t.VISIT, t.VISIT_DECIDED,
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
    t.NOTE_ADDED, t.PROTOCOL_DUE, t.PROTOCOL_TICKED,
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
