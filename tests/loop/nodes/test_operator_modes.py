"""The operator's modes: autonomous, veto, approve, manual."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from tests.facts import each, facts
from tests.loop.nodes.test_arbiter import EVENT, ArbiterDriver, Event


class OperatedDriver(ArbiterDriver):
    """Drives an arbiter with an operator."""

    def __init__(self, *, operated: bool = True, **settings: object) -> None:
        super().__init__({"speech": ("say",)}, **settings)
        if operated:
            self.operator("joined", operated=True)

    def operator(self, state: Any, *, operated: bool) -> None:
        self.bus.publish(
            t.PRESENCE, m.OperatorChanged(actor="operator.ana", state=state, operated=operated)
        )

    def decide(self, action: str, verdict: Any, **how: Any) -> None:
        decision = m.Decision(
            action=action, verdict=verdict, actor="operator.ana", at=self.clock.now(), **how
        )
        self.bus.publish(t.DECISION, decision)

    def ask_for_level(self, previous: int, level: int, *, is_last: bool = False) -> bool:
        change = m.LevelChanged(previous=previous, level=level, reason="success")
        happens: list[bool] = []
        self.bus.subscribe(
            t.COMMAND,
            lambda _: happens.append(
                self.bus.call(
                    t.LEVEL_REQUEST, m.LevelRequest(change=change, is_last=is_last)
                ).happens
            ),
        )
        self.bus.publish(t.COMMAND, m.SessionCommand(command="mark"))
        return happens[0]

    def ask_unsaid(self, attempt: int) -> tuple[str, ...]:
        return self.bus.call(t.UNSAID_FEEDBACK, m.UnsaidFeedbackRequest(attempt=attempt)).seats

    @property
    def said(self) -> list[m.Action]:
        return self.all(t.ACTION)

    @property
    def state(self) -> m.ArbiterState:
        found: m.ArbiterState = self.all(t.ARBITER_STATE)[-1]
        return found

    @property
    def awaits_operator(self) -> bool:
        found = self.all(t.ACTING)
        return bool(found and found[-1].awaits_operator)


# --- the four modes


def test_autonomous_feedback_is_given_at_once() -> None:
    driver = OperatedDriver()
    driver.propose("a1")
    (said,) = driver.said
    assert facts(said, "decision actor mode ground") == ("accepted", "agent", "autonomous", "mode")
    assert driver.all(t.PENDING_APPROVAL) == []


def test_in_veto_mode_a_proposal_is_made_at_the_deadline() -> None:
    driver = OperatedDriver(operator_feedback="veto", operator_time_ms=3000)
    driver.propose("a1")
    driver.clock.advance(3 * SECOND - 1)
    assert driver.said == []
    driver.clock.advance(1)
    (said,) = driver.said
    assert (said.actor, said.ground, said.mode) == ("agent", "deadline", "veto")


def test_a_vetoed_proposal_is_not_made() -> None:
    driver = OperatedDriver(operator_feedback="veto")
    driver.propose("a1")
    driver.decide("a1", "veto")
    driver.clock.advance(60 * SECOND)
    assert driver.said == []
    (dropped,) = driver.all(t.DROPPED)
    assert (dropped.id, dropped.reason, dropped.actor) == ("a1", "vetoed", "operator.ana")


def test_the_timeout_setting_does_not_apply_in_veto_mode() -> None:
    driver = OperatedDriver(operator_feedback="veto", operator_timeout="drop")
    driver.propose("a1")
    driver.clock.advance(60 * SECOND)
    assert driver.acted == ["a1"]


@pytest.mark.parametrize(("afterwards", "said"), [("act", 1), ("drop", 0)])
def test_in_approve_mode_the_timeout_setting_applies_at_the_deadline(
    afterwards: str, said: int
) -> None:
    driver = OperatedDriver(operator_feedback="approve", operator_timeout=afterwards)
    driver.propose("a1")
    driver.clock.advance(60 * SECOND)
    assert len(driver.said) == said
    assert [dropped.reason for dropped in driver.all(t.DROPPED)] == ["expired"] * (1 - said)


def test_an_accepted_proposal_is_made_at_once_unchanged() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1")
    driver.clock.advance(700 * MS)
    driver.decide("a1", "accept")
    (said,) = driver.said
    assert facts(said, "text decision actor ground") == (
        "a1",
        "accepted",
        "operator.ana",
        "operator",
    )
    assert said.decided == SECOND + 700 * MS
    assert driver.all(t.DECIDED) == [said]


def test_in_manual_mode_a_proposal_waits_for_the_operator() -> None:
    driver = OperatedDriver(operator_feedback="manual")
    driver.propose("a1", "a2")
    driver.clock.advance(600 * SECOND)
    assert driver.said == []
    driver.decide("a2", "accept")
    assert driver.acted == ["a2"]
    assert not driver.awaits_operator


def test_an_edited_proposal_has_the_operators_text_and_valence() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", valence="negative", gesture="lean_in", face="encouraging", degree="strong")
    driver.decide("a1", "edit", text="Good, 850 ms.", valence="positive")
    (said,) = driver.said
    assert facts(said, "text spoken valence decision") == (
        "Good, 850 ms.",
        "Good, 850 ms.",
        "positive",
        "edited",
    )
    assert (said.face, said.gesture, said.tone) == ("happy", "nod", "success")


def test_an_edit_that_changes_nothing_is_an_acceptance() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", valence="neutral")
    driver.decide("a1", "edit", text="a1", valence="neutral")
    assert [said.decision for said in driver.said] == ["accepted"]


@pytest.mark.parametrize("kind", ["greeting", "instruction", "encouragement", "rest", "goodbye"])
def test_each_kind_has_its_own_mode(kind: str) -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", kind=kind)
    assert driver.acted == ["a1"]
    controlled = {"encouragement": "encouragement", "rest": "encouragement"}.get(
        kind, "instruction"
    )
    strict = OperatedDriver(**{f"operator_{controlled}": "approve"})
    strict.propose("a1", kind=kind)
    assert strict.acted == []


# --- time


def test_with_delayed_feedback_the_deadline_is_the_delay() -> None:
    driver = OperatedDriver(operator_feedback="approve", operator_time_ms=10_000)
    due = driver.clock.now() + 3 * SECOND
    driver.propose("a1", due=due, seat="B")
    (pending,) = driver.state.pending
    assert (pending.deadline, pending.seat) == (due, "B")
    driver.clock.advance(3 * SECOND)
    assert driver.acted == ["a1"]


@pytest.mark.parametrize("mode", ["autonomous", "veto", "approve"])
@given(decided_ms=st.integers(0, 2999))
def test_with_delayed_feedback_the_timing_does_not_reveal_who_decided(
    mode: str, decided_ms: int
) -> None:
    driver = OperatedDriver(operator_feedback=mode, operator_time_ms=500)
    due = driver.clock.now() + 3 * SECOND
    driver.propose("a1", due=due)
    driver.clock.advance(decided_ms * MS)
    driver.decide("a1", "accept")
    driver.clock.advance(10 * SECOND)
    ((at, _),) = [
        (record.at, record.message) for record in driver.records if record.topic is t.ACTION
    ]
    assert at == due


def test_the_session_waits_only_while_feedback_is_pending() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1")
    assert driver.awaits_operator
    driver.decide("a1", "veto")
    assert not driver.awaits_operator


@pytest.mark.parametrize("kind", ["encouragement", "rest", "greeting"])
def test_the_session_waits_for_whatever_has_a_deadline(kind: Any) -> None:
    driver = OperatedDriver(operator_encouragement="approve", operator_instruction="veto")
    driver.propose("a1", kind=kind)
    assert driver.awaits_operator
    driver.decide("a1", "accept")
    assert (driver.acted, driver.awaits_operator) == (["a1"], False)


def test_the_session_does_not_wait_for_what_only_the_operator_does() -> None:
    driver = OperatedDriver(operator_encouragement="manual")
    driver.propose("a1", kind="encouragement")
    assert [pending.proposal.id for pending in driver.state.pending] == ["a1"]
    assert not driver.awaits_operator


@pytest.mark.parametrize(
    ("mode", "timeout", "said"),
    [("veto", "drop", 1), ("approve", "act", 1), ("approve", "drop", 0)],
)
def test_pending_feedback_is_decided_when_the_session_is_completed(
    mode: str, timeout: str, said: int
) -> None:
    driver = OperatedDriver(operator_feedback=mode, operator_timeout=timeout)
    driver.propose("a1", priority=40, due=driver.clock.now() + 3 * SECOND)
    driver.bus.publish(EVENT, Event(ended=m.SessionEnded(status="completed")))
    driver.propose("bye", kind="goodbye", priority=10)
    driver.report("a1")
    assert driver.acted == ["a1"] * said + ["bye"]


def test_accepting_what_was_decided_already_is_too_late() -> None:
    driver = OperatedDriver(operator_feedback="veto", operator_time_ms=500, operator_ms_per_word=0)
    driver.wait_for("response")
    driver.propose("a1")
    driver.clock.advance(SECOND)
    driver.decide("a1", "accept")
    assert [late.what for late in driver.all(t.LATE_DECISION)] == ["accept a1"]
    driver.wait_for("enter", "attempt")
    assert [said.actor for said in driver.said] == ["agent"]


# --- the time to decide

MEDIAN = (
    "Well done: you took 498 ms on average, which is 22 ms faster than in the last attempt. Keep!"
)
"""As long as the median proposal: 19 words."""


def seconds_to_decide(driver: OperatedDriver, id: str) -> float:
    (pending,) = [one for one in driver.state.pending if one.proposal.id == id]
    assert pending.deadline
    return (pending.deadline - driver.clock.now()) / SECOND


@pytest.mark.parametrize(
    ("text", "seconds"), [("Nod", 4), (MEDIAN, 6.75), (f"{MEDIAN} {MEDIAN}", 11.5)]
)
def test_the_time_to_decide_follows_from_the_words(text: str, seconds: float) -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", text=text)
    assert seconds_to_decide(driver, "a1") == seconds


def test_proposals_are_read_one_after_the_other() -> None:
    driver = OperatedDriver(operator_feedback="approve", operator_encouragement="approve")
    driver.propose("a1", "a2", text=MEDIAN)
    assert (seconds_to_decide(driver, "a1"), seconds_to_decide(driver, "a2")) == (6.75, 13.5)


def test_text_that_is_only_spoken_is_read_too() -> None:
    driver = OperatedDriver(operator_instruction="approve")
    driver.propose("a1", kind="instruction", text="", spoken=MEDIAN)
    assert seconds_to_decide(driver, "a1") == 6.75


def test_every_proposal_can_have_the_same_time() -> None:
    driver = OperatedDriver(
        operator_feedback="approve", operator_time_ms=3000, operator_ms_per_word=0
    )
    driver.propose("a1", "a2", text=MEDIAN)
    assert seconds_to_decide(driver, "a2") == 3


# --- what waits for a decision


def test_unsaid_feedback_can_be_requested() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", seat="B", attempt=3)
    driver.propose("a2", seat="A", attempt=2)
    driver.propose("a3", seat="A", attempt=3, kind="rest")
    assert driver.ask_unsaid(3) == ("B",)
    driver.wait_for("response")
    driver.decide("a1", "accept")
    assert driver.ask_unsaid(3) == ("B",), "it is queued"
    driver.wait_for("enter", "attempt")
    assert driver.acted[-1] == "a1"
    assert driver.ask_unsaid(3) == ()


def test_encouragement_waits_for_pending_feedback() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1", priority=40)
    driver.propose("a2", kind="encouragement", policy="drop", priority=20)
    assert driver.acted == []
    driver.decide("a1", "accept")
    driver.report("a1")
    assert driver.acted == ["a1", "a2"]


def test_a_decision_after_the_deadline_is_reported_as_missed() -> None:
    driver = OperatedDriver(operator_feedback="veto", operator_time_ms=500, operator_ms_per_word=0)
    driver.propose("a1")
    driver.clock.advance(SECOND)
    driver.report("a1")
    driver.decide("a1", "veto")
    assert driver.acted == ["a1"]
    (missed,) = driver.all(t.LATE_DECISION)
    assert (missed.actor, missed.what) == ("operator.ana", "veto a1")


def test_a_veto_halts_the_current_action() -> None:
    driver = OperatedDriver()
    driver.propose("a1")
    driver.decide("a1", "veto")
    assert driver.halted == [("a1", "vetoed")]


def test_the_current_action_cannot_be_edited() -> None:
    driver = OperatedDriver()
    driver.propose("a1")
    driver.decide("a1", "edit", text="Else.")
    driver.decide("a7", "veto")
    assert driver.halted == []
    assert [missed.what for missed in driver.all(t.LATE_DECISION)] == ["edit a1", "veto a7"]


def test_an_edited_action_is_published_when_decided_and_when_begun() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.wait_for("foreperiod")
    driver.propose("a1")
    driver.decide("a1", "edit", text="Else.")
    driver.decide("a1", "edit", text="Other.")
    assert driver.said == []
    assert each(driver.all(t.DECIDED), "text decision") == [
        ("Else.", "edited"),
        ("Other.", "edited"),
    ]


def test_a_waiting_filler_is_dropped_by_the_decision() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.wait_for("foreperiod")
    driver.propose("a1")
    driver.propose("a2", kind="filler")
    driver.decide("a1", "accept")
    assert driver.dropped == [("a2", "late")]
    driver.wait_for("enter", "attempt")
    assert driver.acted == ["a1"]


def test_no_deadline_fires_once_nothing_is_pending() -> None:
    driver = OperatedDriver(operator_feedback="approve", filler="never")
    driver.propose("a1")
    driver.decide("a1", "accept")
    driver.report("a1")
    driver.clock.advance(60 * SECOND)
    assert driver.all(t.TIMER) == []


def test_a_queued_action_can_be_vetoed_or_edited() -> None:
    driver = OperatedDriver()
    driver.wait_for("foreperiod")
    driver.propose("a1", "a2")
    driver.decide("a1", "veto")
    driver.decide("a2", "edit", text="Else.")
    driver.wait_for("enter", "attempt")
    assert [said.text for said in driver.said] == ["Else."]


def test_a_filler_covers_a_wait_of_more_than_a_second_once() -> None:
    driver = OperatedDriver(operator_feedback="approve", operator_time_ms=8000)
    driver.propose("a1")
    driver.clock.advance(SECOND - 1)
    assert driver.all(t.FILLER_DUE) == []
    driver.clock.advance(5 * SECOND)
    assert driver.all(t.FILLER_DUE) == [m.FillerDue(id="a1")]


@pytest.mark.parametrize(("decided", "covered"), [("a1", "a2"), ("a2", "a1")])
def test_a_filler_covers_the_wait_of_either_seat(decided: str, covered: str) -> None:
    driver = OperatedDriver(operator_feedback="approve", operator_time_ms=8000)
    driver.propose("a1", seat="A")
    driver.propose("a2", seat="B")
    driver.decide(decided, "veto")
    driver.clock.advance(4 * SECOND)
    assert driver.all(t.FILLER_DUE) == [m.FillerDue(id=covered)]


def test_no_filler_for_manual_or_quick_feedback() -> None:
    manual = OperatedDriver(operator_feedback="manual")
    manual.propose("a1")
    soon = OperatedDriver(filler="always")
    soon.propose("a1", due=soon.clock.now() + SECOND)
    for driver in (manual, soon):
        driver.clock.advance(10 * SECOND)
        assert driver.all(t.FILLER_DUE) == []


def test_no_filler_for_other_kinds_than_feedback() -> None:
    driver = OperatedDriver(operator_encouragement="approve", operator_time_ms=5000)
    driver.propose("a1", kind="encouragement")
    driver.clock.advance(4 * SECOND)
    assert driver.all(t.FILLER_DUE) == []


def test_no_filler_after_a_decision_in_time() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1")
    driver.decide("a1", "accept")
    driver.clock.advance(20 * SECOND)
    assert driver.all(t.FILLER_DUE) == []


@pytest.mark.parametrize(("filler", "covered"), [("operator", 0), ("always", 1), ("never", 0)])
@pytest.mark.parametrize("operated", [True, False])
def test_a_delay_is_covered_as_the_filler_setting_says(
    filler: str, covered: int, operated: bool
) -> None:
    driver = OperatedDriver(operated=operated, filler=filler)
    driver.propose("a1", due=driver.clock.now() + 4 * SECOND)
    driver.clock.advance(10 * SECOND)
    assert len(driver.all(t.FILLER_DUE)) == covered


@pytest.mark.parametrize(("status", "said"), [("completed", ["a1", "a2"]), ("aborted", ["a1"])])
def test_the_last_feedback_precedes_the_goodbye_unless_the_session_was_aborted(
    status: Any, said: list[str]
) -> None:
    """Feedback for two seats comes in turn; ending the session meanwhile does not drop the
    second.
    """
    driver = OperatedDriver()
    driver.propose("a1", "a2")
    driver.bus.publish(EVENT, Event(ended=m.SessionEnded(status=status)))
    driver.report("a1")
    assert driver.acted == said


# --- without an operator


def test_without_an_operator_the_agent_acts_by_itself() -> None:
    driver = OperatedDriver(operated=False, operator_feedback="approve")
    driver.propose("a1")
    assert [(said.ground, said.actor) for said in driver.said] == [("no operator", "agent")]


def test_without_an_operator_a_session_may_be_silent_instead() -> None:
    driver = OperatedDriver(operated=False, operator_feedback="approve", operator_lost="silent")
    driver.propose("a1")
    assert driver.dropped == [("a1", "no operator")]


@pytest.mark.parametrize("mode", ["veto", "approve", "manual"])
@pytest.mark.parametrize(("lost", "acted"), [("autonomous", ["a1"]), ("silent", [])])
def test_when_the_operator_is_lost_pending_proposals_are_decided_at_once(
    mode: str, lost: str, acted: list[str]
) -> None:
    driver = OperatedDriver(operator_feedback=mode, operator_lost=lost, operator_time_ms=60_000)
    driver.propose("a1")
    driver.operator("lost", operated=False)
    assert driver.acted == acted
    assert not driver.awaits_operator
    driver.operator("joined", operated=True)
    driver.report("a1")
    driver.propose("a2")
    assert driver.acted == acted
    assert driver.state.pending[-1].proposal.id == "a2"


# --- changing modes, and the published state


def test_a_new_mode_applies_to_pending_proposals() -> None:
    driver = OperatedDriver(operator_feedback="manual")
    driver.propose("a1")
    driver.bus.publish(t.MODE, m.ModeChanged(kind="feedback", mode="veto"))
    driver.clock.advance(10 * SECOND)
    assert driver.acted == ["a1"]


def test_a_new_mode_leaves_other_kinds_pending() -> None:
    driver = OperatedDriver(operator_feedback="manual")
    driver.propose("a1")
    driver.bus.publish(t.MODE, m.ModeChanged(kind="encouragement", mode="veto"))
    assert [pending.proposal.id for pending in driver.all(t.PENDING_APPROVAL)] == ["a1"]


def test_switching_to_autonomous_makes_pending_proposals() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1")
    driver.bus.publish(
        t.MODE, m.ModeChanged(kind="feedback", mode="autonomous", actor="operator.ana")
    )
    assert [said.actor for said in driver.said] == ["operator.ana"]


def test_the_complete_state_is_published_for_operators() -> None:
    driver = OperatedDriver(operator_feedback="approve")
    driver.propose("a1")
    state = driver.state
    assert state.operated
    assert state.modes["feedback"] == "approve"
    (pending,) = state.pending
    assert (pending.proposal.id, pending.mode, pending.otherwise) == ("a1", "approve", "act")
    driver.decide("a1", "accept")
    assert driver.state.pending == ()
    assert driver.state.current is not None
    assert driver.state.current.id == "a1"


def test_the_state_is_published_only_when_it_changes() -> None:
    driver = OperatedDriver(operator_feedback="manual")
    driver.propose("a1")
    found = len(driver.all(t.ARBITER_STATE))
    for _ in range(3):
        driver.wait_for("enter", "attempt")
    assert len(driver.all(t.ARBITER_STATE)) == found


def test_without_an_operator_no_state_is_published() -> None:
    driver = OperatedDriver(operated=False)
    driver.propose("a1")
    assert driver.all(t.ARBITER_STATE) == []


# --- remarks of operators


def test_remarks_go_first_but_not_in_a_trial() -> None:
    driver = OperatedDriver()
    driver.wait_for("response")
    driver.propose("a1")
    driver.bus.publish(t.REMARK, m.Remark(text="You are doing fine.", actor="operator.ana"))
    assert driver.said == []
    driver.wait_for("enter", "attempt")
    assert driver.acted == ["o1"]
    (said, *_) = driver.said
    assert facts(said, "kind decision actor spoken") == (
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
def test_a_remark_has_the_manner_of_its_valence_unless_given(
    how: dict[str, Any], face: str, gesture: str
) -> None:
    driver = OperatedDriver()
    driver.bus.publish(t.REMARK, m.Remark(text="You are doing fine.", actor="operator.ana", **how))
    (said,) = driver.said
    assert (said.face, said.gesture, said.tone) == (face, gesture, "success" if how else "")


def test_at_the_end_feedback_is_given_and_remarks_are_dropped() -> None:
    driver = OperatedDriver()
    driver.propose("a1")
    driver.bus.publish(t.REMARK, m.Remark(text="Bye.", actor="operator.ana"))
    driver.propose("a2", policy="queue")
    driver.bus.publish(EVENT, Event(ended=m.SessionEnded(status="completed")))
    assert driver.dropped == [("o1", "late")]


def test_the_participants_stop_key_is_recorded_without_an_actor() -> None:
    driver = OperatedDriver(operator_feedback="manual")
    driver.propose("a1")
    driver.stop()
    assert each(driver.all(t.DROPPED), "reason actor") == [("stopped", "agent")]


def test_a_pending_gesture_is_dropped_by_a_trial() -> None:
    driver = OperatedDriver(operator_gesture="approve", operator_time_ms=60_000)
    driver.propose("a1", gesture="nod")
    driver.wait_for("quiet")
    assert driver.dropped == [("a1.gesture", "late")]


def test_a_gesture_with_its_own_mode_is_pending_alone() -> None:
    driver = OperatedDriver(operator_gesture="approve")
    driver.propose("a1", gesture="nod")
    assert [(said.id, said.gesture) for said in driver.said] == [("a1", "")]
    (pending,) = driver.all(t.PENDING_APPROVAL)
    assert facts(pending.proposal, "id kind text") == ("a1.gesture", "gesture", "")
    driver.report("a1")
    driver.decide("a1.gesture", "accept")
    assert [said.gesture for said in driver.said][-1] == "nod"


@pytest.mark.parametrize(("lost", "gesture"), [("silent", ""), ("autonomous", "nod")])
def test_without_an_operator_a_controlled_gesture_is_dropped_or_made_with_its_words(
    lost: str, gesture: str
) -> None:
    driver = OperatedDriver(operated=False, operator_gesture="approve", operator_lost=lost)
    driver.propose("a1", gesture="nod")
    assert [(said.id, said.gesture) for said in driver.said] == [("a1", gesture)]
    assert driver.all(t.PENDING_APPROVAL) == driver.all(t.DROPPED) == []


def test_a_filler_keeps_its_gesture_in_any_mode() -> None:
    driver = OperatedDriver(operator_gesture="approve")
    driver.propose("a1", kind="filler", gesture="nod")
    assert [said.gesture for said in driver.said] == ["nod"]
    assert driver.all(t.PENDING_APPROVAL) == []


# --- the level


def test_in_autonomous_mode_a_change_of_level_happens_at_once() -> None:
    assert OperatedDriver().ask_for_level(2, 3)


@pytest.mark.parametrize(
    ("mode", "happens"), [("autonomous", True), ("veto", False), ("manual", False)]
)
def test_after_the_last_attempt_a_controlled_level_stays(mode: str, happens: bool) -> None:
    driver = OperatedDriver(operator_difficulty=mode)
    assert driver.ask_for_level(2, 3, is_last=True) is happens
    assert driver.all(t.PENDING_APPROVAL) == []


def test_a_change_of_level_waits_for_an_operator() -> None:
    driver = OperatedDriver(operator_difficulty="approve")
    assert not driver.ask_for_level(2, 3)
    assert driver.awaits_operator
    driver.decide("l1", "accept")
    (decided,) = driver.all(t.LEVEL_DECIDED)
    assert (decided.level, decided.decision, decided.actor) == (3, "accepted", "operator.ana")


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ({"verdict": "veto"}, "rejected"),
        ({"verdict": "edit", "level": 5}, "edited"),
        ({"verdict": "edit", "level": 3}, "accepted"),
    ],
)
def test_an_operator_decides_on_the_level(how: dict[str, Any], expected: str) -> None:
    driver = OperatedDriver(operator_difficulty="veto")
    driver.ask_for_level(2, 3)
    driver.decide("l1", **how)
    assert [decided.decision for decided in driver.all(t.LEVEL_DECIDED)] == [expected]


def test_a_level_set_by_hand_rejects_a_pending_one() -> None:
    driver = OperatedDriver(operator_difficulty="veto")
    driver.ask_for_level(2, 3)
    driver.bus.publish(t.COMMAND, m.SessionCommand(command="level", value=1, actor="operator.ana"))
    driver.clock.advance(60 * SECOND)
    assert [decided.decision for decided in driver.all(t.LEVEL_DECIDED)] == ["rejected"]
