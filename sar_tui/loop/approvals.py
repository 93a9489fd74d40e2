"""Approvals: proposals and changes of level that wait for an operator."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from msgspec.structs import replace

from sar_tui.loop.action_queue import ActionQueue, accepted, edited, gesture_of
from sar_tui.loop.node import Node
from sar_tui.loop.topics import DECIDED, DROPPED, LEVEL_DECIDED, PENDING_APPROVAL
from sar_tui.model import messages as m
from sar_tui.model.messages import (
    Action,
    Decision,
    Dropped,
    Ground,
    LevelDecided,
    PendingApproval,
    Proposal,
    Utterance,
)
from sar_tui.model.theme import Theme
from sar_tui.rules import arbitration
from sar_tui.rules.parameters import TaskParameters


class Approvals:
    """Decides by the mode of its kind if a proposal waits for an operator, and follows decisions,
    deadlines and the presence of operators (see `rules.arbitration`).

    Args:
        node: the arbiter, which publishes what is decided.
        queue: of the actions that are decided.
        parameters: of the operator.

    Attributes:
        rules: the modes that are set.
    """

    def __init__(self, node: Node, queue: ActionQueue, parameters: TaskParameters) -> None:
        self._node = node
        self._queue = queue
        self._parameters = parameters
        self.rules = arbitration.start(parameters)
        self._pending = PendingApprovals()
        self._level_requests = 0
        self._outcomes: dict[tuple[str, int], _Outcome] = {}

    @property
    def waiting(self) -> tuple[PendingApproval, ...]:
        """The proposals that wait, oldest first."""
        return self._pending.waiting

    @property
    def next_deadline(self) -> int | None:
        """The earliest deadline (ns), if there is one."""
        return self._pending.next_deadline

    @property
    def is_operator_awaited(self) -> bool:
        """True if the session waits for a decision."""
        return any(arbitration.is_awaited(one) for one in self.waiting)

    @property
    def kinds_held_back(self) -> tuple[m.Kind, ...]:
        """Kinds of actions that must not come before what waits."""
        return _AFTER_FEEDBACK if any(map(arbitration.comes_first, self.waiting)) else ()

    # --- the session

    def begin_run(self) -> None:
        """Decide a pending level without an operator, and begin a run without one."""
        self._do_without_operator(_is_level)
        self.rules = replace(self.rules, operated=False)

    def begin_attempt(self) -> None:
        """Drop manual proposals when an attempt starts."""
        for pending in self._pending.remove(lambda one: one.deadline is None):
            self._give_up(pending, "manual", "mode")

    def note_outcome(self, ended: m.AttemptEnded) -> None:
        """Give up a pending level if its attempt, scored again, has another outcome and requested
        no new level.
        """
        here = (ended.seat, ended.attempt)
        known = {at: scored for at, scored in self._outcomes.items() if at[1] == ended.attempt}
        self._outcomes = {**known, here: _Outcome(ended.outcome, self._level_requests)}
        is_another = here in known and _is_failure(known) != _is_failure(self._outcomes)
        if is_another and known[here].level_requests == self._level_requests:
            self._give_up_levels("amended")

    def complete(self) -> None:
        """Decide feedback that waits, because the session is over."""
        self._do_without_decision(self._pending.remove(_is_feedback_with_deadline))

    # --- proposals

    def propose(self, proposal: Proposal) -> Proposal:
        """Queue a proposal, drop it, or ask an operator. Returns the proposal as it was decided on.

        Its gesture becomes a separate proposal if the mode of gestures requires it.
        """
        if not arbitration.is_gesture_separate(self.rules, self._parameters, proposal):
            self._decide(proposal)
            return proposal
        words = replace(proposal, gesture="")
        self._decide(words)
        if self.rules.operated:
            self._decide(gesture_of(proposal))
        return words

    def _decide(self, proposal: Proposal) -> None:
        verdict = arbitration.decide(
            self.rules, self._parameters, proposal, self._node.now, pending=self.waiting
        )
        match verdict.outcome:
            case "act":
                self._queue.add(accepted(proposal, ground=verdict.ground))
            case "drop":
                self._node.emit(DROPPED, Dropped(id=proposal.id, reason="no operator"))
            case "wait" if verdict.pending:
                self._ask_operator(verdict.pending)

    def _ask_operator(self, pending: PendingApproval) -> None:
        self._pending.add(pending)
        self._node.emit(PENDING_APPROVAL, pending)

    # --- the level

    def request_level(self, request: m.LevelRequest) -> m.LevelReply:
        """Allow a change of level, refuse it, or ask an operator; after the last attempt there is
        no time to ask.
        """
        change = request.change
        text = f"Level {change.previous} → {change.level}"
        proposal = Proposal(
            seat=change.seat, id=f"l{self._level_requests + 1}", kind="difficulty", text=text
        )
        now = self._node.now
        if request.is_last:
            verdict = arbitration.decide(self.rules, self._parameters, proposal, now)
            return m.LevelReply(happens=verdict.outcome == "act")
        self._level_requests += 1
        self._give_up_levels("amended")
        verdict = arbitration.decide(
            self.rules, self._parameters, proposal, now, change.level, self.waiting
        )
        if verdict.pending:
            self._ask_operator(verdict.pending)
        elif verdict.outcome == "drop":
            pending = PendingApproval(proposal=proposal, mode=self.rules.mode("difficulty"))
            self._decide_level(pending, "rejected", change.previous)
        return m.LevelReply(happens=verdict.outcome == "act")

    def reject_level(self, actor: str) -> None:
        """Drop a pending level, because an operator sets the level."""
        for pending in self._pending.remove(_is_level):
            self._decide_level(pending, "rejected", 0, actor, "operator")

    def _give_up_levels(self, reason: str) -> None:
        for pending in self._pending.remove(_is_level):
            self._give_up(pending, reason, "mode")

    def _decide_level(
        self,
        pending: PendingApproval,
        decision: str,
        level: int,
        actor: str = "agent",
        ground: Ground = "no operator",
    ) -> None:
        decided = LevelDecided(
            seat=pending.seat,
            id=pending.proposal.id,
            level=level,
            decision=decision,  # type: ignore[arg-type]
            actor=actor,
            ground=ground,
            at=self._node.now,
        )
        self._node.emit(LEVEL_DECIDED, decided)

    # --- operators

    def apply_decision(self, decision: Decision, theme: Theme) -> bool:
        """Carry out a decision on a proposal that waits; False if that does not wait."""
        pending = self._pending.take(decision.action)
        if pending is None:
            return False
        if decision.verdict == "veto":
            self._give_up(pending, "vetoed", "operator", decision.actor)
        elif pending.level is not None:
            level = (
                pending.level
                if decision.verdict == "accept" or decision.level is None
                else decision.level
            )
            how = "accepted" if level == pending.level else "edited"
            self._decide_level(pending, how, level, decision.actor, "operator")
        elif decision.verdict == "edit":
            action = accepted(pending.proposal, pending=pending)
            self._queue_decided(edited(action, decision, theme, self._node.now))
        else:
            self._act(pending, decision.actor, "operator")
        return True

    def set_mode(self, chosen: m.ModeChanged) -> None:
        """Apply a new mode, also to pending proposals."""
        self.rules = arbitration.set_mode(self.rules, chosen.kind, chosen.mode)
        for pending in self._pending.remove(
            lambda one: arbitration.CONTROLLED[one.proposal.kind] == chosen.kind
        ):
            verdict = arbitration.decide(
                self.rules,
                self._parameters,
                pending.proposal,
                self._node.now,
                pending.level,
                self.waiting,
            )
            if verdict.pending:
                self._ask_operator(verdict.pending)
            else:
                self._act(pending, chosen.actor, "operator")

    def set_presence(self, *, is_operated: bool) -> None:
        """Enable or disable the modes; without an operator, decide pending proposals as
        configured.
        """
        self.rules = replace(self.rules, operated=is_operated)
        if not is_operated:
            self._do_without_operator()

    def apply_deadlines(self) -> None:
        """Decide the proposals whose time is over."""
        self._do_without_decision(self._pending.take_due(self._node.now))

    def drop(self, which: Callable[[Utterance], bool], reason: str, actor: str) -> None:
        """Drop the proposals for which ``which`` is true."""
        for pending in self._pending.remove(lambda one: which(one.proposal)):
            self._give_up(pending, reason, "mode", actor)

    # --- what becomes of a proposal

    def _do_without_decision(self, undecided: Iterable[PendingApproval]) -> None:
        """Do what is planned for the case that nobody decides in time."""
        for pending in undecided:
            if pending.otherwise == "act":
                self._act(pending, "agent", "deadline")
            else:
                self._give_up(pending, "expired", "deadline")

    def _do_without_operator(
        self, which: Callable[[PendingApproval], bool] = lambda _: True
    ) -> None:
        for pending in self._pending.remove(which):
            if self._parameters.operator_lost == "autonomous":
                self._act(pending, "agent", "no operator")
            else:
                self._give_up(pending, "no operator", "no operator")

    def _act(self, pending: PendingApproval, actor: str, ground: Ground) -> None:
        """Accept a proposal as it is."""
        if pending.level is not None:
            self._decide_level(pending, "accepted", pending.level, actor, ground)
        else:
            action = accepted(pending.proposal, actor, ground, pending, self._node.now)
            self._queue_decided(action)

    def _queue_decided(self, action: Action) -> None:
        """Queue an action that was waited for, instead of the filler that covered the wait."""
        for filler in self._queue.remove(lambda waiting: waiting.kind == "filler"):
            self._node.emit(DROPPED, Dropped(id=filler.id, reason="late"))
        self._queue.add(action)
        self._node.emit(DECIDED, action)

    def _give_up(
        self, pending: PendingApproval, reason: str, ground: Ground, actor: str = "agent"
    ) -> None:
        """Drop a proposal."""
        if pending.level is not None:
            self._decide_level(pending, "rejected", 0, actor, ground)
        else:
            dropped = Dropped(id=pending.proposal.id, reason=reason, actor=actor)  # type: ignore[arg-type]
            self._node.emit(DROPPED, dropped)


class PendingApprovals:
    """The proposals that wait, in the order in which they were made."""

    def __init__(self) -> None:
        self._waiting: dict[str, PendingApproval] = {}

    @property
    def waiting(self) -> tuple[PendingApproval, ...]:
        """The pending proposals, oldest first."""
        return tuple(self._waiting.values())

    @property
    def next_deadline(self) -> int | None:
        """The earliest deadline (ns), if there is one."""
        return min(
            (one.deadline for one in self._waiting.values() if one.deadline is not None),
            default=None,
        )

    def add(self, pending: PendingApproval) -> None:
        """Add a proposal; it replaces one with the same id."""
        self._waiting[pending.proposal.id] = pending

    def take(self, id: str) -> PendingApproval | None:
        """Remove and return a proposal by its id; None if it does not wait."""
        return self._waiting.pop(id, None)

    def take_due(self, now: int) -> tuple[PendingApproval, ...]:
        """Remove and return the proposals whose deadline has passed."""
        return self.remove(lambda pending: pending.deadline is not None and pending.deadline <= now)

    def remove(self, which: Callable[[PendingApproval], bool]) -> tuple[PendingApproval, ...]:
        """Remove and return the proposals for which ``which`` is true."""
        gone = tuple(filter(which, self._waiting.values()))
        for pending in gone:
            del self._waiting[pending.proposal.id]
        return gone


class _Outcome(NamedTuple):
    """Outcome of an attempt at a seat, and the number of level requests made by then."""

    outcome: m.Outcome
    level_requests: int


_AFTER_FEEDBACK: tuple[m.Kind, ...] = ("encouragement", "rest")
"""Kinds of action that wait until pending feedback has been given."""


def _is_level(pending: PendingApproval) -> bool:
    return pending.level is not None


def _is_feedback_with_deadline(pending: PendingApproval) -> bool:
    return pending.proposal.kind == "feedback" and pending.deadline is not None


def _is_failure(scored: Mapping[tuple[str, int], _Outcome]) -> bool:
    """Return True if the attempt counts as a failure for the level: one of the seats failed."""
    return any(one.outcome == "failure" for one in scored.values())
