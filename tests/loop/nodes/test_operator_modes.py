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

ANA = "operator.ana"


class OperatedDriver(ArbiterDriver):
    """Drives an arbiter with an operator, who controls feedback in a mode."""

    def __init__(self, mode: str = "autonomous", *, operated: bool = True, **settings: Any) -> None:
        super().__init__({"speech": ("say",)}, operator_feedback=mode, **settings)
        if operated:
            self.operator("joined", operated=True)

    def operator(self, state: Any, *, operated: bool) -> None:
        joined = m.OperatorChanged(actor=ANA, state=state, operated=operated)
        self.bus.publish(t.PRESENCE, joined)

    def decide(self, action: str, verdict: Any, **how: Any) -> None:
        decision = m.Decision(action=action, verdict=verdict, actor=ANA, at=self.clock.now(), **how)
        self.bus.publish(t.DECISION, decision)

    def change_mode(self, kind: Any, mode: Any) -> None:
        self.bus.publish(t.MODE, m.ModeChanged(kind=kind, mode=mode, actor=ANA))

    def remark(self, text: str = "You are doing fine.", **how: Any) -> None:
        self.bus.publish(t.REMARK, m.Remark(text=text, actor=ANA, **how))

    def end(self, status: Any = "completed") -> None:
        self.bus.publish(EVENT, Event(ended=m.SessionEnded(status=status)))

    def pass_seconds(self, seconds: float) -> None:
        self.clock.advance(round(seconds * SECOND))

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
    def pending(self) -> list[str]:
        return each(self.state.pending, "proposal.id")

    @property
    def awaits_operator(self) -> bool:
        found = self.all(t.ACTING)
        return bool(found and found[-1].awaits_operator)


# --- the four modes


@pytest.mark.parametrize(
    ("mode", "afterwards", "is_made"),
    [("veto", "drop", True), ("approve", "act", True), ("approve", "drop", False)],
)
def test_an_undecided_proposal_is_made_or_dropped_at_the_deadline(
    mode: str, afterwards: str, is_made: bool
) -> None:
    driver = OperatedDriver(mode, operator_timeout=afterwards, operator_time_ms=3000)
    driver.propose("a1")
    driver.clock.advance(3 * SECOND - 1)
    assert driver.said == []
    driver.clock.advance(1)
    assert each(driver.said, "actor ground mode") == [("agent", "deadline", mode)] * is_made
    assert each(driver.all(t.DROPPED), "reason") == ["expired"] * (not is_made)


def test_a_proposal_that_is_vetoed_or_stopped_by_the_participant_is_not_made() -> None:
    driver = OperatedDriver("veto")
    driver.propose("a1", "a2")
    driver.decide("a1", "veto")
    driver.stop()
    driver.pass_seconds(60)
    assert driver.said == []
    dropped = [("a1", "vetoed", ANA), ("a2", "stopped", "agent")]
    assert each(driver.all(t.DROPPED), "id reason actor") == dropped


def test_an_accepted_proposal_is_made_at_once_unchanged() -> None:
    driver = OperatedDriver("approve")
    driver.propose("a1")
    driver.clock.advance(700 * MS)
    driver.decide("a1", "accept")
    accepted = [("a1", "accepted", ANA, "operator", SECOND + 700 * MS)]
    assert each(driver.said, "text decision actor ground decided") == accepted
    assert driver.all(t.DECIDED) == driver.said


def test_in_manual_mode_a_proposal_waits_for_the_operator_and_the_session_does_not() -> None:
    driver = OperatedDriver("manual")
    driver.propose("a1", "a2")
    driver.pass_seconds(600)
    assert (driver.said, driver.pending, driver.awaits_operator) == ([], ["a1", "a2"], False)
    driver.decide("a2", "accept")
    assert driver.acted == ["a2"]


def test_an_edited_proposal_has_the_operators_text_and_valence() -> None:
    driver = OperatedDriver("approve")
    driver.propose("a1", valence="negative", gesture="lean_in", face="encouraging", degree="strong")
    driver.decide("a1", "edit", text="Good.", valence="positive")
    (said,) = driver.said
    edited = ("Good.", "Good.", "positive", "edited")
    assert facts(said, "text spoken valence decision") == edited
    assert facts(said, "face gesture tone") == ("happy", "nod", "success")


@pytest.mark.parametrize(
    ("kind", "controlled"),
    [
        ("greeting", "instruction"),
        ("instruction", "instruction"),
        ("encouragement", "encouragement"),
        ("rest", "encouragement"),
        ("goodbye", "instruction"),
    ],
)
def test_each_kind_has_its_own_mode(kind: str, controlled: str) -> None:
    driver = OperatedDriver("approve")
    strict = OperatedDriver(**{f"operator_{controlled}": "approve"})
    for one in (driver, strict):
        one.propose("a1", kind=kind)
    assert (driver.acted, strict.acted) == (["a1"], [])


# --- time


@pytest.mark.parametrize("mode", ["autonomous", "veto", "approve"])
@given(decided_ms=st.integers(0, 2999))
def test_with_delayed_feedback_the_timing_does_not_reveal_who_decided(
    mode: str, decided_ms: int
) -> None:
    driver = OperatedDriver(mode, operator_time_ms=500)
    due = driver.clock.now() + 3 * SECOND
    driver.propose("a1", due=due)
    driver.clock.advance(decided_ms * MS)
    driver.decide("a1", "accept")
    driver.pass_seconds(10)
    assert [record.at for record in driver.records if record.topic is t.ACTION] == [due]


@pytest.mark.parametrize(
    ("mode", "timeout", "said"),
    [("veto", "drop", 1), ("approve", "act", 1), ("approve", "drop", 0)],
)
def test_pending_feedback_is_decided_when_the_session_is_completed(
    mode: str, timeout: str, said: int
) -> None:
    driver = OperatedDriver(mode, operator_timeout=timeout)
    driver.propose("a1", priority=40, due=driver.clock.now() + 3 * SECOND)
    driver.end()
    driver.propose("bye", kind="goodbye", priority=10)
    driver.report("a1")
    assert driver.acted == ["a1"] * said + ["bye"]


# --- the time to decide

MEDIAN = (
    "Well done: you took 498 ms on average, which is 22 ms faster than in the last attempt. Keep!"
)
"""As long as the median proposal: 19 words."""
SAME_TIME = {"operator_time_ms": 3000, "operator_ms_per_word": 0}


@pytest.mark.parametrize(
    ("proposals", "how", "settings", "seconds"),
    [
        ("a1", {"text": "Nod"}, {}, [4]),
        ("a1", {"text": MEDIAN}, {}, [6.75]),
        ("a1", {"text": f"{MEDIAN} {MEDIAN}"}, {}, [11.5]),
        ("a1 a2", {"text": MEDIAN}, {}, [6.75, 13.5]),
        ("a1", {"text": "", "spoken": MEDIAN}, {}, [6.75]),
        ("a1 a2", {"text": MEDIAN}, SAME_TIME, [3, 3]),
    ],
)
def test_the_time_to_decide_follows_from_the_words_of_all_that_is_read(
    proposals: str, how: dict[str, Any], settings: dict[str, Any], seconds: list[float]
) -> None:
    driver = OperatedDriver("approve", **settings)
    driver.propose(*proposals.split(), **how)
    now = driver.clock.now()
    assert [(one.deadline - now) / SECOND for one in driver.state.pending] == seconds


# --- what waits for a decision


def test_unsaid_feedback_can_be_requested() -> None:
    driver = OperatedDriver("approve")
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


@pytest.mark.parametrize("verdict", ["accept", "veto"])
def test_a_decision_after_the_deadline_is_reported_as_missed(verdict: str) -> None:
    driver = OperatedDriver("veto", operator_time_ms=500, operator_ms_per_word=0)
    driver.wait_for("response")
    driver.propose("a1")
    driver.pass_seconds(1)
    if verdict == "veto":
        driver.wait_for("enter", "attempt")
        driver.report("a1")
    driver.decide("a1", verdict)
    assert each(driver.all(t.LATE_DECISION), "actor what") == [(ANA, f"{verdict} a1")]
    driver.wait_for("enter", "attempt")
    assert each(driver.said, "id actor") == [("a1", "agent")]


def test_the_current_action_is_halted_by_a_veto_and_cannot_be_edited() -> None:
    driver = OperatedDriver()
    driver.propose("a1")
    driver.decide("a1", "edit", text="Else.")
    driver.decide("a7", "veto")
    assert driver.halted == []
    assert each(driver.all(t.LATE_DECISION), "what") == ["edit a1", "veto a7"]
    driver.decide("a1", "veto")
    assert driver.halted == [("a1", "vetoed")]


def test_a_waiting_filler_is_dropped_by_the_decision() -> None:
    driver = OperatedDriver("approve")
    driver.wait_for("foreperiod")
    driver.propose("a1")
    driver.propose("a2", kind="filler")
    driver.decide("a1", "accept")
    assert driver.dropped == [("a2", "late")]
    driver.wait_for("enter", "attempt")
    assert driver.acted == ["a1"]


def test_a_queued_action_can_be_vetoed_or_edited_again_and_again() -> None:
    driver = OperatedDriver()
    driver.wait_for("foreperiod")
    driver.propose("a1", "a2")
    driver.decide("a1", "veto")
    for text in ("Else.", "Other."):
        driver.decide("a2", "edit", text=text)
    assert driver.said == []
    edits = [("Else.", "edited"), ("Other.", "edited")]
    assert each(driver.all(t.DECIDED), "text decision") == edits
    driver.wait_for("enter", "attempt")
    assert each(driver.said, "text") == ["Other."]


@pytest.mark.parametrize(("decided", "covered"), [("a1", "a2"), ("a2", "a1")])
def test_a_filler_covers_a_wait_of_more_than_a_second_of_either_seat_once(
    decided: str, covered: str
) -> None:
    driver = OperatedDriver("approve", operator_time_ms=8000)
    driver.propose("a1", seat="A")
    driver.propose("a2", seat="B")
    driver.decide(decided, "veto")
    driver.clock.advance(SECOND - 1)
    assert driver.all(t.FILLER_DUE) == []
    driver.pass_seconds(4)
    assert driver.all(t.FILLER_DUE) == [m.FillerDue(id=covered)]


@pytest.mark.parametrize(
    ("settings", "how", "is_decided"),
    [
        ({"mode": "manual"}, {}, False),
        ({"filler": "always"}, {"due": 2 * SECOND}, False),
        ({"operator_encouragement": "approve"}, {"kind": "encouragement"}, False),
        ({"mode": "approve"}, {}, True),
    ],
)
def test_no_filler_covers_what_is_manual_soon_no_feedback_or_decided(
    settings: dict[str, Any], how: dict[str, Any], is_decided: bool
) -> None:
    driver = OperatedDriver(**{"operator_time_ms": 5000, **settings})
    driver.propose("a1", **how)
    if is_decided:
        driver.decide("a1", "accept")
    driver.pass_seconds(20)
    assert driver.all(t.FILLER_DUE) == []


@pytest.mark.parametrize(("filler", "covered"), [("operator", 0), ("always", 1), ("never", 0)])
@pytest.mark.parametrize("operated", [True, False])
def test_a_delay_is_covered_as_the_filler_setting_says(
    filler: str, covered: int, operated: bool
) -> None:
    driver = OperatedDriver(operated=operated, filler=filler)
    driver.propose("a1", due=driver.clock.now() + 4 * SECOND)
    driver.pass_seconds(10)
    assert len(driver.all(t.FILLER_DUE)) == covered


@pytest.mark.parametrize(
    ("status", "said", "dropped"),
    [("completed", ["a1", "a2"], ["o1"]), ("aborted", ["a1"], ["a2", "o1"])],
)
def test_the_last_feedback_precedes_the_goodbye_unless_the_session_was_aborted(
    status: Any, said: list[str], dropped: list[str]
) -> None:
    """Feedback for two seats comes in turn; ending the session does not drop the second."""
    driver = OperatedDriver()
    driver.propose("a1", "a2")
    driver.remark("Bye.")
    driver.end(status)
    driver.report("a1")
    assert driver.acted == said
    assert driver.dropped == [(name, "late") for name in dropped]


# --- without an operator


@pytest.mark.parametrize("lost", ["autonomous", "silent"])
def test_without_an_operator_the_agent_acts_by_itself_or_is_silent(lost: str) -> None:
    driver = OperatedDriver("approve", operated=False, operator_lost=lost)
    driver.propose("a1")
    acts = lost == "autonomous"
    assert each(driver.said, "ground actor") == [("no operator", "agent")] * acts
    assert driver.dropped == [("a1", "no operator")] * (not acts)
    assert driver.all(t.ARBITER_STATE) == [], "nobody reads it"


@pytest.mark.parametrize("mode", ["veto", "approve", "manual"])
@pytest.mark.parametrize(("lost", "acted"), [("autonomous", ["a1"]), ("silent", [])])
def test_when_the_operator_is_lost_pending_proposals_are_decided_at_once(
    mode: str, lost: str, acted: list[str]
) -> None:
    driver = OperatedDriver(mode, operator_lost=lost, operator_time_ms=60_000)
    driver.propose("a1")
    driver.operator("lost", operated=False)
    assert driver.acted == acted
    assert not driver.awaits_operator
    driver.operator("joined", operated=True)
    driver.report("a1")
    driver.propose("a2")
    assert (driver.acted, driver.pending[-1]) == (acted, "a2")


# --- changing modes, and the published state


def test_a_new_mode_applies_to_pending_proposals_of_its_kind() -> None:
    driver = OperatedDriver("manual")
    driver.propose("a1")
    driver.change_mode("encouragement", "autonomous")
    assert each(driver.all(t.PENDING_APPROVAL), "proposal.id") == ["a1"]
    driver.change_mode("feedback", "veto")
    driver.pass_seconds(10)
    driver.change_mode("feedback", "approve")
    driver.propose("a2")
    driver.report("a1")
    driver.change_mode("feedback", "autonomous")
    assert each(driver.said, "id actor") == [("a1", "agent"), ("a2", ANA)]


def test_the_complete_state_is_published_for_operators_when_it_changes() -> None:
    driver = OperatedDriver("approve", operator_time_ms=10_000)
    due = driver.clock.now() + 3 * SECOND
    driver.propose("a1", due=due, seat="B")
    state = driver.state
    assert state.operated
    assert state.modes["feedback"] == "approve"
    pending = [("a1", "approve", "act", due, "B")]
    assert each(state.pending, "proposal.id mode otherwise deadline seat") == pending
    driver.decide("a1", "accept")
    assert driver.pending == []
    driver.pass_seconds(3)
    assert driver.state.current is not None
    assert driver.state.current.id == "a1"
    published = len(driver.all(t.ARBITER_STATE))
    driver.wait_for("enter", "attempt")
    assert len(driver.all(t.ARBITER_STATE)) == published


# --- remarks of operators


def test_remarks_go_first_but_not_in_a_trial() -> None:
    driver = OperatedDriver()
    driver.wait_for("response")
    driver.propose("a1")
    driver.remark()
    assert driver.said == []
    driver.wait_for("enter", "attempt")
    assert driver.acted == ["o1"]
    remark = ("remark", "initiated", ANA, "You are doing fine.")
    assert facts(driver.said[0], "kind decision actor spoken") == remark


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
    driver.remark(**how)
    manner = (face, gesture, "success" if how else "")
    assert each(driver.said, "face gesture tone") == [manner]


# --- gestures


def test_a_gesture_with_its_own_mode_is_pending_alone() -> None:
    driver = OperatedDriver(operator_gesture="approve")
    driver.propose("a1", gesture="nod")
    assert each(driver.said, "id gesture") == [("a1", "")]
    (pending,) = driver.all(t.PENDING_APPROVAL)
    assert facts(pending.proposal, "id kind text") == ("a1.gesture", "gesture", "")
    driver.report("a1")
    driver.decide("a1.gesture", "accept")
    assert driver.said[-1].gesture == "nod"


@pytest.mark.parametrize(("lost", "gesture"), [("silent", ""), ("autonomous", "nod")])
def test_without_an_operator_a_controlled_gesture_is_dropped_or_made_with_its_words(
    lost: str, gesture: str
) -> None:
    driver = OperatedDriver(operated=False, operator_gesture="approve", operator_lost=lost)
    driver.propose("a1", gesture="nod")
    assert each(driver.said, "id gesture") == [("a1", gesture)]
    assert driver.all(t.PENDING_APPROVAL) == driver.all(t.DROPPED) == []
