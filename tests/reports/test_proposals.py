"""Outcome of each proposal."""

from typing import Any, get_args, get_type_hints

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.proposals import Fate, ProposalRecord, proposal_records
from sar_tui.rules.parameters import TaskParameters
from tests.reports.session_script import (
    Script,
    action,
    decision,
    level_decided,
    pending,
    proposal,
    seen,
)

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


def pending_feedback() -> Script:
    """An operator is there; feedback is pending at 1000 ms, and on the screen at 1030 ms."""
    return Script().join(10).log(1000, A1, pending(A1)).log(1040, seen("a1", 1030))


def test_autonomous_actions_are_the_agents() -> None:
    record = only(Script().join(10).log(1000, A1, action(A1, ground="mode")), ALONE)
    assert (record.kind, record.mode, record.fate, record.verdict) == (
        "feedback",
        "autonomous",
        "agent",
        None,
    )
    assert (record.pending_at, record.waiting_ms, record.decision_ms) == (None, None, None)


def test_an_accepted_proposal_has_its_two_latencies() -> None:
    script = pending_feedback().log(1835, decision("a1", ms=1830), action(A1)).log(2500, action(A1))
    record = only(script)
    assert (record.mode, record.fate, record.verdict) == ("approve", "accepted", "accepted")
    assert record.decision_ms == 800, "from the screen to the key, not to its arrival"
    assert record.waiting_ms == 835, "from pending to the decision, not to its turn"
    assert record.said == "Too slow."


def test_an_edit_stores_the_proposed_and_the_said_text() -> None:
    milder = action(A1, "edited", text="A little slow.", valence="neutral")
    record = only(
        pending_feedback().log(1500, decision("a1", "edit", 1499), milder).log(1600, milder)
    )
    assert (record.fate, record.verdict) == ("edited", "edited")
    assert (record.text, record.said, record.valence, record.said_valence) == (
        "Too slow.",
        "A little slow.",
        "negative",
        "neutral",
    )


def test_a_veto_leaves_nothing_said() -> None:
    record = only(
        pending_feedback().log(
            1500, decision("a1", "veto", 1500), m.Dropped(id="a1", reason="vetoed")
        )
    )
    assert (record.fate, record.verdict, record.said, record.decision_ms) == (
        "vetoed",
        "vetoed",
        None,
        470,
    )


def test_an_accepted_proposal_can_be_vetoed_in_the_queue_and_the_first_key_is_timed() -> None:
    script = pending_feedback().log(1230, decision("a1", ms=1230), action(A1))
    script.log(1900, decision("a1", "veto", 1900), m.Dropped(id="a1", reason="vetoed"))
    record = only(script)
    assert (record.fate, record.verdict, record.decision_ms, record.waiting_ms) == (
        "vetoed",
        "vetoed",
        200,
        230,
    )


def test_an_accepted_proposal_that_comes_too_late_still_counts_as_agreement() -> None:
    script = (
        pending_feedback()
        .log(1230, decision("a1", ms=1230), action(A1))
        .log(3000, m.Dropped(id="a1", reason="late"))
    )
    record = only(script)
    assert (record.fate, record.verdict, record.said) == ("late", "accepted", None)


def test_an_action_cut_off_under_way_is_vetoed() -> None:
    script = Script().join(10).log(1000, A1, action(A1, ground="mode"))
    record = only(
        script.log(
            1600, decision("a1", "veto", 1590), m.Halt(action="a1", reason="vetoed", asked=1590)
        ),
        ALONE,
    )
    assert (record.fate, record.verdict, record.key_at) == ("cut_off", "vetoed", 1_590_000_000)
    assert record.decision_ms is None, "it stood on no operator's screen"


def test_a_halt_of_everything_is_not_an_operators_verdict() -> None:
    script = (
        Script()
        .log(1000, A1, action(A1, ground="mode"))
        .log(1500, m.Halt(reason="stopped", asked=1500))
    )
    assert only(script, ALONE).verdict is None


def test_a_key_after_the_deadline_decides_nothing() -> None:
    script = pending_feedback().log(5000, action(A1, ground="deadline"))
    record = only(
        script.log(
            5100,
            decision("a1", "veto", 5090),
            m.LateDecision(actor="x", what="veto a1", why="late"),
        )
    )
    assert (record.fate, record.verdict, record.key_at, record.waiting_ms) == (
        "timed_out_done",
        None,
        None,
        4000,
    )


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
def test_each_outcome_without_an_operator_has_a_name(end: m.Message, fate: str) -> None:
    record = only(pending_feedback().log(5000, end))
    assert (record.fate, record.verdict, record.key_at) == (fate, None, None)


@pytest.mark.parametrize("reason", get_args(get_type_hints(m.Dropped)["reason"]))
def test_each_reason_to_drop_a_proposal_has_an_outcome(reason: Any) -> None:
    fate = only(pending_feedback().log(5000, m.Dropped(id="a1", reason=reason))).fate
    assert fate in get_args(Fate)
    assert fate != "open"


def test_two_operators_are_timed_each_by_their_own_screen() -> None:
    script = pending_feedback().log(1400, seen("a1", 1390, "operator.ben"))
    ben = m.Decision(action="a1", verdict="accept", actor="operator.ben", at=1_890_000_000)
    record = only(script.log(1895, ben, action(A1)))
    assert (record.by, record.decision_ms) == ("operator.ben", 500)


def test_a_key_without_effect_does_not_count_for_a_later_change_of_mode() -> None:
    script = pending_feedback().log(1500, decision("a1", ms=1500))
    record = only(script.log(3000, m.ModeChanged(kind="feedback", mode="autonomous"), action(A1)))
    assert (record.verdict, record.key_at, record.waiting_ms) == ("accepted", None, 2000)


def test_a_decision_on_an_unseen_proposal_has_no_latency() -> None:
    script = (
        Script().join(10).log(1000, A1, pending(A1)).log(1500, decision("a1", ms=1500), action(A1))
    )
    assert only(script).decision_ms is None


def test_the_mode_is_the_one_set_at_the_time_of_the_proposal() -> None:
    later = proposal("a2")
    script = (
        Script()
        .join(10)
        .log(1000, A1)
        .log(2000, m.ModeChanged(kind="feedback", mode="manual"))
        .log(3000, later)
    )
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
def test_each_kind_has_the_mode_of_its_controlled_kind(kind: Any, ruled_by: str, mode: str) -> None:
    record = only(Script().join(10).log(1000, proposal("a1", kind)))
    assert (record.kind, record.mode) == (ruled_by, mode)


def test_a_separate_gesture_is_a_proposal_without_a_valence() -> None:
    wave = proposal("a1.gesture", "gesture", "", gesture="nod", valence="negative")
    script = (
        Script()
        .join(10)
        .log(1000, A1, pending(A1), pending(wave))
        .log(1500, decision(wave.id), action(wave))
    )
    assert [
        (record.id, record.kind, record.fate, record.valence)
        for record in proposal_records(script, APPROVE)
    ] == [
        ("a1", "feedback", "open", "negative"),
        ("a1.gesture", "gesture", "accepted", None),
    ]


def test_an_operators_remark_is_no_proposal() -> None:
    said = m.Action(
        id="o1",
        kind="remark",
        text="Take your time.",
        decision="initiated",
        actor="x",
        ground="operator",
    )
    assert proposal_records(Script().join(10).log(1000, said), APPROVE) == []


# --- levels

L1 = proposal("l1", "difficulty", "Level 1 → 2")
UP = m.LevelChanged(previous=1, level=2, reason="success")


@pytest.mark.parametrize(
    ("decided", "fate", "verdict"),
    [
        (level_decided("l1", 2, "accepted", "operator"), "accepted", "accepted"),
        (level_decided("l1", 3, "edited", "operator"), "edited", "edited"),
        (level_decided("l1", 0, "rejected", "operator"), "vetoed", "vetoed"),
        (level_decided("l1", 2, "accepted", "deadline"), "timed_out_done", None),
        (level_decided("l1", 0, "rejected", "deadline"), "timed_out_dropped", None),
        (level_decided("l1", 2, "accepted", "no operator"), "no_operator_done", None),
        (level_decided("l1", 0, "rejected", "no operator"), "no_operator_dropped", None),
        (level_decided("l1", 0, "rejected", "mode"), "amended", None),
    ],
)
def test_a_pending_change_of_level_is_one_proposal(
    decided: m.LevelDecided, fate: str, verdict: str | None
) -> None:
    change = () if decided.decision == "rejected" else (UP,)
    script = Script().join(10).log(1000, pending(L1, level=2)).log(1700, decided, *change)
    record = only(script)
    assert (record.kind, record.mode, record.fate, record.verdict) == (
        "difficulty",
        "approve",
        fate,
        verdict,
    )
    assert record.waiting_ms == 700


def test_a_level_left_to_the_operator_stays() -> None:
    script = (
        Script()
        .join(10)
        .log(1000, pending(L1, "manual", 2))
        .log(9000, level_decided("l1", 0, "rejected", "mode"))
    )
    assert only(script, MANUAL).fate == "manual_dropped"


STARTED = m.AttemptStarted(attempt=2, practice=False, level=1, trials=3)
ENDED = m.AttemptEnded(
    attempt=1, practice=False, level=1, metric=None, metric_unit="ms", accuracy=1, correct=3,
    trials=3, outcome="success", feedback="none", started=0, ended=1
)  # fmt: skip


def switched() -> Script:
    """A level is pending; then the operator sets its mode to manual."""
    taken = m.ModeChanged(kind="difficulty", mode="manual", actor="x")
    return (
        Script().join(10).log(1000, pending(L1, level=2)).log(2000, taken, pending(L1, "manual", 2))
    )


def test_a_level_whose_mode_changed_while_pending_is_dropped_for_that_reason() -> None:
    script = switched().log(9000, STARTED, level_decided("l1", 0, "rejected", "mode"))
    record = only(script)
    assert (record.mode, record.fate, record.verdict) == ("approve", "mode_changed", None)


def test_feedback_whose_mode_changed_while_pending_is_dropped_for_that_reason() -> None:
    taken = m.ModeChanged(kind="feedback", mode="manual", actor="x")
    script = (
        pending_feedback()
        .log(2000, taken, pending(A1, "manual"))
        .log(9000, m.Dropped(id="a1", reason="manual"))
    )
    assert only(script).fate == "mode_changed"


@pytest.mark.parametrize(
    ("cause", "fate"),
    [
        (ENDED, "amended"),
        (m.SessionCommand(command="stop", actor="x"), "stopped"),
        (m.SessionEnded(status="aborted"), "late"),
    ],
)
def test_a_level_dropped_for_another_reason_has_that_reason(cause: m.Message, fate: str) -> None:
    assert (
        only(switched().log(9000, cause, level_decided("l1", 0, "rejected", "mode"))).fate == fate
    )


def test_a_level_rejected_without_being_pending_is_a_proposal() -> None:
    script = Script().log(1000, level_decided("l1", 1, "rejected", "no operator"))
    record = only(script)
    assert (record.fate, record.pending_at, record.waiting_ms) == (
        "no_operator_dropped",
        None,
        None,
    )


def test_a_level_that_was_never_pending_is_the_agents() -> None:
    down = m.LevelChanged(previous=2, level=1, reason="failure")
    found = proposal_records(Script().join(10).log(1000, UP).log(2000, down), ALONE)
    assert [(record.kind, record.fate) for record in found] == [("difficulty", "agent")] * 2


def test_without_an_operator_a_level_is_changed_without_one() -> None:
    assert only(Script().log(1000, UP)).fate == "no_operator_done"


def test_an_operator_of_one_run_does_not_count_for_the_next() -> None:
    assert only(Script().join(10).begin(2, 0).log(1000, UP)).fate == "no_operator_done"


def test_after_the_last_attempt_no_operator_is_asked_about_the_level() -> None:
    assert only(Script().join(10).log(1000, UP)).fate == "agent"


def test_a_level_set_by_hand_is_no_proposal() -> None:
    assert (
        proposal_records(
            Script().log(1000, m.LevelChanged(previous=1, level=3, reason="operator")), ALONE
        )
        == []
    )


def test_a_change_that_replaces_a_pending_one_is_counted_as_well() -> None:
    script = (
        Script()
        .join(10)
        .log(1000, pending(L1, "manual", 2))
        .join(2000, state="lost", operated=False)
    )
    script.log(3000, level_decided("l1", 0, "rejected", "mode"), UP)
    assert [record.fate for record in proposal_records(script, MANUAL)] == [
        "manual_dropped",
        "no_operator_done",
    ]
