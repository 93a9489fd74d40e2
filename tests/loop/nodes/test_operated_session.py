"""A session with an operator waits for decisions on feedback and level, up to the deadline."""

from typing import Any

import msgspec
import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result, Trial
from sar_tui.outputs.node import OutputNode
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import Speaker


def operated(theme: Theme, **settings: Any) -> LoopDriver:
    """Start a session with an operator, at the end of its first attempt."""
    driver = LoopDriver(
        Catalogue().task("keyboard"),
        theme,
        attempts=3,
        prompts_per_attempt=2,
        filler="never",
        **{"encouragement": False, **settings},
    )
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.enter()
    driver.attempt()
    return driver


def decide(driver: LoopDriver, action: str, verdict: Any, **how: Any) -> None:
    decision = m.Decision(
        action=action, verdict=verdict, actor="operator.ana", at=driver.clock.now(), **how
    )
    driver.session.bus.publish(t.DECISION, decision)


def feedback(driver: LoopDriver) -> list[m.Action]:
    return [action for action in driver.all(t.ACTION) if action.kind == "feedback"]


def pending_feedback(driver: LoopDriver) -> str:
    """Return the id of the pending feedback."""
    return [
        pending.proposal.id
        for pending in driver.all(t.PENDING_APPROVAL)
        if pending.proposal.kind == "feedback"
    ][-1]


def test_no_attempt_begins_while_feedback_is_decided_on(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="approve", operator_time_ms=20_000)
    assert (driver.waiting.what, driver.waiting.stage) == ("answer", "answer")
    driver.press("enter")
    assert driver.waiting.stage == "answer"
    decide(driver, pending_feedback(driver), "accept")
    assert facts(driver.waiting, "what stage attempt") == ("enter", "attempt", 2)
    assert len(feedback(driver)) == 1


def test_the_wait_ends_at_the_deadline(calm: Theme) -> None:
    driver = operated(
        calm, operator_feedback="approve", operator_time_ms=5000, operator_ms_per_word=0
    )
    driver.wait(4000)
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "attempt")
    assert [action.ground for action in feedback(driver)] == ["deadline"]


def test_manual_feedback_is_not_waited_for(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="manual")
    assert driver.waiting.stage == "attempt"
    driver.press("enter")
    assert each(driver.all(t.DROPPED), "reason actor") == [("manual", "agent")]
    driver.to_prompt()
    assert feedback(driver) == []


def test_a_remark_during_the_delay_does_not_change_the_wait(calm: Theme) -> None:
    driver = operated(
        calm, extra=[OutputNode(Speaker(1000), "speech", calm)], feedback_delay_ms=5000
    )
    known = len(driver.all(t.WAITING))
    driver.session.bus.publish(t.REMARK, m.Remark(text="Take your time.", actor="operator.ana"))
    driver.wait(3000)
    assert each(driver.all(t.ACTING)[-2:], "acting awaits_operator") == [
        (True, False),
        (False, False),
    ]
    assert len(driver.all(t.WAITING)) == known
    driver.wait(10_000)
    assert [waiting.stage for waiting in driver.all(t.WAITING)[known:]] == ["attempt"]


def test_after_a_pause_the_wait_for_a_decision_continues(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    driver.operate("pause")
    driver.operate("resume")
    assert driver.waiting.stage == "answer"


def test_feedback_decided_in_a_pause_is_given_after_it(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    driver.operate("pause")
    decide(driver, pending_feedback(driver), "accept")
    assert feedback(driver) == []
    driver.operate("resume")
    assert driver.waiting.stage == "attempt"
    assert len(feedback(driver)) == 1


def test_the_review_waits_for_the_decision_on_the_last_feedback(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    for _ in range(2):
        decide(driver, pending_feedback(driver), "veto")
        driver.attempt()
    driver.press("enter")
    assert driver.waiting.stage == "answer"
    decide(driver, pending_feedback(driver), "accept")
    assert driver.waiting.stage == "review"


def test_an_operator_of_an_earlier_run_decides_nothing_in_the_next(calm: Theme) -> None:
    settings = {"attempts": 3, "prompts_per_attempt": 2, "filler": "never", "encouragement": False}
    killed = operated(calm, operator_feedback="approve")
    decide(killed, pending_feedback(killed), "veto")
    driver = LoopDriver(
        Catalogue().task("keyboard"),
        calm,
        history=killed.records,
        operator_feedback="approve",
        **settings,
    )
    driver.enter()
    driver.attempt()
    assert each(feedback(driver), "actor ground") == [("agent", "no operator")]


# --- the level


def test_the_level_rises_when_the_operator_accepts(calm: Theme) -> None:
    driver = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    assert driver.waiting.stage == "answer"
    assert driver.all(t.LEVEL) == []
    decide(driver, "l1", "accept")
    assert each(driver.all(t.LEVEL), "previous level reason") == [(1, 2, "success")]
    assert (driver.waiting.stage, driver.waiting.level) == ("attempt", 2)


@pytest.mark.parametrize(
    ("how", "level"), [({"verdict": "veto"}, 1), ({"verdict": "edit", "level": 3}, 3)]
)
def test_an_operator_can_edit_the_level(calm: Theme, how: dict[str, Any], level: int) -> None:
    driver = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(driver, "l1", **how)
    assert driver.waiting.level == level
    assert [change.reason for change in driver.all(t.LEVEL)] == ["operator"] * (level != 1)
    driver.press("enter")
    assert driver.to_prompt().level == level


@pytest.mark.parametrize(("asked", "level"), [(99, 5), (0, 2)])
def test_an_edited_level_stays_within_its_bounds(calm: Theme, asked: int, level: int) -> None:
    settings = {"start_level": 3, "min_level": 2, "max_level": 5}
    driver = operated(calm, operator_difficulty="approve", operator_time_ms=60_000, **settings)
    decide(driver, "l1", "edit", level=asked)
    assert driver.waiting.level == level


def test_after_the_last_attempt_no_level_is_proposed(calm: Theme) -> None:
    driver = lifted(calm, attempts=1, operator_difficulty="approve", operator_time_ms=60_000)
    assert driver.waiting.stage == "review"
    assert pending_ids(driver) == []
    assert driver.all(t.LEVEL) == []


def test_a_level_that_was_refused_can_be_proposed_again(calm: Theme) -> None:
    driver = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(driver, "l1", "veto")
    driver.attempt()
    decide(driver, "l2", "accept")
    assert driver.waiting.level == 2


def test_a_manual_level_accepted_late_applies_to_the_next_attempt(calm: Theme) -> None:
    driver = operated(calm, operator_difficulty="manual")
    decide(driver, "l1", "accept")
    assert (driver.waiting.stage, driver.waiting.level) == ("attempt", 2)


def test_no_level_changes_once_the_session_is_being_ended(calm: Theme) -> None:
    driver = LoopDriver(
        Catalogue().task("keyboard"),
        calm,
        attempts=3,
        prompts_per_attempt=2,
        operator_difficulty="approve",
    )
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.start()
    driver.answer()
    driver.to_prompt()
    driver.screen.stores = False
    driver.answer()
    driver.operate("end")
    assert (driver.waiting.what, driver.waiting.stage) == ("storage", "ended")
    decide(driver, "l1", "accept")
    assert [decided.decision for decided in driver.all(t.LEVEL_DECIDED)] == ["accepted"]
    assert driver.all(t.LEVEL) == []


def test_a_level_held_by_hand_stays(calm: Theme) -> None:
    driver = operated(calm, operator_difficulty="manual")
    assert (driver.waiting.stage, driver.waiting.level) == ("attempt", 1)
    driver.attempt()
    assert driver.waiting.level == 1


def test_a_level_set_by_hand_overrides_a_pending_one(calm: Theme) -> None:
    driver = operated(calm, operator_difficulty="veto", operator_time_ms=5000)
    driver.session.bus.publish(
        t.COMMAND, m.SessionCommand(command="level", value=4, actor="operator.ana")
    )
    driver.wait(10_000)
    assert driver.waiting.level == 4


def test_a_mark_withdraws_a_pending_level_that_no_longer_follows(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, operator_difficulty="approve", operator_time_ms=60_000)
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.begin_lifts()
    driver.lift()
    driver.lift()
    assert [pending.proposal.id for pending in driver.last(t.ARBITER_STATE).pending] == ["l1"]
    driver.operate("mark", reason="caught")
    assert driver.last(t.ARBITER_STATE).pending == ()
    decide(driver, "l1", "accept")
    assert (driver.waiting.stage, driver.waiting.level) == ("attempt", 1)
    driver.operate("mark", reason="caught")
    assert each(driver.last(t.ARBITER_STATE).pending, "proposal.id") == ["l2"], (
        "the mark was removed"
    )
    decide(driver, "l2", "accept")
    assert driver.waiting.level == 2


@pytest.mark.parametrize(("lost", "level"), [("autonomous", 2), ("silent", 1)])
def test_a_pending_level_is_decided_without_an_operator_after_a_resume(
    calm: Theme, lost: str, level: int
) -> None:
    settings = {"operator_difficulty": "approve", "operator_time_ms": 60_000, "operator_lost": lost}
    killed = operated(calm, **settings)
    assert (killed.waiting.stage, killed.waiting.level) == ("answer", 1)
    driver = LoopDriver(
        Catalogue().task("keyboard"),
        calm,
        history=killed.records,
        attempts=3,
        prompts_per_attempt=2,
        filler="never",
        encouragement=False,
        **settings,
    )
    driver.press("enter")
    assert (driver.waiting.stage, driver.waiting.level) == ("attempt", level)
    assert each(driver.all(t.LEVEL_DECIDED), "id actor ground") == [("l1", "agent", "no operator")]


def lifted(calm: Theme, task: type[Task] = Lift, **settings: Any) -> LiftDriver:
    """Start a session with an operator and a therapist, at the end of its first attempt."""
    driver = LiftDriver(
        task, calm, **{"attempts": 3, "filler": "never", "encouragement": False, **settings}
    )
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.begin_lifts()
    driver.lift()
    driver.lift()
    return driver


def pending_ids(driver: LoopDriver) -> list[str]:
    return [pending.proposal.id for pending in driver.last(t.ARBITER_STATE).pending]


@pytest.mark.parametrize("attempts", [2, 3])
def test_a_level_that_follows_from_a_mark_is_pending_before_the_last_attempt_too(
    calm: Theme, attempts: int
) -> None:
    driver = lifted(calm, attempts=attempts, operator_difficulty="approve", operator_time_ms=60_000)
    decide(driver, "l1", "veto")
    driver.operate("mark", reason="caught")
    driver.operate("mark", reason="caught")
    assert driver.all(t.LEVEL) == []
    assert pending_ids(driver) == ["l2"]


@pytest.mark.parametrize(
    ("how", "level"),
    [({"verdict": "veto"}, 1), ({"verdict": "accept"}, 2), ({"verdict": "edit", "level": 4}, 4)],
)
def test_a_mark_that_changes_no_outcome_keeps_the_operators_level(
    calm: Theme, how: dict[str, Any], level: int
) -> None:
    driver = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(driver, "l1", **how)
    driver.operate("mark", reason="leaned")
    assert (driver.waiting.stage, driver.waiting.level, pending_ids(driver)) == (
        "attempt",
        level,
        [],
    )
    driver.press("enter")
    driver.wait(300)
    assert driver.waiting.level == level
    driver.lift()
    driver.lift()
    assert each(driver.last(t.ARBITER_STATE).pending, "level") == [level + 1], (
        "the next step is from there"
    )


def test_a_mark_that_changes_no_outcome_leaves_the_level_pending(calm: Theme) -> None:
    driver = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    driver.operate("mark", reason="leaned")
    assert pending_ids(driver) == ["l1"]


def test_a_mark_withdraws_a_pending_level_regardless_of_the_previous_outcome(calm: Theme) -> None:
    driver = LiftDriver(
        Lift,
        calm,
        attempts=3,
        filler="never",
        operator_difficulty="approve",
        operator_time_ms=60_000,
    )
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.begin_lifts()
    driver.lift(3000)
    driver.lift(3000)
    driver.press("enter")
    driver.wait(300)
    driver.lift()
    driver.lift()
    assert [one.outcome for one in driver.all(t.ATTEMPT_ENDED)] == ["failure", "success"]
    assert pending_ids(driver) == ["l1"]
    driver.operate("mark", reason="caught")
    assert pending_ids(driver) == []


def test_pending_feedback_is_replaced_when_the_attempt_is_scored_again(calm: Theme) -> None:
    driver = lifted(calm, operator_feedback="approve", operator_time_ms=60_000)
    driver.operate("mark", reason="caught")
    assert driver.waiting.stage == "answer"
    decide(driver, pending_feedback(driver), "accept")
    assert [action.valence for action in feedback(driver)] == ["negative"]
    assert driver.last(t.ATTEMPT_ENDED).feedback == "negative"


def test_given_feedback_is_not_repeated_while_the_level_is_pending(calm: Theme) -> None:
    driver = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    driver.operate("mark", reason="caught")
    decide(driver, "l1", "accept")
    assert [action.valence for action in feedback(driver)] == ["positive"]


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


def test_with_two_seats_the_session_waits_for_the_only_feedback(calm: Theme) -> None:
    bandwidth = {"feedback_schedule": "bandwidth", "feedback_tolerance": 70.0}
    driver = lifted(calm, UnevenCouple, feedback_delay_ms=5000, **bandwidth)
    assert [one.feedback for one in driver.all(t.ATTEMPT_ENDED)] == ["none", "negative"]
    assert driver.waiting.stage == "answer"
    driver.wait(5000)
    assert driver.waiting.stage == "attempt"
    assert each(feedback(driver), "seat joins policy") == [("B", False, "interrupt")]


def test_with_two_seats_feedback_is_given_in_turn_with_gaze_to_each(calm: Theme) -> None:
    driver = lifted(calm, Couple)
    assert each(feedback(driver), "seat joins policy gaze") == [
        ("A", False, "interrupt", "left"),
        ("B", True, "queue", "right"),
    ]
    assert [action.gaze for action in driver.all(t.ACTION) if action.kind == "greeting"] == [
        "ahead"
    ]


TWO_UNDECIDED = {"operator_feedback": "approve", "operator_time_ms": 60_000, "filler": "operator"}


def undecided_couple(calm: Theme) -> LiftDriver:
    """Bring two participants to the end of an attempt whose feedback an operator decides on."""
    driver = LiftDriver(Couple, calm, begin=False, attempts=3, encouragement=False, **TWO_UNDECIDED)
    driver.session.begin()
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    driver.begin_lifts()
    driver.lift()
    driver.lift()
    return driver


@pytest.mark.parametrize("order", ["AB", "BA"])
def test_with_two_seats_the_feedback_that_is_decided_on_second_joins_the_first(
    calm: Theme, order: str
) -> None:
    driver = undecided_couple(calm)
    waits = {
        pending.proposal.seat: pending.proposal.id
        for pending in driver.last(t.ARBITER_STATE).pending
    }
    for seat in order:
        decide(driver, waits[seat], "accept")
    assert each(feedback(driver), "seat joins") == [(order[0], False), (order[1], True)]


def test_with_two_seats_no_filler_replaces_the_feedback_that_was_given_first(calm: Theme) -> None:
    driver = undecided_couple(calm)
    decide(driver, pending_feedback(driver), "accept")
    driver.wait(5000)
    assert [action.kind for action in driver.all(t.ACTION)][-1] == "feedback"
    assert driver.waiting.stage == "answer"


def test_with_two_seats_a_level_stays_pending_if_a_mark_changes_one_outcome_only(
    calm: Theme,
) -> None:
    driver = lifted(
        calm, UnevenCouple, start_level=3, operator_difficulty="approve", operator_time_ms=60_000
    )
    driver.operate("mark", reason="caught")
    assert {one.outcome for one in driver.all(t.ATTEMPT_ENDED)[-2:]} == {"failure"}
    assert pending_ids(driver) == ["l1"]
    decide(driver, "l1", "accept")
    assert driver.waiting.level == 2


def test_with_two_seats_a_mark_that_changes_the_shared_outcome_proposes_one_level(
    calm: Theme,
) -> None:
    driver = lifted(
        calm, Couple, start_level=3, operator_difficulty="approve", operator_time_ms=60_000
    )
    levels = []
    for _ in range(3):
        (pending,) = driver.last(t.ARBITER_STATE).pending
        levels.append((pending.proposal.id, pending.level))
        driver.operate("mark", reason="caught")
    assert levels == [("l1", 4), ("l2", 2), ("l3", 4)]


def test_with_two_seats_only_unsaid_feedback_is_replaced(calm: Theme) -> None:
    driver = lifted(calm, Couple, operator_feedback="approve", operator_time_ms=60_000)
    decide(driver, pending_ids(driver)[0], "accept")
    driver.operate("mark", reason="caught")
    assert each(driver.last(t.ARBITER_STATE).pending, "seat proposal.valence") == [
        ("B", "negative")
    ]
    assert {one.seat: one.feedback for one in driver.all(t.ATTEMPT_ENDED)} == {
        "A": "positive",
        "B": "negative",
    }
    decide(driver, pending_ids(driver)[0], "accept")
    assert each(feedback(driver), "seat valence") == [("A", "positive"), ("B", "negative")]


def test_feedback_that_becomes_pending_in_a_pause_is_waited_for_after_it(calm: Theme) -> None:
    driver = operated(calm, operator_feedback="manual")
    driver.operate("pause")
    driver.session.bus.publish(
        t.MODE, m.ModeChanged(kind="feedback", mode="approve", actor="operator.ana")
    )
    driver.operate("resume")
    assert driver.waiting.stage == "answer"
    decide(driver, pending_feedback(driver), "accept")
    assert driver.waiting.stage == "attempt"
    assert len(feedback(driver)) == 1


# --- with and without an operator


def hurried(calm: Theme, kind: str, mode: str, **settings: Any) -> list[tuple[str, str, str]]:
    """Play three failed attempts and a success, pressing Enter all the time; return what the agent
    said and did.

    Nobody decides in time.
    """
    modes = {"operator_feedback": mode, f"operator_{kind}": mode}
    driver = LoopDriver(
        Catalogue().task("keyboard"),
        calm,
        extra=[OutputNode(Speaker(1500), "speech", calm)],
        attempts=4,
        prompts_per_attempt=2,
        filler="never",
        rest_every=3,
        **modes,
        **settings,
    )
    driver.session.bus.publish(
        t.PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
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
    return [
        (action.kind, action.text, action.gesture)
        for action in driver.all(t.ACTION)
        if action.kind != "instruction"
    ]


@pytest.mark.parametrize("delay_ms", [0, 3000])
@pytest.mark.parametrize("kind", ["encouragement", "difficulty", "instruction"])
@pytest.mark.parametrize("mode", ["veto", "approve"])
def test_a_hurried_participant_hears_the_same_in_every_mode(
    calm: Theme, mode: str, kind: str, delay_ms: int
) -> None:
    said = hurried(calm, kind, "autonomous", feedback_delay_ms=delay_ms)
    assert {"greeting", "feedback", "encouragement", "rest", "goodbye"} <= {
        name for name, _, _ in said
    }
    assert hurried(calm, kind, mode, feedback_delay_ms=delay_ms) == said


def test_a_hurried_participant_sees_the_same_gestures_in_every_mode(calm: Theme) -> None:
    alone = [gesture for _, _, gesture in hurried(calm, "gesture", "autonomous") if gesture]
    assert alone
    assert [gesture for _, _, gesture in hurried(calm, "gesture", "veto") if gesture] == alone


@pytest.mark.parametrize("mode", ["veto", "approve"])
def test_encouragement_is_said_before_the_next_attempt_begins(calm: Theme, mode: str) -> None:
    driver = operated(calm, encouragement=True, operator_encouragement=mode)
    assert (driver.waiting.stage, driver.waiting.attempt) == ("answer", 2)
    driver.press("enter")
    assert driver.waiting.stage == "answer"
    driver.wait(10_000)
    assert [action.kind for action in driver.all(t.ACTION)][-1] == "encouragement"
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 2)
    assert driver.all(t.DROPPED) == []


@pytest.mark.parametrize(("verdict", "encouraged"), [("accept", 1), ("veto", 0)])
def test_encouragement_follows_the_level_that_the_operator_decides_on(
    calm: Theme, verdict: str, encouraged: int
) -> None:
    driver = operated(
        calm, encouragement=True, operator_difficulty="approve", operator_time_ms=60_000
    )
    decide(driver, "l1", verdict)
    assert [action.kind for action in driver.all(t.ACTION)].count("encouragement") == encouraged


def test_an_operator_who_accepts_everything_is_not_noticed_by_the_participant(calm: Theme) -> None:
    """Only the timing differs, and not even that with a fixed delay."""
    sessions = []
    for mode in ("autonomous", "veto", "approve"):
        settings = dict.fromkeys(
            (f"operator_{kind}" for kind in ("feedback", "encouragement", "difficulty")), mode
        )
        driver = operated(
            calm, feedback_delay_ms=2000, operator_time_ms=2000, operator_ms_per_word=0, **settings
        )
        driver.wait(5000)
        driver.attempt()
        driver.wait(5000)
        utterances = [
            (
                record.at,
                msgspec.structs.replace(
                    record.message, decided=0, mode="manual", ground="mode", actor=""
                ),
            )
            for record in driver.records
            if record.topic is t.ACTION
        ]
        seen = [
            (record.at, record.message) for record in driver.records if record.topic is t.WAITING
        ]
        sessions.append((utterances, seen[-1]))
    assert sessions[0] == sessions[1] == sessions[2]


@pytest.mark.parametrize("mode", ["veto", "approve"])
def test_with_a_fixed_delay_encouragement_of_the_agent_alone_comes_at_the_same_moment(
    calm: Theme, mode: str
) -> None:
    times = []
    for feedback_mode in ("autonomous", mode):
        driver = operated(
            calm, encouragement=True, feedback_delay_ms=3000, operator_feedback=feedback_mode
        )
        driver.wait(5000)
        times.append(
            [
                (record.at, record.message.id)
                for record in driver.records
                if record.topic is t.ACTION
            ]
        )
    assert times[0] == times[1]
    assert driver.last(t.ACTION).kind == "encouragement"


@pytest.mark.parametrize("pauses", [False, True])
def test_ending_a_session_after_its_last_attempt_completes_it(calm: Theme, pauses: bool) -> None:
    driver = operated(calm)
    for _ in range(2):
        driver.attempt()
    if pauses:
        driver.operate("pause")
    driver.operate("end")
    assert driver.last(t.SESSION_ENDED).status == "completed"
    early = operated(calm)
    early.operate("end")
    assert early.last(t.SESSION_ENDED).status == "aborted"
