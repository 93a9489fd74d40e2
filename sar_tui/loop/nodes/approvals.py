"""Approvals: proposals and changes of level that wait for an operator."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from msgspec.structs import replace

from sar_tui.loop.action_queue import ActionQueue
from sar_tui.loop.actions import accepted, edited, gesture_of
from sar_tui.loop.node import TimedNode, serves
from sar_tui.loop.pending_approvals import PendingApprovals
from sar_tui.loop.topics import DECIDED, DROPPED, LEVEL_DECIDED, LEVEL_REQUEST, PENDING_APPROVAL
from sar_tui.model import messages as m
from sar_tui.model.messages import (
    Action,
    Decision,
    Dropped,
    Ground,
    LevelDecided,
    PendingApproval,
    Proposal,
)
from sar_tui.model.theme import Theme
from sar_tui.rules import arbitration
from sar_tui.rules.settings.operator import OperatorSettings


class _Outcome(NamedTuple):
    """Outcome of an attempt at a seat, and the number of level requests made by then."""

    outcome: m.Outcome
    level_requests: int


class Approvals(TimedNode, ABC):
    """The part of the arbiter that handles decisions, deadlines and the presence of operators.

    The mode of each kind of action determines whether a proposal waits for approval (see
    `policies.arbitration`).
    """

    def __init__(self, parameters: OperatorSettings, theme: Theme) -> None:
        super().__init__()
        self._parameters = parameters
        self._theme = theme
        self._rules = arbitration.start(parameters)
        self._pending = PendingApprovals()
        self._queue = ActionQueue()
        self._level_requests = 0
        self._outcomes: dict[tuple[str, int], _Outcome] = {}

    @abstractmethod
    def _publish_state(self) -> None:
        """Publish what changed."""

    # --- proposals

    def _decide_proposal(self, proposal: Proposal) -> Proposal:
        """Queue a proposal, drop it, or ask an operator. Returns the proposal as it was decided on.

        Its gesture becomes a separate proposal if the mode of gestures requires it.
        """
        if not arbitration.is_gesture_separate(self._rules, self._parameters, proposal):
            self._decide(proposal)
            return proposal
        words = replace(proposal, gesture="")
        self._decide(words)
        if self._rules.operated:
            self._decide(gesture_of(proposal))
        return words

    def _decide(self, proposal: Proposal) -> None:
        verdict = arbitration.decide(
            self._rules, self._parameters, proposal, self.now, pending=self._pending.waiting
        )
        match verdict.outcome:
            case "act":
                self._queue.add(accepted(proposal, ground=verdict.ground))
            case "drop":
                self.emit(DROPPED, Dropped(id=proposal.id, reason="no operator"))
            case "wait" if verdict.pending:
                self._ask_operator(verdict.pending)

    def _ask_operator(self, pending: PendingApproval) -> None:
        self._pending.add(pending)
        self.emit(PENDING_APPROVAL, pending)

    # --- the level

    @serves(LEVEL_REQUEST)
    def level_requested(self, request: m.LevelRequest) -> m.LevelReply:
        """Allow a change of level, refuse it, or ask an operator; after the last attempt there is
        no time to ask.
        """
        change = request.change
        text = f"Level {change.previous} → {change.level}"
        proposal = Proposal(
            seat=change.seat, id=f"l{self._level_requests + 1}", kind="difficulty", text=text
        )
        if request.is_last:
            verdict = arbitration.decide(self._rules, self._parameters, proposal, self.now)
            return m.LevelReply(happens=verdict.outcome == "act")
        self._level_requests += 1
        self._give_up_levels("amended")
        verdict = arbitration.decide(
            self._rules, self._parameters, proposal, self.now, change.level, self._pending.waiting
        )
        if verdict.pending:
            self._ask_operator(verdict.pending)
        elif verdict.outcome == "drop":
            pending = PendingApproval(proposal=proposal, mode=self._rules.mode("difficulty"))
            self._decide_level(pending, "rejected", change.previous)
        self._publish_state()
        return m.LevelReply(happens=verdict.outcome == "act")

    def _note_outcome(self, ended: m.AttemptEnded) -> None:
        """Give up a pending level if its attempt, scored again, has another outcome and requested
        no new level.
        """
        here = (ended.seat, ended.attempt)
        known = {at: scored for at, scored in self._outcomes.items() if at[1] == ended.attempt}
        self._outcomes = {**known, here: _Outcome(ended.outcome, self._level_requests)}
        is_another = here in known and _is_failure(known) != _is_failure(self._outcomes)
        if is_another and known[here].level_requests == self._level_requests:
            self._give_up_levels("amended")

    def _give_up_levels(self, reason: str) -> None:
        for pending in self._pending.remove(is_level):
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
            at=self.now,
        )
        self.emit(LEVEL_DECIDED, decided)

    # --- pending proposals

    def _apply_decision(self, pending: PendingApproval, decision: Decision) -> None:
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
            self._queue_decided(edited(action, decision, self._theme, self.now))
        else:
            self._act(pending, decision.actor, "operator")

    def _apply_mode(self, chosen: m.ModeChanged) -> None:
        """Apply a new mode, also to pending proposals."""
        self._rules = arbitration.set_mode(self._rules, chosen.kind, chosen.mode)
        for pending in self._pending.remove(
            lambda one: arbitration.CONTROLLED[one.proposal.kind] == chosen.kind
        ):
            verdict = arbitration.decide(
                self._rules,
                self._parameters,
                pending.proposal,
                self.now,
                pending.level,
                self._pending.waiting,
            )
            if verdict.pending:
                self._ask_operator(verdict.pending)
            else:
                self._act(pending, chosen.actor, "operator")

    def _apply_presence(self, is_operated: bool) -> None:
        """Enable or disable the modes; without an operator, decide pending proposals as
        configured.
        """
        self._rules = replace(self._rules, operated=is_operated)
        if not is_operated:
            self._do_without_operator()

    def _apply_deadlines(self) -> None:
        self._do_without_decision(self._pending.take_due(self.now))

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
            self._queue_decided(accepted(pending.proposal, actor, ground, pending, self.now))

    def _queue_decided(self, action: Action) -> None:
        """Queue an action that was waited for, instead of the filler that covered the wait."""
        for filler in self._queue.remove(lambda waiting: waiting.kind == "filler"):
            self.emit(DROPPED, Dropped(id=filler.id, reason="late"))
        self._queue.add(action)
        self.emit(DECIDED, action)

    def _give_up(
        self, pending: PendingApproval, reason: str, ground: Ground, actor: str = "agent"
    ) -> None:
        """Drop a proposal."""
        if pending.level is not None:
            self._decide_level(pending, "rejected", 0, actor, ground)
        else:
            self.emit(DROPPED, Dropped(id=pending.proposal.id, reason=reason, actor=actor))  # type: ignore[arg-type]


def is_level(pending: PendingApproval) -> bool:
    """Return True if the proposal changes the level."""
    return pending.level is not None


def _is_failure(scored: Mapping[tuple[str, int], _Outcome]) -> bool:
    """Return True if the attempt counts as a failure for the level: one of the seats failed."""
    return any(one.outcome == "failure" for one in scored.values())
