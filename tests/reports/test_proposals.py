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
    has,
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
A1 = proposal("a1", valence="negative", text="Too slow.")


def only(script: Script, parameters: TaskParameters = APPROVE) -> ProposalRecord:
    (record,) = proposal_records(script, parameters)
    return record


def started() -> Script:
    """An operator is there from 10 ms on."""
    return Script().join(10)


def pending_feedback() -> Script:
    """An operator is there; feedback is pending at 1000 ms, and on the screen at 1030 ms."""
    return started().log(1000, A1, pending(A1)).log(1040, seen("a1", 1030))


def dropped(reason: Any, id: str = "a1") -> m.Dropped:
    return m.Dropped(id=id, reason=reason)


MILDER = action(A1, "edited", text="A little slow.", valence="neutral")
CUT_OFF = m.Halt(action="a1", reason="vetoed", asked=1590)
LATE = m.LateDecision(actor="x", what="veto a1", why="late")
BY_BEN = m.Decision(action="a1", verdict="accept", actor="operator.ben", at=1_890_000_000)
OUTCOMES: dict[str, tuple[Script, dict[str, Any]]] = {
    "accepted": (
        pending_feedback().log(1835, decision("a1", ms=1830), action(A1)).log(2500, action(A1)),
        # from the screen to the key, not to its arrival; from pending to the decision, not to its turn
        {"mode": "approve", "fate": "accepted", "verdict": "accepted", "said": "Too slow.",
         "decision_ms": 800, "waiting_ms": 835},
    ),
    "edited": (
        pending_feedback().log(1500, decision("a1", "edit", 1499), MILDER).log(1600, MILDER),
        {"fate": "edited", "verdict": "edited", "text": "Too slow.", "said": "A little slow.",
         "valence": "negative", "said_valence": "neutral"},
    ),
    "vetoed": (
        pending_feedback().log(1500, decision("a1", "veto", 1500), dropped("vetoed")),
        {"fate": "vetoed", "verdict": "vetoed", "said": None, "decision_ms": 470},
    ),
    "vetoed in the queue, the first key is timed": (
        pending_feedback().log(1230, decision("a1", ms=1230), action(A1))
        .log(1900, decision("a1", "veto", 1900), dropped("vetoed")),
        {"fate": "vetoed", "verdict": "vetoed", "decision_ms": 200, "waiting_ms": 230},
    ),
    "accepted, but too late": (
        pending_feedback().log(1230, decision("a1", ms=1230), action(A1)).log(3000, dropped("late")),
        {"fate": "late", "verdict": "accepted", "said": None},
    ),
    "a key after the deadline": (
        pending_feedback().log(5000, action(A1, ground="deadline"))
        .log(5100, decision("a1", "veto", 5090), LATE),
        {"fate": "timed_out_done", "verdict": None, "key_at": None, "waiting_ms": 4000},
    ),
    "of two operators, each is timed by their own screen": (
        pending_feedback().log(1400, seen("a1", 1390, "operator.ben")).log(1895, BY_BEN, action(A1)),
        {"by": "operator.ben", "decision_ms": 500},
    ),
    "a key without effect before a change of mode": (
        pending_feedback().log(1500, decision("a1", ms=1500))
        .log(3000, m.ModeChanged(kind="feedback", mode="autonomous"), action(A1)),
        {"verdict": "accepted", "key_at": None, "waiting_ms": 2000},
    ),
    "never on a screen": (
        started().log(1000, A1, pending(A1)).log(1500, decision("a1", ms=1500), action(A1)),
        {"fate": "accepted", "decision_ms": None},
    ),
    "mode changed while pending": (
        pending_feedback().log(2000, m.ModeChanged(kind="feedback", mode="manual", actor="x"))
        .log(2000, pending(A1, "manual")).log(9000, dropped("manual")),
        {"fate": "mode_changed"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", OUTCOMES)
def test_a_pending_proposal_has_its_outcome_and_latencies(case: str) -> None:
    script, expected = OUTCOMES[case]
    has(only(script), **expected)


def test_autonomous_actions_are_the_agents_unless_an_operator_cuts_them_off() -> None:
    done = (A1, action(A1, ground="mode"))
    record = only(started().log(1000, *done), ALONE)
    has(record, kind="feedback", mode="autonomous", fate="agent", verdict=None)
    has(record, pending_at=None, waiting_ms=None, decision_ms=None)
    cut_off = started().log(1000, *done).log(1600, decision("a1", "veto", 1590), CUT_OFF)
    record = only(cut_off, ALONE)
    has(record, fate="cut_off", verdict="vetoed", key_at=1_590_000_000)
    assert record.decision_ms is None, "it stood on no operator's screen"
    everything = Script().log(1000, *done).log(1500, m.Halt(reason="stopped", asked=1500))
    assert only(everything, ALONE).verdict is None


FATES = {
    **dict.fromkeys(get_args(get_type_hints(m.Dropped)["reason"])),
    "expired": "timed_out_dropped",
    "no operator": "no_operator_dropped",
    "manual": "manual_dropped",
    **{reason: reason for reason in ("late", "stopped", "amended")},
}


def test_each_outcome_without_an_operator_has_a_name() -> None:
    for reason, name in FATES.items():
        record = only(pending_feedback().log(5000, dropped(reason)))
        assert record.fate in get_args(Fate)
        assert record.fate == name if name else record.fate != "open", reason
        has(record, key_at=None)
    ends: list[tuple[m.Message, str]] = [
        (action(A1, ground="no operator"), "no_operator_done"),
        (m.Waiting(what="enter", stage="attempt"), "open"),
    ]
    for end, fate in ends:
        has(only(pending_feedback().log(5000, end)), fate=fate, verdict=None, key_at=None)


def test_each_has_the_mode_of_its_controlled_kind_at_the_time_of_the_proposal() -> None:
    rows: list[tuple[Any, str, str]] = [
        ("greeting", "instruction", "autonomous"),
        ("goodbye", "instruction", "autonomous"),
        ("rest", "encouragement", "veto"),
        ("feedback", "feedback", "approve"),
        ("filler", "filler", "autonomous"),
    ]
    proposals = [proposal(kind, kind) for kind, *_ in rows]
    script = started().log(1000, *proposals)
    script.log(2000, m.ModeChanged(kind="feedback", mode="manual"))
    *first, later = proposal_records(script.log(3000, A1), APPROVE)
    assert [(record.id, record.kind, record.mode) for record in first] == rows
    has(later, id="a1", kind="feedback", mode="manual")


def test_a_separate_gesture_is_a_proposal_without_a_valence() -> None:
    wave = proposal("a1.gesture", "gesture", "", gesture="nod", valence="negative")
    script = started().log(1000, A1, pending(A1), pending(wave))
    script.log(1500, decision(wave.id), action(wave))
    said, made = proposal_records(script, APPROVE)
    has(said, id="a1", kind="feedback", fate="open", valence="negative")
    has(made, id="a1.gesture", kind="gesture", fate="accepted", valence=None)


L1 = proposal("l1", "difficulty", "Level 1 → 2")
UP = m.LevelChanged(previous=1, level=2, reason="success")


@pytest.mark.parametrize(
    ("level", "decided", "ground", "fate", "verdict"),
    [
        (2, "accepted", "operator", "accepted", "accepted"),
        (3, "edited", "operator", "edited", "edited"),
        (0, "rejected", "operator", "vetoed", "vetoed"),
        (2, "accepted", "deadline", "timed_out_done", None),
        (0, "rejected", "deadline", "timed_out_dropped", None),
        (2, "accepted", "no operator", "no_operator_done", None),
        (0, "rejected", "no operator", "no_operator_dropped", None),
        (0, "rejected", "mode", "amended", None),
    ],
)
def test_a_pending_change_of_level_is_one_proposal(
    level: int, decided: str, ground: str, fate: str, verdict: str | None
) -> None:
    change = () if decided == "rejected" else (UP,)
    script = started().log(1000, pending(L1, level=2))
    record = only(script.log(1700, level_decided("l1", level, decided, ground), *change))
    has(record, kind="difficulty", mode="approve", fate=fate, verdict=verdict, waiting_ms=700)


MANUAL = TaskParameters(operator_difficulty="manual")
REJECTED = level_decided("l1", 0, "rejected", "mode")
ENDED = m.AttemptEnded(
    attempt=1, practice=False, level=1, metric=None, metric_unit="ms", accuracy=1, correct=3,
    trials=3, outcome="success", feedback="none", started=0, ended=1
)  # fmt: skip


@pytest.mark.parametrize(
    ("cause", "fate"),
    [
        (m.AttemptStarted(attempt=2, practice=False, level=1, trials=3), "mode_changed"),
        (ENDED, "amended"),
        (m.SessionCommand(command="stop", actor="x"), "stopped"),
        (m.SessionEnded(status="aborted"), "late"),
    ],
)
def test_a_level_whose_mode_changed_while_pending_is_dropped_for_its_reason(
    cause: m.Message, fate: str
) -> None:
    taken = m.ModeChanged(kind="difficulty", mode="manual", actor="x")
    script = started().log(1000, pending(L1, level=2)).log(2000, taken, pending(L1, "manual", 2))
    has(only(script.log(9000, cause, REJECTED)), mode="approve", fate=fate, verdict=None)


def test_a_level_that_was_never_pending_is_the_agents_or_dropped_for_want_of_an_operator() -> None:
    down = m.LevelChanged(previous=2, level=1, reason="failure")
    found = proposal_records(started().log(1000, UP).log(2000, down), ALONE)
    assert [(record.kind, record.fate) for record in found] == [("difficulty", "agent")] * 2
    assert only(started().log(1000, UP)).fate == "agent", "after the last attempt nobody is asked"
    for script in (Script(), started().begin(2, 0)):
        assert only(script.log(1000, UP)).fate == "no_operator_done"
    rejected = Script().log(1000, level_decided("l1", 1, "rejected", "no operator"))
    has(only(rejected), fate="no_operator_dropped", pending_at=None, waiting_ms=None)
    left = started().log(1000, pending(L1, "manual", 2)).log(9000, REJECTED)
    assert only(left, MANUAL).fate == "manual_dropped"


def test_what_an_operator_does_unasked_is_no_proposal() -> None:
    remark = proposal("o1", "remark", "Take your time.")
    by_hand = m.LevelChanged(previous=1, level=3, reason="operator")
    script = started().log(1000, action(remark, "initiated")).log(2000, by_hand)
    assert proposal_records(script, APPROVE) == []


def test_a_change_that_replaces_a_pending_one_is_counted_as_well() -> None:
    script = started().log(1000, pending(L1, "manual", 2)).gone(2000).log(3000, REJECTED, UP)
    fates = [record.fate for record in proposal_records(script, MANUAL)]
    assert fates == ["manual_dropped", "no_operator_done"]
