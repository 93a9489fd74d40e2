"""The action queue begins one action at a time, by priority; an edit changes only what the operator
changed.
"""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from sar_tui.loop.action_queue import ActionQueue, accepted, edited
from sar_tui.loop.approvals import PendingApprovals
from sar_tui.model.messages import (
    Action,
    ActionPart,
    Decision,
    PendingApproval,
    Policy,
    Proposal,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from tests.facts import facts

POLICIES: tuple[Policy, ...] = ("queue", "interrupt", "drop")
OPEN: set[tuple[str, ActionPart]] = {("speech", "say"), ("robot", "gesture"), ("robot", "say")}


def proposal(
    name: str, priority: int = 0, policy: Policy = "queue", due: int = 0, seat: str = "A"
) -> Proposal:
    return Proposal(
        seat=seat, id=name, kind="feedback", text=name, priority=priority, policy=policy, due=due
    )


def begun(queue: ActionQueue, one: Proposal) -> ActionQueue:
    queue.add(one)
    queue.begin(one, OPEN)
    return queue


@given(st.integers(0, 9), st.integers(0, 9), st.sampled_from(POLICIES))
def test_only_an_interrupting_action_of_at_least_equal_priority_replaces_the_current_one(
    under_way: int, priority: int, policy: Policy
) -> None:
    queue = begun(ActionQueue(), proposal("first", under_way))
    second = proposal("second", priority, policy)
    queue.add(second)
    assert queue.next(0) == (second if policy == "interrupt" and priority >= under_way else None)


def test_feedback_for_one_seat_does_not_interrupt_that_for_the_other() -> None:
    queue = begun(ActionQueue(), proposal("to B", 40, "queue", seat="B"))
    queue.add(proposal("to A", 40, "interrupt"))
    assert queue.next(0) is None
    queue.add(proposal("to B again", 40, "interrupt", seat="B"))
    queue.take("to A")
    assert [waiting.id for waiting in queue.waiting] == ["to B again"]
    assert queue.next(0) in queue.waiting


def test_feedback_for_either_seat_interrupts_less_important_actions() -> None:
    queue = begun(ActionQueue(), Proposal(id="hello", kind="greeting", text="Hello.", priority=30))
    queue.add(proposal("to B", 40, "interrupt", seat="B"))
    assert queue.next(0) in queue.waiting


class QueueMachine(RuleBasedStateMachine):
    """Uses the queue as the arbiter does, and checks its invariants."""

    def __init__(self) -> None:
        super().__init__()
        self.queue = ActionQueue()
        self.now = 0
        self.count = 0
        self.waiting: dict[str, Proposal] = {}
        self.open: set[tuple[str, ActionPart]] = set()
        self.current: Proposal | None = None

    @rule(
        priority=st.integers(0, 3),
        policy=st.sampled_from(POLICIES),
        delay=st.one_of(st.just(0), st.integers(0, 50)),
    )
    def propose(self, priority: int, policy: Policy, delay: int) -> None:
        self.count += 1
        new = proposal(f"a{self.count}", priority, policy, self.now + delay)
        self.waiting[new.id] = new
        self.queue.add(new)

    @rule(passed=st.integers(1, 60))
    def wait(self, passed: int) -> None:
        self.now += passed

    @rule(parts=st.sets(st.sampled_from(sorted(OPEN))))
    def take_a_turn(self, parts: set[tuple[str, ActionPart]]) -> None:
        chosen = self.queue.next(self.now)
        ready = [waiting for waiting in self.waiting.values() if waiting.due <= self.now]
        if chosen is None:
            assert self.current is not None or not ready, "nothing waits that could begin"
            return
        assert chosen is max(ready, key=lambda waiting: waiting.priority), "the oldest of them"
        if self.current is not None:
            assert chosen.policy == "interrupt"
            assert chosen.priority >= self.current.priority
        self.queue.begin(chosen, parts)
        del self.waiting[chosen.id]
        self.open = set(parts)
        self.current = chosen if parts else None

    @precondition(lambda self: self.current is not None)
    @rule(part=st.sampled_from(sorted(OPEN)), mine=st.booleans())
    def report(self, part: tuple[str, ActionPart], mine: bool) -> None:
        assert self.current is not None
        over = self.queue.finish_part(self.current.id if mine else "another", *part)
        if mine:
            self.open.discard(part)
        assert over == (mine and not self.open)
        if over:
            self.current = None

    @rule()
    def abandon(self) -> None:
        self.queue.abandon()
        self.current = None
        self.open.clear()

    @rule(only=st.sampled_from(["", *POLICIES]))
    def give_up(self, only: str) -> None:
        gone = {
            given_up.id for given_up in self.queue.remove(lambda each: only in ("", each.policy))
        }
        assert gone == {
            name for name, waiting in self.waiting.items() if only in ("", waiting.policy)
        }
        self.waiting = {name: waiting for name, waiting in self.waiting.items() if name not in gone}

    @invariant()
    def one_thing_at_most_is_under_way_and_nothing_is_lost(self) -> None:
        assert self.queue.current == self.current
        assert self.queue.is_acting == bool(self.open)
        by_priority = sorted(self.waiting.values(), key=lambda waiting: -waiting.priority)
        assert self.queue.waiting == tuple(by_priority)

    @invariant()
    def it_knows_when_to_look_again(self) -> None:
        later = [waiting.due for waiting in self.waiting.values() if waiting.due > self.now]
        assert self.queue.next_due(self.now) == (min(later) if later else None)


TestQueue = QueueMachine.TestCase


# --- actions as an operator edited them

LOOKS: Any = {"face": "happy", "gesture": "nod", "tone": "success", "degree": "strong"}
SAID: Any = {"text": "Well done.", "spoken": "Well done.", "valence": "positive"}
PRAISE = Proposal(id="a1", kind="feedback", **SAID, **LOOKS)


def edit(theme: Theme, proposal: Proposal = PRAISE, **changes: Any) -> Action:
    decision = Decision(action="a1", verdict="edit", actor="operator.ana", **changes)
    return edited(accepted(proposal), decision, theme, at=7)


def pending(name: str, deadline: int | None) -> PendingApproval:
    return PendingApproval(
        proposal=Proposal(id=name, kind="feedback", text=name), mode="veto", deadline=deadline
    )


def test_an_edited_valence_replaces_face_gesture_tone_and_degree(calm: Theme) -> None:
    action = edit(calm, valence="negative")
    assert facts(action, "face gesture tone degree") == ("encouraging", "lean_in", "", "clear")
    expected = ("Well done.", "edited", "operator.ana", 7)
    assert facts(action, "text decision actor decided") == expected


def test_an_edited_valence_adds_no_gesture_to_a_proposal_without_one(calm: Theme) -> None:
    still = Proposal(id="a1", kind="feedback", text="Well done.", valence="positive")
    assert edit(calm, still, valence="negative").gesture == ""


def test_edited_text_is_spoken_as_the_theme_does(calm: Theme) -> None:
    action = edit(calm, text="412 ms.")
    assert (action.text, action.spoken) == ("412 ms.", "412 milliseconds.")
    assert (action.face, action.degree) == ("happy", "strong")


def test_an_edited_gesture_overrides_that_of_the_valence(calm: Theme) -> None:
    assert edit(calm, valence="negative", gesture="wave").gesture == "wave"
    assert edit(calm, gesture="").gesture == ""


@pytest.mark.parametrize(
    "same", [{"text": "Well done."}, {"valence": "positive"}, {"gesture": "nod"}]
)
def test_an_edit_with_the_same_values_is_an_acceptance(calm: Theme, same: dict[str, str]) -> None:
    action = edit(calm, **same)
    assert (action.decision, action.degree, action.actor) == ("accepted", "strong", "operator.ana")


def test_proposals_are_due_by_deadline_and_those_without_one_stay() -> None:
    approvals = PendingApprovals()
    for name, deadline in (("late", 3 * SECOND), ("soon", SECOND), ("never", None)):
        approvals.add(pending(name, deadline))
    assert approvals.next_deadline == SECOND
    assert [due.proposal.id for due in approvals.take_due(SECOND)] == ["soon"]
    assert [due.proposal.id for due in approvals.take_due(10 * SECOND)] == ["late"]
    assert approvals.next_deadline is None
    assert [waiting.proposal.id for waiting in approvals.waiting] == ["never"]
