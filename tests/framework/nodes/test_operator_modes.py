"""Given an operator, when the agent proposes, then what is said is what they decided, and all of it is told."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework import messages as m
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    ARBITER_STATE,
    DECIDED,
    DECISION,
    DROPPED,
    FILLER_DUE,
    LEVEL_DECIDED,
    LEVEL_REQUEST,
    MISSED,
    MODE,
    OPERATOR,
    PENDING_APPROVAL,
    PRESENCE,
    REMARK,
    TIMER,
    UNSAID_FEEDBACK,
)
from tests.framework.nodes.test_arbiter import TOLD, Floor, Told


class Room(Floor):
    """A floor with an operator in the next room."""

    def __init__(self, *, operated: bool = True, **settings: object) -> None:
        super().__init__({"speech": ("say",)}, **settings)
        if operated:
            self.operator("joined", operated=True)

    def operator(self, state: Any, *, operated: bool) -> None:
        self.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state=state, operated=operated))

    def decide(self, action: str, verdict: Any, **how: Any) -> None:
        told = m.Decision(action=action, verdict=verdict, actor="operator.ana", at=self.clock.now(), **how)
        self.bus.publish(DECISION, told)

    def ask_for_level(self, previous: int, level: int, *, is_last: bool = False) -> bool:
        change = m.LevelChanged(previous=previous, level=level, reason="success")
        happens: list[bool] = []
        self.bus.subscribe(
            OPERATOR,
            lambda _: happens.append(
                self.bus.call(LEVEL_REQUEST, m.LevelRequest(change=change, is_last=is_last)).happens
            ),
        )
        self.bus.publish(OPERATOR, m.Operator(command="mark"))
        return happens[0]

    def ask_unsaid(self, attempt: int) -> tuple[str, ...]:
        return self.bus.call(UNSAID_FEEDBACK, m.UnsaidFeedbackRequest(attempt=attempt)).seats

    @property
    def said(self) -> list[m.Action]:
        return self.all(ACTION)

    @property
    def standing(self) -> m.ArbiterState:
        told: m.ArbiterState = self.all(ARBITER_STATE)[-1]
        return told

    @property
    def awaits_operator(self) -> bool:
        told = self.all(ACTING)
        return bool(told and told[-1].awaits_operator)


# --- the four modes -----------------------------------------------------------------------------------------------


def test_autonomous_feedback_is_given_at_once_though_an_operator_watches() -> None:
    room = Room()
    room.propose("a1")
    (said,) = room.said
    assert (said.decision, said.actor, said.mode, said.ground) == ("accepted", "agent", "autonomous", "mode")
    assert room.all(PENDING_APPROVAL) == []


def test_under_veto_silence_lets_it_pass_after_the_operators_time() -> None:
    room = Room(operator_feedback="veto", operator_time_ms=3000)
    room.propose("a1")
    room.clock.advance(3 * SECOND - 1)
    assert room.said == []
    room.clock.advance(1)
    (said,) = room.said
    assert (said.actor, said.ground, said.mode) == ("agent", "deadline", "veto")


def test_what_is_vetoed_is_not_said() -> None:
    room = Room(operator_feedback="veto")
    room.propose("a1")
    room.decide("a1", "veto")
    room.clock.advance(60 * SECOND)
    assert room.said == []
    (dropped,) = room.all(DROPPED)
    assert (dropped.id, dropped.reason, dropped.actor) == ("a1", "vetoed", "operator.ana")


def test_under_veto_silence_lets_it_pass_whatever_silence_means_under_approve() -> None:
    room = Room(operator_feedback="veto", operator_timeout="drop")
    room.propose("a1")
    room.clock.advance(60 * SECOND)
    assert room.acted == ["a1"]


@pytest.mark.parametrize(("afterwards", "said"), [("act", 1), ("drop", 0)])
def test_under_approve_silence_is_what_the_session_is_set_to(afterwards: str, said: int) -> None:
    room = Room(operator_feedback="approve", operator_timeout=afterwards)
    room.propose("a1")
    room.clock.advance(60 * SECOND)
    assert len(room.said) == said
    assert [dropped.reason for dropped in room.all(DROPPED)] == ["expired"] * (1 - said)


def test_what_is_approved_is_said_at_once_as_it_was_proposed() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1")
    room.clock.advance(700 * MS)
    room.decide("a1", "accept")
    (said,) = room.said
    assert (said.text, said.decision, said.actor, said.ground) == ("a1", "accepted", "operator.ana", "operator")
    assert said.decided == SECOND + 700 * MS
    assert room.all(DECIDED) == [said]


def test_under_manual_nothing_is_said_until_the_operator_takes_it_up() -> None:
    room = Room(operator_feedback="manual")
    room.propose("a1", "a2")
    room.clock.advance(600 * SECOND)
    assert room.said == []
    room.decide("a2", "accept")
    assert room.acted == ["a2"]
    assert not room.awaits_operator


def test_what_is_edited_is_said_in_the_operators_words_and_in_the_manner_of_their_valence() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1", valence="negative", gesture="lean_in", face="encouraging", degree="strong")
    room.decide("a1", "edit", text="Good, 850 ms.", valence="positive")
    (said,) = room.said
    assert (said.text, said.spoken, said.valence, said.decision) == (
        "Good, 850 ms.",
        "Good, 850 ms.",
        "positive",
        "edited",
    )
    assert (said.face, said.gesture, said.tone) == ("happy", "nod", "success")


def test_an_edit_that_changes_nothing_is_an_approval() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1", valence="neutral")
    room.decide("a1", "edit", text="a1", valence="neutral")
    assert [said.decision for said in room.said] == ["accepted"]


@pytest.mark.parametrize("kind", ["greeting", "instruction", "encouragement", "rest", "goodbye"])
def test_each_kind_goes_by_the_mode_of_its_own(kind: str) -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1", kind=kind)
    assert room.acted == ["a1"]
    ruled = {"encouragement": "encouragement", "rest": "encouragement"}.get(kind, "instruction")
    strict = Room(**{f"operator_{ruled}": "approve"})
    strict.propose("a1", kind=kind)
    assert strict.acted == []


# --- time ---------------------------------------------------------------------------------------------------------


def test_after_a_fixed_delay_an_operator_has_until_then_and_no_longer() -> None:
    room = Room(operator_feedback="approve", operator_time_ms=10_000)
    due = room.clock.now() + 3 * SECOND
    room.propose("a1", due=due, seat="B")
    (offer,) = room.standing.pending
    assert (offer.deadline, offer.seat) == (due, "B")
    room.clock.advance(3 * SECOND)
    assert room.acted == ["a1"]


@pytest.mark.parametrize("mode", ["autonomous", "veto", "approve"])
@given(decided_ms=st.integers(0, 2999))
def test_after_a_fixed_delay_its_moment_does_not_tell_who_decided(mode: str, decided_ms: int) -> None:
    room = Room(operator_feedback=mode, operator_time_ms=500)
    due = room.clock.now() + 3 * SECOND
    room.propose("a1", due=due)
    room.clock.advance(decided_ms * MS)
    room.decide("a1", "accept")
    room.clock.advance(10 * SECOND)
    ((at, _),) = [(record.at, record.message) for record in room.records if record.topic is ACTION]
    assert at == due


def test_the_session_waits_while_an_answer_is_owed_and_no_longer() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1")
    assert room.awaits_operator
    room.decide("a1", "veto")
    assert not room.awaits_operator


def test_the_session_waits_for_no_kind_word() -> None:
    room = Room(operator_encouragement="approve")
    room.propose("a1", kind="encouragement")
    assert [offer.proposal.id for offer in room.standing.pending] == ["a1"]
    assert not room.awaits_operator


def test_whose_answers_are_still_to_be_said_can_be_asked() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1", seat="B", attempt=3)
    room.propose("a2", seat="A", attempt=2)
    room.propose("a3", seat="A", attempt=3, kind="rest")
    assert room.ask_unsaid(3) == ("B",)
    room.wait_for("response")
    room.decide("a1", "accept")
    assert room.ask_unsaid(3) == ("B",), "it waits for its turn"
    room.wait_for("enter", "attempt")
    assert room.acted[-1] == "a1"
    assert room.ask_unsaid(3) == ()


def test_a_kind_word_is_not_said_before_the_answer_that_is_owed() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1", priority=40)
    room.propose("a2", kind="encouragement", policy="drop", priority=20)
    assert room.acted == []
    room.decide("a1", "accept")
    room.report("a1")
    assert room.acted == ["a1", "a2"]


def test_an_answer_after_the_deadline_comes_to_nothing_and_is_told() -> None:
    room = Room(operator_feedback="veto", operator_time_ms=500)
    room.propose("a1")
    room.clock.advance(SECOND)
    room.report("a1")
    room.decide("a1", "veto")
    assert room.acted == ["a1"]
    (missed,) = room.all(MISSED)
    assert (missed.actor, missed.what) == ("operator.ana", "veto a1")


def test_what_is_under_way_can_be_cut_off() -> None:
    room = Room()
    room.propose("a1")
    room.decide("a1", "veto")
    assert room.halted == [("a1", "vetoed")]


def test_what_is_under_way_cannot_be_changed_and_nothing_else_is_cut_off_in_its_place() -> None:
    room = Room()
    room.propose("a1")
    room.decide("a1", "edit", text="Else.")
    room.decide("a7", "veto")
    assert room.halted == []
    assert [missed.what for missed in room.all(MISSED)] == ["edit a1", "veto a7"]


def test_what_is_edited_is_told_when_it_is_decided_and_when_its_turn_comes() -> None:
    room = Room(operator_feedback="approve")
    room.wait_for("foreperiod")
    room.propose("a1")
    room.decide("a1", "edit", text="Else.")
    room.decide("a1", "edit", text="Other.")
    assert room.said == []
    assert [(told.text, told.decision) for told in room.all(DECIDED)] == [("Else.", "edited"), ("Other.", "edited")]


def test_a_filler_that_has_not_begun_is_left_out_once_it_is_decided() -> None:
    room = Room(operator_feedback="approve")
    room.wait_for("foreperiod")
    room.propose("a1")
    room.propose("a2", kind="filler")
    room.decide("a1", "accept")
    assert room.dropped == [("a2", "late")]
    room.wait_for("enter", "attempt")
    assert room.acted == ["a1"]


def test_once_nothing_waits_for_an_operator_no_deadline_comes() -> None:
    room = Room(operator_feedback="approve", filler="never")
    room.propose("a1")
    room.decide("a1", "accept")
    room.report("a1")
    room.clock.advance(60 * SECOND)
    assert room.all(TIMER) == []


def test_what_waits_for_its_turn_can_be_left_out_or_changed() -> None:
    room = Room()
    room.wait_for("foreperiod")
    room.propose("a1", "a2")
    room.decide("a1", "veto")
    room.decide("a2", "edit", text="Else.")
    room.wait_for("enter", "attempt")
    assert [said.text for said in room.said] == ["Else."]


def test_a_filler_covers_a_wait_of_more_than_a_second_once() -> None:
    room = Room(operator_feedback="approve", operator_time_ms=8000)
    room.propose("a1")
    room.clock.advance(SECOND - 1)
    assert room.all(FILLER_DUE) == []
    room.clock.advance(5 * SECOND)
    assert room.all(FILLER_DUE) == [m.FillerDue(id="a1")]


@pytest.mark.parametrize(("decided", "covered"), [("a1", "a2"), ("a2", "a1")])
def test_a_filler_covers_the_wait_of_either_of_two(decided: str, covered: str) -> None:
    room = Room(operator_feedback="approve", operator_time_ms=8000)
    room.propose("a1", seat="A")
    room.propose("a2", seat="B")
    room.decide(decided, "veto")
    room.clock.advance(4 * SECOND)
    assert room.all(FILLER_DUE) == [m.FillerDue(id=covered)]


def test_no_filler_covers_what_is_not_waited_for_or_comes_within_a_second() -> None:
    manual = Room(operator_feedback="manual")
    manual.propose("a1")
    soon = Room(filler="always")
    soon.propose("a1", due=soon.clock.now() + SECOND)
    for room in (manual, soon):
        room.clock.advance(10 * SECOND)
        assert room.all(FILLER_DUE) == []


def test_no_filler_covers_what_is_no_answer() -> None:
    room = Room(operator_encouragement="approve", operator_time_ms=5000)
    room.propose("a1", kind="encouragement")
    room.clock.advance(4 * SECOND)
    assert room.all(FILLER_DUE) == []


def test_no_filler_covers_what_was_decided_in_time() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1")
    room.decide("a1", "accept")
    room.clock.advance(20 * SECOND)
    assert room.all(FILLER_DUE) == []


@pytest.mark.parametrize(("filler", "covered"), [("operator", 0), ("always", 1), ("never", 0)])
@pytest.mark.parametrize("operated", [True, False])
def test_a_delay_is_covered_with_and_without_an_operator_or_not_at_all(
    filler: str, covered: int, operated: bool
) -> None:
    room = Room(operated=operated, filler=filler)
    room.propose("a1", due=room.clock.now() + 4 * SECOND)
    room.clock.advance(10 * SECOND)
    assert len(room.all(FILLER_DUE)) == covered


@pytest.mark.parametrize(("status", "said"), [("completed", ["a1", "a2"]), ("aborted", ["a1"])])
def test_the_last_answers_have_their_turn_before_the_goodbye_unless_somebody_ended_it(
    status: Any, said: list[str]
) -> None:
    """Two people are answered one after the other; who goes on to the summary meanwhile does not cut the second off."""
    room = Room()
    room.propose("a1", "a2")
    room.bus.publish(TOLD, Told(ended=m.SessionEnded(status=status)))
    room.report("a1")
    assert room.acted == said


# --- without an operator ------------------------------------------------------------------------------------------


def test_without_an_operator_the_agent_goes_on_by_itself() -> None:
    room = Room(operated=False, operator_feedback="approve")
    room.propose("a1")
    assert [(said.ground, said.actor) for said in room.said] == [("no operator", "agent")]


def test_without_an_operator_a_session_may_be_silent_instead() -> None:
    room = Room(operated=False, operator_feedback="approve", operator_lost="silent")
    room.propose("a1")
    assert room.dropped == [("a1", "no operator")]


@pytest.mark.parametrize("mode", ["veto", "approve", "manual"])
@pytest.mark.parametrize(("lost", "acted"), [("autonomous", ["a1"]), ("silent", [])])
def test_when_the_operator_is_lost_what_waited_is_decided_at_once(mode: str, lost: str, acted: list[str]) -> None:
    room = Room(operator_feedback=mode, operator_lost=lost, operator_time_ms=60_000)
    room.propose("a1")
    room.operator("lost", operated=False)
    assert room.acted == acted
    assert not room.awaits_operator
    room.operator("joined", operated=True)
    room.report("a1")
    room.propose("a2")
    assert room.acted == acted
    assert room.standing.pending[-1].proposal.id == "a2"


# --- switched live, and told ----------------------------------------------------------------------------------------


def test_a_mode_that_is_switched_rules_what_waits_already() -> None:
    room = Room(operator_feedback="manual")
    room.propose("a1")
    room.bus.publish(MODE, m.ModeChanged(kind="feedback", mode="veto"))
    room.clock.advance(10 * SECOND)
    assert room.acted == ["a1"]


def test_a_mode_that_is_switched_leaves_what_is_of_another_kind() -> None:
    room = Room(operator_feedback="manual")
    room.propose("a1")
    room.bus.publish(MODE, m.ModeChanged(kind="encouragement", mode="veto"))
    assert [offer.proposal.id for offer in room.all(PENDING_APPROVAL)] == ["a1"]


def test_a_mode_that_is_switched_to_autonomous_lets_what_waits_go() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1")
    room.bus.publish(MODE, m.ModeChanged(kind="feedback", mode="autonomous", actor="operator.ana"))
    assert [said.actor for said in room.said] == ["operator.ana"]


def test_operators_are_told_how_everything_stands() -> None:
    room = Room(operator_feedback="approve")
    room.propose("a1")
    standing = room.standing
    assert standing.operated
    assert standing.modes["feedback"] == "approve"
    (offer,) = standing.pending
    assert (offer.proposal.id, offer.mode, offer.otherwise) == ("a1", "approve", "act")
    room.decide("a1", "accept")
    assert room.standing.pending == ()
    assert room.standing.current is not None
    assert room.standing.current.id == "a1"


def test_operators_are_told_once_as_long_as_nothing_is_another() -> None:
    room = Room(operator_feedback="manual")
    room.propose("a1")
    told = len(room.all(ARBITER_STATE))
    for _ in range(3):
        room.wait_for("enter", "attempt")
    assert len(room.all(ARBITER_STATE)) == told


def test_nobody_is_told_where_there_is_no_operator() -> None:
    room = Room(operated=False)
    room.propose("a1")
    assert room.all(ARBITER_STATE) == []


# --- an operator's own ------------------------------------------------------------------------------------------------


def test_an_operators_words_go_first_and_not_in_a_trial() -> None:
    room = Room()
    room.wait_for("response")
    room.propose("a1")
    room.bus.publish(REMARK, m.Remark(text="You are doing fine.", actor="operator.ana"))
    assert room.said == []
    room.wait_for("enter", "attempt")
    assert room.acted == ["o1"]
    (said, *_) = room.said
    assert (said.kind, said.decision, said.actor, said.spoken) == (
        "remark",
        "initiated",
        "operator.ana",
        "You are doing fine.",
    )


@pytest.mark.parametrize(
    ("how", "face", "gesture"),
    [
        ({}, "speaking", ""),
        ({"valence": "positive"}, "happy", "nod"),
        ({"valence": "positive", "gesture": "wave", "face": "surprised"}, "surprised", "wave"),
    ],
)
def test_an_operators_words_have_the_manner_of_their_valence_unless_another_is_named(
    how: dict[str, Any], face: str, gesture: str
) -> None:
    room = Room()
    room.bus.publish(REMARK, m.Remark(text="You are doing fine.", actor="operator.ana", **how))
    (said,) = room.said
    assert (said.face, said.gesture, said.tone) == (face, gesture, "success" if how else "")


def test_at_the_end_answers_have_their_turn_and_an_operators_words_do_not() -> None:
    room = Room()
    room.propose("a1")
    room.bus.publish(REMARK, m.Remark(text="Bye.", actor="operator.ana"))
    room.propose("a2", policy="queue")
    room.bus.publish(TOLD, Told(ended=m.SessionEnded(status="completed")))
    assert room.dropped == [("o1", "late")]


def test_the_participants_own_stop_key_is_nobodys_act() -> None:
    room = Room(operator_feedback="manual")
    room.propose("a1")
    room.stop()
    assert [(dropped.reason, dropped.actor) for dropped in room.all(DROPPED)] == [("stopped", "agent")]


def test_a_gesture_that_waits_alone_is_dropped_when_a_trial_comes_first() -> None:
    room = Room(operator_gesture="approve", operator_time_ms=60_000)
    room.propose("a1", gesture="nod")
    room.wait_for("quiet")
    assert room.dropped == [("a1.gesture", "late")]


def test_a_gesture_that_is_ruled_on_apart_waits_alone() -> None:
    room = Room(operator_gesture="approve")
    room.propose("a1", gesture="nod")
    assert [(said.id, said.gesture) for said in room.said] == [("a1", "")]
    (offer,) = room.all(PENDING_APPROVAL)
    assert (offer.proposal.id, offer.proposal.kind, offer.proposal.text) == ("a1.gesture", "gesture", "")
    room.report("a1")
    room.decide("a1.gesture", "accept")
    assert [said.gesture for said in room.said][-1] == "nod"


@pytest.mark.parametrize(("lost", "gesture"), [("silent", ""), ("autonomous", "nod")])
def test_without_an_operator_a_gesture_that_is_theirs_is_left_out_or_made_with_its_words(
    lost: str, gesture: str
) -> None:
    room = Room(operated=False, operator_gesture="approve", operator_lost=lost)
    room.propose("a1", gesture="nod")
    assert [(said.id, said.gesture) for said in room.said] == [("a1", gesture)]
    assert room.all(PENDING_APPROVAL) == room.all(DROPPED) == []


def test_what_covers_a_wait_keeps_its_gesture_whoever_rules_on_gestures() -> None:
    room = Room(operator_gesture="approve")
    room.propose("a1", kind="filler", gesture="nod")
    assert [said.gesture for said in room.said] == ["nod"]
    assert room.all(PENDING_APPROVAL) == []


# --- the level -------------------------------------------------------------------------------------------------------


def test_a_change_of_level_happens_where_the_agent_decides() -> None:
    assert Room().ask_for_level(2, 3)


@pytest.mark.parametrize(("mode", "happens"), [("autonomous", True), ("veto", False), ("manual", False)])
def test_after_the_last_attempt_nobody_is_asked_and_what_an_operator_holds_stays(mode: str, happens: bool) -> None:
    room = Room(operator_difficulty=mode)
    assert room.ask_for_level(2, 3, is_last=True) is happens
    assert room.all(PENDING_APPROVAL) == []


def test_a_change_of_level_waits_for_an_operator() -> None:
    room = Room(operator_difficulty="approve")
    assert not room.ask_for_level(2, 3)
    assert room.awaits_operator
    room.decide("l1", "accept")
    (ruled,) = room.all(LEVEL_DECIDED)
    assert (ruled.level, ruled.decision, ruled.actor) == (3, "accepted", "operator.ana")


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ({"verdict": "veto"}, "rejected"),
        ({"verdict": "edit", "level": 5}, "edited"),
        ({"verdict": "edit", "level": 3}, "accepted"),
    ],
)
def test_an_operator_rules_on_the_level(how: dict[str, Any], expected: str) -> None:
    room = Room(operator_difficulty="veto")
    room.ask_for_level(2, 3)
    room.decide("l1", **how)
    assert [ruled.decision for ruled in room.all(LEVEL_DECIDED)] == [expected]


def test_a_level_set_by_hand_settles_what_was_asked() -> None:
    room = Room(operator_difficulty="veto")
    room.ask_for_level(2, 3)
    room.bus.publish(OPERATOR, m.Operator(command="level", value=1, actor="operator.ana"))
    room.clock.advance(60 * SECOND)
    assert [ruled.decision for ruled in room.all(LEVEL_DECIDED)] == ["rejected"]
