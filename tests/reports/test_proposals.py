"""Given what was proposed and what came then, the docket knows what became of each proposal."""

from typing import Any, get_args, get_type_hints

import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.parameters import TaskParameters
from sar_tui.reports.proposals import Fate, ProposalRecord, proposal_records
from tests.reports.session_script import Script, action, decision, offer, proposal, ruled, seen

ALONE = TaskParameters()
APPROVE = TaskParameters(
    operator_feedback="approve",
    operator_difficulty="approve",
    operator_gesture="approve",
    operator_encouragement="veto",
)
MANUAL = TaskParameters(operator_difficulty="manual")
A1 = proposal("a1", valence="negative", text="Too slow.")


def only(script: Script, parameters: TaskParameters = APPROVE) -> ProposalRecord:
    (record,) = proposal_records(script, parameters)
    return record


def offered() -> Script:
    """Somebody is there; feedback is proposed at 1000 ms, and on their screen at 1030."""
    return Script().join(10).say(1000, A1, offer(A1)).say(1040, seen("a1", 1030))


def test_what_the_agent_may_do_alone_is_its_own() -> None:
    record = only(Script().join(10).say(1000, A1, action(A1, ground="mode")), ALONE)
    assert (record.kind, record.mode, record.fate, record.verdict) == ("feedback", "autonomous", "agent", None)
    assert (record.pending_at, record.waiting_ms, record.decision_ms) == (None, None, None)


def test_an_accepted_proposal_has_its_two_latencies() -> None:
    script = offered().say(1835, decision("a1", ms=1830), action(A1)).say(2500, action(A1))
    record = only(script)
    assert (record.mode, record.fate, record.verdict) == ("approve", "accepted", "accepted")
    assert record.decision_ms == 800, "from the screen to the key, not to its arrival"
    assert record.waiting_ms == 835, "from the offer to the decision, not to its turn"
    assert record.said == "Too slow."


def test_an_edit_keeps_what_was_proposed_and_what_was_said() -> None:
    milder = action(A1, "edited", text="A little slow.", valence="neutral")
    record = only(offered().say(1500, decision("a1", "edit", 1499), milder).say(1600, milder))
    assert (record.fate, record.verdict) == ("edited", "edited")
    assert (record.text, record.said, record.valence, record.said_valence) == (
        "Too slow.",
        "A little slow.",
        "negative",
        "neutral",
    )


def test_a_veto_leaves_nothing_said() -> None:
    record = only(offered().say(1500, decision("a1", "veto", 1500), m.Dropped(id="a1", reason="vetoed")))
    assert (record.fate, record.verdict, record.said, record.decision_ms) == ("vetoed", "vetoed", None, 470)


def test_what_was_accepted_can_be_vetoed_while_it_waits_for_its_turn_and_the_first_key_is_timed() -> None:
    script = offered().say(1230, decision("a1", ms=1230), action(A1))
    script.say(1900, decision("a1", "veto", 1900), m.Dropped(id="a1", reason="vetoed"))
    record = only(script)
    assert (record.fate, record.verdict, record.decision_ms, record.waiting_ms) == ("vetoed", "vetoed", 200, 230)


def test_what_was_accepted_and_then_came_too_late_was_agreed_with_all_the_same() -> None:
    script = offered().say(1230, decision("a1", ms=1230), action(A1)).say(3000, m.Dropped(id="a1", reason="late"))
    record = only(script)
    assert (record.fate, record.verdict, record.said) == ("late", "accepted", None)


def test_what_is_cut_off_under_way_is_vetoed_but_was_begun() -> None:
    script = Script().join(10).say(1000, A1, action(A1, ground="mode"))
    record = only(
        script.say(1600, decision("a1", "veto", 1590), m.Halt(action="a1", reason="vetoed", asked=1590)), ALONE
    )
    assert (record.fate, record.verdict, record.key_at) == ("cut_off", "vetoed", 1_590_000_000)
    assert record.decision_ms is None, "it stood on no operator's screen"


def test_a_halt_of_everything_is_not_an_operators_verdict() -> None:
    script = Script().say(1000, A1, action(A1, ground="mode")).say(1500, m.Halt(reason="stopped", asked=1500))
    assert only(script, ALONE).verdict is None


def test_a_key_after_the_deadline_decides_nothing() -> None:
    script = offered().say(5000, action(A1, ground="deadline"))
    record = only(script.say(5100, decision("a1", "veto", 5090), m.ActMissed(actor="x", what="veto a1", why="late")))
    assert (record.fate, record.verdict, record.key_at, record.waiting_ms) == ("timed_out_done", None, None, 4000)


@pytest.mark.parametrize(
    ("end", "fate"),
    [
        (action(A1, ground="no operator"), "no_operator_done"),
        (m.Dropped(id="a1", reason="expired"), "timed_out_dropped"),
        (m.Dropped(id="a1", reason="no operator"), "no_operator_dropped"),
        (m.Dropped(id="a1", reason="manual"), "manual_dropped"),
        (m.Dropped(id="a1", reason="late"), "late"),
        (m.Dropped(id="a1", reason="stopped"), "stopped"),
        (m.Dropped(id="a1", reason="amended"), "amended"),
        (m.Waiting(what="enter", stage="attempt"), "open"),
    ],
)
def test_each_end_without_an_operator_has_its_name(end: m.Message, fate: str) -> None:
    record = only(offered().say(5000, end))
    assert (record.fate, record.verdict, record.key_at) == (fate, None, None)


@pytest.mark.parametrize("reason", get_args(get_type_hints(m.Dropped)["reason"]))
def test_for_each_reason_to_drop_a_proposal_there_is_a_fate(reason: Any) -> None:
    fate = only(offered().say(5000, m.Dropped(id="a1", reason=reason))).fate
    assert fate in get_args(Fate)
    assert fate != "open"


def test_two_operators_are_timed_each_by_their_own_screen() -> None:
    script = offered().say(1400, seen("a1", 1390, "operator.ben"))
    ben = m.Decision(action="a1", verdict="accept", actor="operator.ben", at=1_890_000_000)
    record = only(script.say(1895, ben, action(A1)))
    assert (record.by, record.decision_ms) == ("operator.ben", 500)


def test_a_key_that_changed_nothing_does_not_count_for_what_a_change_of_mode_decides_later() -> None:
    script = offered().say(1500, decision("a1", ms=1500))
    record = only(script.say(3000, m.ModeChanged(kind="feedback", mode="autonomous"), action(A1)))
    assert (record.verdict, record.key_at, record.waiting_ms) == ("accepted", None, 2000)


def test_a_decision_by_who_never_had_it_on_screen_has_no_latency() -> None:
    script = Script().join(10).say(1000, A1, offer(A1)).say(1500, decision("a1", ms=1500), action(A1))
    assert only(script).decision_ms is None


def test_the_mode_is_that_which_was_set_when_it_was_proposed() -> None:
    later = proposal("a2")
    script = Script().join(10).say(1000, A1).say(2000, m.ModeChanged(kind="feedback", mode="manual")).say(3000, later)
    assert [(record.id, record.mode) for record in proposal_records(script, APPROVE)] == [
        ("a1", "approve"),
        ("a2", "manual"),
    ]


@pytest.mark.parametrize(
    ("kind", "ruled_by", "mode"),
    [
        ("greeting", "instruction", "autonomous"),
        ("goodbye", "instruction", "autonomous"),
        ("rest", "encouragement", "veto"),
        ("feedback", "feedback", "approve"),
        ("filler", "filler", "autonomous"),
    ],
)
def test_a_kind_goes_by_the_mode_of_its_ruler(kind: Any, ruled_by: str, mode: str) -> None:
    record = only(Script().join(10).say(1000, proposal("a1", kind)))
    assert (record.kind, record.mode) == (ruled_by, mode)


def test_a_gesture_apart_is_a_case_of_its_own_whose_valence_is_counted_with_its_words() -> None:
    wave = proposal("a1.gesture", "gesture", "", gesture="nod", valence="negative")
    script = Script().join(10).say(1000, A1, offer(A1), offer(wave)).say(1500, decision(wave.id), action(wave))
    assert [(record.id, record.kind, record.fate, record.valence) for record in proposal_records(script, APPROVE)] == [
        ("a1", "feedback", "open", "negative"),
        ("a1.gesture", "gesture", "accepted", None),
    ]


def test_an_operators_own_words_are_no_proposal() -> None:
    said = m.Action(id="o1", kind="remark", text="Take your time.", decision="initiated", actor="x", ground="operator")
    assert proposal_records(Script().join(10).say(1000, said), APPROVE) == []


# --- levels -------------------------------------------------------------------------------------------------------

L1 = proposal("l1", "difficulty", "Level 1 → 2")
UP = m.LevelChanged(previous=1, level=2, reason="success")


@pytest.mark.parametrize(
    ("ruling", "fate", "verdict"),
    [
        (ruled("l1", 2, "accepted", "operator"), "accepted", "accepted"),
        (ruled("l1", 3, "edited", "operator"), "edited", "edited"),
        (ruled("l1", 0, "rejected", "operator"), "vetoed", "vetoed"),
        (ruled("l1", 2, "accepted", "deadline"), "timed_out_done", None),
        (ruled("l1", 0, "rejected", "deadline"), "timed_out_dropped", None),
        (ruled("l1", 2, "accepted", "no operator"), "no_operator_done", None),
        (ruled("l1", 0, "rejected", "no operator"), "no_operator_dropped", None),
        (ruled("l1", 0, "rejected", "mode"), "amended", None),
    ],
)
def test_a_change_of_level_that_waited_is_one_case(ruling: m.LevelDecided, fate: str, verdict: str | None) -> None:
    told = () if ruling.decision == "rejected" else (UP,)
    script = Script().join(10).say(1000, offer(L1, level=2)).say(1700, ruling, *told)
    record = only(script)
    assert (record.kind, record.mode, record.fate, record.verdict) == ("difficulty", "approve", fate, verdict)
    assert record.waiting_ms == 700


def test_a_level_that_only_the_operator_would_have_changed_stays() -> None:
    script = Script().join(10).say(1000, offer(L1, "manual", 2)).say(9000, ruled("l1", 0, "rejected", "mode"))
    assert only(script, MANUAL).fate == "manual_dropped"


STARTED = m.AttemptStarted(attempt=2, practice=False, level=1, trials=3)
ENDED = m.AttemptEnded(
    attempt=1, practice=False, level=1, metric=None, metric_unit="ms", accuracy=1, correct=3, trials=3,
    outcome="success", feedback="none", started=0, ended=1
)  # fmt: skip


def switched() -> Script:
    """A level waits to be approved; then the operator takes levels over."""
    taken = m.ModeChanged(kind="difficulty", mode="manual", actor="x")
    return Script().join(10).say(1000, offer(L1, level=2)).say(2000, taken, offer(L1, "manual", 2))


def test_a_level_whose_mode_was_changed_while_it_waited_falls_away_for_that() -> None:
    script = switched().say(9000, STARTED, ruled("l1", 0, "rejected", "mode"))
    record = only(script)
    assert (record.mode, record.fate, record.verdict) == ("approve", "mode_changed", None)


def test_words_whose_mode_was_changed_while_they_waited_fall_away_for_that() -> None:
    taken = m.ModeChanged(kind="feedback", mode="manual", actor="x")
    script = offered().say(2000, taken, offer(A1, "manual")).say(9000, m.Dropped(id="a1", reason="manual"))
    assert only(script).fate == "mode_changed"


@pytest.mark.parametrize(
    ("cause", "fate"),
    [
        (ENDED, "amended"),
        (m.Operator(command="stop", actor="x"), "stopped"),
        (m.SessionEnded(status="aborted"), "late"),
    ],
)
def test_a_level_that_falls_away_for_another_reason_says_that_one(cause: m.Message, fate: str) -> None:
    assert only(switched().say(9000, cause, ruled("l1", 0, "rejected", "mode"))).fate == fate


def test_a_level_that_is_held_back_without_being_offered_is_a_case_too() -> None:
    script = Script().say(1000, ruled("l1", 1, "rejected", "no operator"))
    record = only(script)
    assert (record.fate, record.pending_at, record.waiting_ms) == ("no_operator_dropped", None, None)


def test_a_level_that_nobody_was_asked_about_is_the_agents_own() -> None:
    down = m.LevelChanged(previous=2, level=1, reason="failure")
    found = proposal_records(Script().join(10).say(1000, UP).say(2000, down), ALONE)
    assert [(record.kind, record.fate) for record in found] == [("difficulty", "agent")] * 2


def test_without_an_operator_a_level_that_would_wait_is_done_without_one() -> None:
    assert only(Script().say(1000, UP)).fate == "no_operator_done"


def test_who_was_there_in_a_run_is_not_there_in_the_next() -> None:
    assert only(Script().join(10).begin(2, 0).say(1000, UP)).fate == "no_operator_done"


def test_after_the_last_attempt_no_operator_is_asked_about_the_level() -> None:
    assert only(Script().join(10).say(1000, UP)).fate == "agent"


def test_a_level_set_by_hand_is_no_proposal() -> None:
    assert proposal_records(Script().say(1000, m.LevelChanged(previous=1, level=3, reason="operator")), ALONE) == []


def test_a_change_that_takes_the_place_of_one_that_waited_is_counted_beside_it() -> None:
    script = Script().join(10).say(1000, offer(L1, "manual", 2)).join(2000, state="lost", operated=False)
    script.say(3000, ruled("l1", 0, "rejected", "mode"), UP)
    assert [record.fate for record in proposal_records(script, MANUAL)] == ["manual_dropped", "no_operator_done"]
