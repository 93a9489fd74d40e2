"""A session with an operator waits for decisions on feedback and level, up to the deadline."""

from typing import Any

import msgspec
import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Result, Trial
from sar_tui.outputs.node import OutputNode
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import Speaker

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
BRIEF = {"attempts": 3, "filler": "never", "encouragement": False}
FEEDBACK = {"operator_feedback": "approve", "operator_time_ms": 60_000}
LEVEL = {"operator_difficulty": "approve", "operator_time_ms": 60_000}
ANA = "operator.ana"


def join(driver: LoopDriver) -> None:
    joined = m.OperatorChanged(actor=ANA, state="joined", operated=True)
    driver.session.bus.publish(t.PRESENCE, joined)


def keys(**settings: Any) -> LoopDriver:
    return LoopDriver(KEYBOARD, CALM, **{**BRIEF, "prompts_per_attempt": 2, **settings})


def operated(**settings: Any) -> LoopDriver:
    """Start a session with an operator, at the end of its first attempt."""
    driver = keys(**settings)
    join(driver)
    driver.enter()
    driver.attempt()
    return driver


def lifted(task: type[Task] = Lift, took_ms: float = 400, **settings: Any) -> LiftDriver:
    """Start a session with an operator and a therapist, at the end of its first attempt."""
    driver = LiftDriver(task, CALM, begin=False, **{**BRIEF, **settings})
    driver.session.begin()
    join(driver)
    driver.begin_lifts()
    driver.lift(took_ms)
    driver.lift(took_ms)
    return driver


def decide(driver: LoopDriver, action: str, verdict: Any, **how: Any) -> None:
    at = driver.clock.now()
    decision = m.Decision(action=action, verdict=verdict, actor=ANA, at=at, **how)
    driver.session.bus.publish(t.DECISION, decision)


def feedback(driver: LoopDriver) -> list[m.Action]:
    return [action for action in driver.all(t.ACTION) if action.kind == "feedback"]


def decide_feedback(driver: LoopDriver, verdict: Any) -> None:
    """Decide on the latest feedback that was pending."""
    proposals = [pending.proposal for pending in driver.all(t.PENDING_APPROVAL)]
    decide(driver, [one.id for one in proposals if one.kind == "feedback"][-1], verdict)


def pending(driver: LoopDriver, names: str = "proposal.id") -> list[Any]:
    return each(driver.last(t.ARBITER_STATE).pending, names)


def now(driver: LoopDriver, names: str = "stage level") -> tuple[Any, ...]:
    return facts(driver.waiting, names)


def kinds(driver: LoopDriver) -> list[str]:
    return each(driver.all(t.ACTION), "kind")


# --- feedback


def test_no_attempt_begins_while_feedback_is_decided_on() -> None:
    driver = operated(**FEEDBACK)
    assert now(driver, "what stage") == ("answer", "answer")
    driver.press("enter")
    assert driver.waiting.stage == "answer"
    decide_feedback(driver, "accept")
    assert now(driver, "what stage attempt") == ("enter", "attempt", 2)
    assert len(feedback(driver)) == 1


def test_manual_feedback_is_not_waited_for() -> None:
    driver = operated(operator_feedback="manual")
    assert driver.waiting.stage == "attempt"
    driver.press("enter")
    assert each(driver.all(t.DROPPED), "reason actor") == [("manual", "agent")]
    driver.to_prompt()
    assert feedback(driver) == []


def test_a_remark_during_the_delay_does_not_change_the_wait() -> None:
    driver = operated(extra=[OutputNode(Speaker(1000), "speech", CALM)], feedback_delay_ms=5000)
    known = len(driver.all(t.WAITING))
    driver.session.bus.publish(t.REMARK, m.Remark(text="Take your time.", actor=ANA))
    driver.wait(3000)
    acts = each(driver.all(t.ACTING)[-2:], "acting awaits_operator")
    assert acts == [(True, False), (False, False)]
    assert len(driver.all(t.WAITING)) == known
    driver.wait(10_000)
    assert each(driver.all(t.WAITING)[known:], "stage") == ["attempt"]


@pytest.mark.parametrize("decided_in_pause", [False, True])
def test_after_a_pause_the_wait_continues_or_what_was_decided_in_it_is_said(
    decided_in_pause: bool,
) -> None:
    driver = operated(**FEEDBACK)
    driver.operate("pause")
    if decided_in_pause:
        decide_feedback(driver, "accept")
    assert feedback(driver) == []
    driver.operate("resume")
    assert driver.waiting.stage == ("attempt" if decided_in_pause else "answer")
    assert len(feedback(driver)) == decided_in_pause


# --- the level


@pytest.mark.parametrize(
    ("how", "decided", "changed"),
    [
        ({"verdict": "accept"}, (2, "accepted"), [(1, 2, "success")]),
        ({"verdict": "veto"}, (0, "rejected"), []),
        ({"verdict": "edit", "level": 3}, (3, "edited"), [(1, 3, "operator")]),
        ({"verdict": "edit", "level": 2}, (2, "accepted"), [(1, 2, "success")]),
    ],
    ids=["accept", "veto", "edit", "edit to the same"],
)
def test_a_change_of_level_waits_for_an_operator_who_decides_on_it(
    how: dict[str, Any], decided: tuple[int, str], changed: list[tuple[Any, ...]]
) -> None:
    driver = operated(**LEVEL)
    assert (driver.waiting.stage, driver.all(t.LEVEL)) == ("answer", [])
    decide(driver, "l1", **how)
    assert each(driver.all(t.LEVEL_DECIDED), "level decision actor") == [(*decided, ANA)]
    assert each(driver.all(t.LEVEL), "previous level reason") == changed
    level = changed[0][1] if changed else 1
    assert now(driver) == ("attempt", level)
    driver.press("enter")
    assert driver.to_prompt().level == level


def test_a_manual_level_stays_until_it_is_accepted_for_the_next_attempt() -> None:
    driver = operated(operator_difficulty="manual")
    assert now(driver) == ("attempt", 1)
    driver.attempt()
    assert driver.waiting.level == 1
    decide(driver, "l2", "accept")
    assert now(driver) == ("attempt", 2)


def test_a_level_set_by_hand_overrides_a_pending_one() -> None:
    driver = operated(operator_difficulty="veto", operator_time_ms=5000)
    driver.operate("level", value=4)
    driver.wait(10_000)
    assert driver.waiting.level == 4
    assert each(driver.all(t.LEVEL_DECIDED), "decision") == ["rejected"]


@pytest.mark.parametrize(("lost", "level"), [("autonomous", 2), ("silent", 1)])
def test_a_pending_level_is_decided_without_an_operator_after_a_resume(
    lost: str, level: int
) -> None:
    killed = operated(operator_lost=lost, **LEVEL)
    assert now(killed) == ("answer", 1)
    driver = keys(history=killed.records, operator_lost=lost, **LEVEL)
    driver.press("enter")
    assert now(driver) == ("attempt", level)
    assert each(driver.all(t.LEVEL_DECIDED), "id actor ground") == [("l1", "agent", "no operator")]


# --- marks


def test_a_mark_withdraws_a_pending_level_that_no_longer_follows() -> None:
    driver = lifted(**LEVEL)
    driver.operate("mark", reason="leaned")
    assert pending(driver) == ["l1"], "this mark changes no outcome"
    driver.operate("mark", reason="caught")
    assert pending(driver) == []
    decide(driver, "l1", "accept")
    assert now(driver) == ("attempt", 1)
    driver.operate("mark", reason="caught")
    assert pending(driver) == ["l2"], "the mark was removed"
    decide(driver, "l2", "accept")
    assert driver.waiting.level == 2


@pytest.mark.parametrize(
    ("how", "level"),
    [({"verdict": "veto"}, 1), ({"verdict": "accept"}, 2), ({"verdict": "edit", "level": 4}, 4)],
)
def test_a_mark_that_changes_no_outcome_keeps_the_operators_level(
    how: dict[str, Any], level: int
) -> None:
    driver = lifted(**LEVEL)
    decide(driver, "l1", **how)
    driver.operate("mark", reason="leaned")
    assert (*now(driver), pending(driver)) == ("attempt", level, [])
    driver.press("enter")
    driver.wait(300)
    assert driver.waiting.level == level
    driver.lift()
    driver.lift()
    assert pending(driver, "level") == [level + 1], "the next step is from there"


def test_pending_feedback_is_replaced_when_the_attempt_is_scored_again() -> None:
    driver = lifted(**FEEDBACK)
    driver.operate("mark", reason="caught")
    assert driver.waiting.stage == "answer"
    decide_feedback(driver, "accept")
    assert each(feedback(driver), "valence") == ["negative"]
    assert driver.last(t.ATTEMPT_ENDED).feedback == "negative"


# --- two seats


class Couple(Lift):
    """One participant lifts for two seats; B gets a time of its own."""

    seats = ("A", "B")
    b_ms = 400.0

    def seat_of(self, key: str) -> str:
        return "A"

    def perceived(self, trial: Trial, percept: Any) -> Any:
        result = super().perceived(trial, percept)
        if not isinstance(result, Result):
            return result
        return {"A": result, "B": msgspec.structs.replace(result, value=self.b_ms)}


class UnevenCouple(Couple):
    """B never reaches the goal."""

    b_ms = 5000.0


def test_with_two_seats_feedback_is_given_in_turn_with_gaze_to_each() -> None:
    driver = lifted(Couple)
    in_turn = [("A", False, "interrupt", "left"), ("B", True, "queue", "right")]
    assert each(feedback(driver), "seat joins policy gaze") == in_turn
    assert [one.gaze for one in driver.all(t.ACTION) if one.kind == "greeting"] == ["ahead"]


@pytest.mark.parametrize("order", ["AB", "BA"])
def test_with_two_seats_the_feedback_that_is_decided_on_second_joins_the_first(order: str) -> None:
    driver = lifted(Couple, filler="operator", **FEEDBACK)
    waits = dict(pending(driver, "proposal.seat proposal.id"))
    for seat in order:
        decide(driver, waits[seat], "accept")
    assert each(feedback(driver), "seat joins") == [(order[0], False), (order[1], True)]


def test_with_two_seats_a_level_stays_pending_if_a_mark_changes_one_outcome_only() -> None:
    driver = lifted(UnevenCouple, start_level=3, **LEVEL)
    driver.operate("mark", reason="caught")
    assert each(driver.all(t.ATTEMPT_ENDED)[-2:], "outcome") == ["failure"] * 2
    assert pending(driver) == ["l1"]
    decide(driver, "l1", "accept")
    assert driver.waiting.level == 2


def test_with_two_seats_only_unsaid_feedback_is_replaced() -> None:
    driver = lifted(Couple, **FEEDBACK)
    decide(driver, pending(driver)[0], "accept")
    driver.operate("mark", reason="caught")
    assert pending(driver, "seat proposal.valence") == [("B", "negative")]
    given = {"A": "positive", "B": "negative"}
    assert {one.seat: one.feedback for one in driver.all(t.ATTEMPT_ENDED)} == given
    decide(driver, pending(driver)[0], "accept")
    assert each(feedback(driver), "seat valence") == list(given.items())


# --- with and without an operator


def hurried(kind: str, mode: str, **settings: Any) -> list[tuple[str, str, str]]:
    """Play three failed attempts and a success, pressing Enter all the time; return what the agent
    said and did.

    Nobody decides in time.
    """
    modes = {"operator_feedback": mode, f"operator_{kind}": mode, "encouragement": True}
    speech = OutputNode(Speaker(1500), "speech", CALM)
    driver = keys(extra=[speech], **{**modes, "attempts": 4, "rest_every": 3, **settings})
    join(driver)
    for attempt in range(4):
        while driver.screen.waiting is None or driver.screen.waiting.stage != "trial":
            driver.press("enter")
            driver.wait(300)
        for _ in range(2):
            driver.answer(400 if attempt == 3 else 4000)
    while not driver.session.ended:
        driver.press("enter")
        driver.wait(300)
    driver.wait(60_000)
    said = each(driver.all(t.ACTION), "kind text gesture")
    return [one for one in said if one[0] != "instruction"]


@pytest.mark.parametrize("delay_ms", [0, 3000])
@pytest.mark.parametrize("kind", ["encouragement", "difficulty", "instruction"])
@pytest.mark.parametrize("mode", ["veto", "approve"])
def test_a_hurried_participant_hears_the_same_in_every_mode(
    mode: str, kind: str, delay_ms: int
) -> None:
    said = hurried(kind, "autonomous", feedback_delay_ms=delay_ms)
    all_kinds = {"greeting", "feedback", "encouragement", "rest", "goodbye"}
    assert all_kinds <= {name for name, _, _ in said}
    assert hurried(kind, mode, feedback_delay_ms=delay_ms) == said


def test_a_hurried_participant_sees_the_same_gestures_in_every_mode() -> None:
    alone = [gesture for _, _, gesture in hurried("gesture", "autonomous") if gesture]
    assert alone
    assert [gesture for _, _, gesture in hurried("gesture", "veto") if gesture] == alone


@pytest.mark.parametrize(("verdict", "encouraged"), [("accept", 1), ("veto", 0)])
def test_encouragement_follows_the_level_that_the_operator_decides_on(
    verdict: str, encouraged: int
) -> None:
    driver = operated(encouragement=True, **LEVEL)
    decide(driver, "l1", verdict)
    assert kinds(driver).count("encouragement") == encouraged


def test_an_operator_who_accepts_everything_is_not_noticed_by_the_participant() -> None:
    """Only the timing differs, and not even that with a fixed delay."""
    by_operator = {"decided": 0, "mode": "manual", "ground": "mode", "actor": ""}
    timing = {"feedback_delay_ms": 2000, "operator_time_ms": 2000, "operator_ms_per_word": 0}
    sessions = []
    for mode in ("autonomous", "veto", "approve"):
        controlled = ("feedback", "encouragement", "difficulty")
        driver = operated(**timing, **{f"operator_{kind}": mode for kind in controlled})
        driver.wait(5000)
        driver.attempt()
        driver.wait(5000)
        acts = [one for one in driver.records if one.topic is t.ACTION]
        said = [(one.at, msgspec.structs.replace(one.message, **by_operator)) for one in acts]
        seen = [(one.at, one.message) for one in driver.records if one.topic is t.WAITING]
        sessions.append((said, seen[-1]))
    assert sessions[0] == sessions[1] == sessions[2]


def test_with_a_fixed_delay_encouragement_of_the_agent_alone_comes_at_the_same_moment() -> None:
    times = []
    for mode in ("autonomous", "veto", "approve"):
        driver = operated(encouragement=True, feedback_delay_ms=3000, operator_feedback=mode)
        driver.wait(5000)
        acts = [record for record in driver.records if record.topic is t.ACTION]
        times.append(each(acts, "at message.id"))
    assert times[0] == times[1] == times[2]
    assert driver.last(t.ACTION).kind == "encouragement"


def test_ending_a_session_after_its_last_attempt_completes_it() -> None:
    driver, early = operated(), operated()
    for _ in range(2):
        driver.attempt()
    driver.operate("pause")
    for one in (driver, early):
        one.operate("end")
    assert driver.last(t.SESSION_ENDED).status == "completed"
    assert early.last(t.SESSION_ENDED).status == "aborted"
