"""Practice: a recorded session on the panel, where a trainee decides instead of its operator.

Nothing is written into the recorded session. It waits while a proposal waits for the trainee, and
is only faster than it was while none does.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, Literal

import msgspec
from msgspec.structs import replace

from sar_tui.link.node import SENT
from sar_tui.link.peer import Frame, Welcome
from sar_tui.loop import topics as t
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.model.messages import Message
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.units import SECOND
from sar_tui.operator.commands import REASON_FOR
from sar_tui.reports.logged_messages import LoggedMessage
from sar_tui.reports.proposals import proposal_records
from sar_tui.reports.protocol import Adherence, adherence
from sar_tui.reports.protocol_words import section as protocol_section
from sar_tui.reports.sections import Section, Table
from sar_tui.rules.arbitration import CONTROLLED, start, time_to_decide
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.protocol import ProtocolProgress, step, verdict_on
from sar_tui.store.messages import StoredMessage

_HIDDEN = {
    topic.name
    for topic in (
        t.PENDING_APPROVAL,
        t.ARBITER_STATE,
        t.DECISION,
        t.REMARK,
        t.MODE,
        t.PROPOSAL_SEEN,
        t.NOTE_ADDED,
        t.PRESENCE,
        t.REFUSED,
        t.PROTOCOL,
        t.PROTOCOL_DUE,
        t.PROTOCOL_TICKED,
        t.REASON,
        t.LATE_DECISION,
        t.ANSWERED,
    )
}
"""Topics of the recorded operator, and of what the trainee's own acts lead to."""
_SHOWN = {topic.name for topic in SENT} - _HIDDEN
_IMPOSSIBLE = ("pause", "resume", "skip", "repeat", "end", "undo", "mark", "hold", "release")
"""Commands that cannot change a recorded session."""
_PAUSE_BEFORE_RUN = SECOND
_LONGEST = 40
"""Characters of a proposal's text that the result shows."""

Choice = Literal["accepted", "edited", "vetoed", ""]
"""A decision on a proposal; empty: none in time, or none is known."""


class PractisedProposal(msgspec.Struct, frozen=True):
    """A proposal of the recorded session, and who decided what on it.

    Attributes:
        yours: the trainee's decision; ``recorded``: that of the recorded operator.
        protocol: what the protocol asked for, if it did.
        decision_ms: from its appearance on the screen to the trainee's key.
    """

    id: str
    kind: str
    text: str
    yours: Choice = ""
    recorded: Choice = ""
    protocol: Choice = ""
    decision_ms: float | None = None


class Agreed(msgspec.Struct, frozen=True):
    """Proposals on which the trainee decided as somebody else, ``of`` all who did."""

    same: int
    of: int


class PracticeResult(msgspec.Struct, frozen=True):
    """Result of a practice.

    Attributes:
        is_complete: the recorded session was played to its end.
        decided: proposals on which the trainee decided; ``timed_out``: the others.
        as_protocol, as_recorded: how often as the protocol and as the recorded operator.
        adherence: as of a session, with everything that was due.
    """

    session: str
    operator: str
    is_complete: bool
    decided: int
    timed_out: int
    as_protocol: Agreed
    as_recorded: Agreed
    proposals: list[PractisedProposal]
    adherence: Adherence


class Practice:
    """A recorded session in which a trainee decides. No screen, no clock of its own.

    Args:
        records: messages of the session.
        welcome: its description, with the trainee's name.
        parameters: of its task.
        protocol: by which the trainee works.
        speed: how many times as fast as it was, while nothing waits for the trainee.

    Attributes:
        now: time in the practice (ns).
    """

    def __init__(
        self,
        records: Sequence[StoredMessage],
        welcome: Welcome,
        parameters: TaskParameters,
        protocol: WizardProtocol,
        speed: float = 1.0,
    ) -> None:
        self.welcome, self.speed = welcome, speed
        self._records, self._parameters, self._protocol = records, parameters, protocol
        self._next = self._seq = 0
        self._times = _playing_times(records)
        self._delay = 0
        self.now = records[0].at if records else 0
        self._asks_pending = any(one.topic is t.PENDING_APPROVAL for one in records)
        self._modes = start(parameters).modes
        self._pending: dict[str, m.PendingApproval] = {}
        self._asked: dict[str, m.Proposal] = {}
        self._expected: dict[str, Choice] = {}
        self._hidden_actions: set[str] = set()
        self._reason_until = 0
        self._progress = ProtocolProgress()
        self._due: dict[str, m.ProtocolDue] = {}
        self._log: list[LoggedMessage] = []

    @property
    def is_over(self) -> bool:
        """True if all was shown and nothing waits."""
        return self._next == len(self._records) and not self._pending

    @property
    def rate(self) -> float:
        """Speed of time: as it was, while a proposal, a tick or a reason waits for the trainee."""
        waits = self._pending or self._due or self.now < self._reason_until
        return 1.0 if waits else self.speed

    # --- what the panel gets

    def begin(self) -> list[Frame]:
        """Return the first frames: the trainee has control, and the protocol."""
        name = self.welcome.name
        joined = m.OperatorChanged(
            actor=name, state="joined", operated=True, holder=name, peers={name: "operator"}
        )
        started = m.SessionStarted(run=1, task=self.welcome.task, theme="", seed=0)
        self._note(started)
        chosen = m.ProtocolChosen(protocol=self._protocol, actor=name, at=self.now)
        frames = [self._frame(t.PRESENCE, joined), self._frame(t.PROTOCOL, chosen)]
        return [*frames, self._state(), *self._step(chosen)]

    def advance(self, elapsed: int) -> list[Frame]:
        """Return what happens in the next ``elapsed`` ns of real time."""
        until, frames = self.now + round(elapsed * self.rate), list[Frame]()
        while True:
            at = min((each.deadline or until for each in self._pending.values()), default=None)
            if at is None:
                if self._next == len(self._records):
                    break
                at = self._next_at()
            if at > until:
                break
            self.now = max(self.now, at)
            frames += self._expire() if self._pending else self._show_next()
        self.now = until
        return frames

    def act(self, topic: Topic[Any], act: Any) -> list[Frame]:
        """Return what follows from an act of the trainee."""
        self._note(act)
        if topic is t.PROPOSAL_SEEN:
            return []
        asks_reason = isinstance(act, m.Decision) and act.verdict != "accept"
        self._reason_until = self.now + REASON_FOR if asks_reason else 0
        outcome: m.ActOutcome = "done"
        why, frames = "", list[Frame]()
        match act:
            case m.Decision() if act.action in self._pending:
                frames = self._decided(act)
            case m.Decision():
                outcome, why = "late", "It was decided, or its time was over."
            case m.ProtocolTicked() if act.due in self._due:
                del self._due[act.due]
                frames = [self._frame(topic, act)]
            case m.ProtocolTicked():
                outcome, why = "late", "It was ticked already, or is not due."
            case m.SessionCommand() if act.command in _IMPOSSIBLE:
                outcome, why = "refused", "A recorded session cannot be changed."
        answer = answer_to(act, self.now, outcome, why)
        return [*frames, self._frame(t.ANSWERED, answer)]

    # --- the recorded session

    def _next_at(self) -> int:
        """Return when the next message is shown: later if the practice waited for the trainee."""
        at = self._times[self._next]
        if at + self._delay < self.now - SECOND:
            self._delay = self.now - at
        return at + self._delay

    def _show_next(self) -> list[Frame]:
        record = self._records[self._next]
        self._next += 1
        message: Any = record.message
        frames = []
        if self._is_shown(record.topic, message):
            if isinstance(message, m.Action):
                message = replace(message, decided=message.decided + self.now - record.at)
            frames.append(self._frame(record.topic, message))
        if (asked := self._to_ask(message)) and asked.proposal.id not in self._asked:
            self._asked[asked.proposal.id] = asked.proposal
            self._pending[asked.proposal.id] = asked
            self._log.append(LoggedMessage(1, self.now, asked.proposal))
            self._note(asked)
            frames.append(self._state())
        return [*frames, *self._step(message)]

    def _is_shown(self, topic: Topic[Any], message: Any) -> bool:
        """Return True unless a message reveals what the recorded operator did."""
        if topic.name not in _SHOWN:
            return False
        if isinstance(message, m.SessionCommand):
            return not message.actor.startswith("operator.")
        if isinstance(message, m.Action) and (
            message.kind == "remark" or message.id in self._hidden_actions
        ):
            self._hidden_actions.add(message.id)
            return False
        action = getattr(message, "action", "")
        return not (isinstance(action, str) and action in self._hidden_actions)

    def _to_ask(self, message: Message) -> m.PendingApproval | None:
        """Return what the trainee is asked to decide: what waited for the recorded operator; if
        nothing did, all that the agent proposed, apart from gestures.
        """
        proposal, level = None, None
        if isinstance(message, m.PendingApproval):
            proposal, level = message.proposal, message.level
        elif not self._asks_pending and isinstance(message, m.Proposal):
            proposal = message if CONTROLLED.get(message.kind, "gesture") != "gesture" else None
        if proposal is None:
            return None
        deadline = self.now + time_to_decide(self._parameters, [proposal])
        return m.PendingApproval(
            seat=proposal.seat,
            proposal=proposal,
            mode="approve",
            deadline=deadline,
            otherwise="act",
            level=level,
        )

    # --- the trainee

    def _decided(self, decision: m.Decision) -> list[Frame]:
        asked = self._pending.pop(decision.action)
        self._expected[decision.action] = self._wanted(asked)
        name = self.welcome.name
        if decision.verdict == "veto":
            self._hidden_actions.add(decision.action)
            outcome: Message = m.Dropped(id=decision.action, reason="vetoed", actor=name)
        else:
            said = {field: getattr(asked.proposal, field) for field in m.Proposal.__struct_fields__}
            if decision.text is not None:
                said["text"] = decision.text
            if decision.valence is not None:
                said["valence"] = decision.valence
            done: Any = "accepted" if decision.verdict == "accept" else "edited"
            outcome = m.Action(**said, decision=done, actor=name, ground="operator")
        self._note(outcome)
        return [self._state()]

    def _expire(self) -> list[Frame]:
        """Decide without the trainee on what has waited for too long."""
        for id, asked in list(self._pending.items()):
            if (asked.deadline or 0) <= self.now:
                del self._pending[id]
                self._expected[id] = self._wanted(asked)
        return [self._state()]

    def _wanted(self, asked: m.PendingApproval) -> Choice:
        """Return the decision that is due by the protocol now."""
        for due in self._due.values():
            if verdict := verdict_on(asked.proposal, due, self._protocol):
                return "vetoed" if verdict == "veto" else "accepted"
        return ""

    def _step(self, message: Message) -> list[Frame]:
        self._progress, due = step(self._progress, message, self.now)
        frames = []
        for each in due:
            self._due[each.id] = each
            frames.append(self._frame(t.PROTOCOL_DUE, each))
        return frames

    def _state(self) -> Frame:
        pending = tuple(self._pending.values())
        state = m.ArbiterState(modes=self._modes, operated=True, pending=pending)
        return self._frame(t.ARBITER_STATE, state)

    def _frame(self, topic: Topic[Any], message: Message) -> Frame:
        self._seq += 1
        if topic.name in _HIDDEN and topic is not t.ARBITER_STATE:
            self._note(message)
        return Frame(self._seq, self.now, topic, message)

    def _note(self, message: Message) -> None:
        if not (self._log and self._log[-1].message is message):
            self._log.append(LoggedMessage(1, self.now, message))

    # --- the result

    def result(self) -> PracticeResult:
        """Return what came out until now."""
        own = {one.id: one for one in proposal_records(self._log, self._parameters)}
        recorded = _recorded_choices(self._records, self._parameters)
        proposals = [
            PractisedProposal(
                id=id,
                kind=proposal.kind,
                text=proposal.text or proposal.spoken,
                yours=own[id].verdict or "",
                recorded=recorded.get(id, ""),
                protocol=self._expected.get(id, ""),
                decision_ms=own[id].decision_ms,
            )
            for id, proposal in self._asked.items()
            if id not in self._pending
        ]
        followed = adherence(self._log, own.values(), [self.welcome.name])
        assert followed, "a practice begins with its protocol"
        decided = sum(bool(each.yours) for each in proposals)
        return PracticeResult(
            session=self.welcome.session,
            operator=self.welcome.name,
            is_complete=self.is_over,
            decided=decided,
            timed_out=len(proposals) - decided,
            as_protocol=_agreed((each.yours, each.protocol) for each in proposals),
            as_recorded=_agreed((each.yours, each.recorded) for each in proposals),
            proposals=proposals,
            adherence=followed,
        )


def _playing_times(records: Sequence[StoredMessage]) -> list[int]:
    """Return when each message is shown (ns): as it was; but a run begins soon after the last one,
    whose clock was another.
    """
    times: list[int] = []
    shift = 0
    for before, record in pairwise((records[0], *records)) if records else ():
        if record.run != before.run:
            shift = times[-1] + _PAUSE_BEFORE_RUN - record.at
        times.append(record.at + shift)
    return times


def _recorded_choices(
    records: Sequence[StoredMessage], parameters: TaskParameters
) -> dict[str, Choice]:
    """Return the recorded operators' decisions by the ids of their proposals."""
    logged = [LoggedMessage(one.run, one.at, one.message) for one in records]
    return {one.id: one.verdict for one in proposal_records(logged, parameters) if one.verdict}


def _agreed(pairs: Iterator[tuple[Choice, Choice]]) -> Agreed:
    known = [(yours, other) for yours, other in pairs if other]
    return Agreed(sum(yours == other for yours, other in known), len(known))


# --- the result in words


def sections(found: PracticeResult) -> list[Section]:
    """Return the result in words."""
    table: list[Table] = []
    if found.proposals:
        rows = [
            (
                each.kind,
                each.text if len(each.text) <= _LONGEST else f"{each.text[:_LONGEST]}…",
                each.yours or "no decision",
                each.protocol,
                each.recorded,
                "" if each.decision_ms is None else f"{each.decision_ms / 1000:.1f}",
            )
            for each in found.proposals
        ]
        heads = ("proposal", "text", "you", "protocol", "recorded", "s")
        table.append(Table(heads, rows, ("s",), ("you", "protocol", "recorded")))
    said = "\n".join(_sentences(found))
    return [Section("Practice", [said, *table]), protocol_section(found.adherence)]


def _sentences(found: PracticeResult) -> Iterator[str]:
    n = found.decided + found.timed_out
    end = "" if found.is_complete else " It was left before its end."
    yield f"Practice on session {found.session}.{end}"
    yield f"{n} proposal{'' if n == 1 else 's'}: {found.decided} decided in time."
    yield f"As the protocol says: {_share(found.as_protocol, 'it asks for no decision')}."
    yield f"As the recorded operator: {_share(found.as_recorded, 'nobody decided')}."


def _share(agreed: Agreed, none: str) -> str:
    return f"{agreed.same} of {agreed.of}" if agreed.of else none
