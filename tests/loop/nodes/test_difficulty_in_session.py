"""A session uses the goal and the level of its difficulty policy for all that depends on them, and
says why.
"""

from typing import Any

import pytest

from sar_tui.loop.topics import ATTEMPT_ENDED, DECISION, FEEDBACK, GOAL, LEVEL, MODE, PRESENCE
from sar_tui.model import messages as m
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import lifting
from tests.loop_driver import LoopDriver

CATALOGUE = Catalogue()
PERCENTILE = {"difficulty_policy": "percentile", "percentile_rank": 2, "percentile_results": 3}
TARGET = {"difficulty_policy": "target"}
ANA = "operator.ana"


def done(*reaction_ms: float, wrong: int = 0, **settings: Any) -> LoopDriver:
    """Start a session, leave its instructions, and do attempts with these reaction times."""
    some = {"attempts": 6, "prompts_per_attempt": 2, **settings}
    driver = LoopDriver(CATALOGUE.task("keyboard"), CATALOGUE.theme("calm"), **some)
    driver.enter()
    for reaction in reaction_ms:
        driver.attempt(reaction, wrong=wrong)
    return driver


def goals(driver: LoopDriver) -> list[float | None]:
    return each(driver.all(ATTEMPT_ENDED), "goal")


# --- a goal that moves


def test_the_goal_follows_the_results_and_decides_on_success_and_feedback() -> None:
    driver = done(800, 700, 650, 900, 720, **PERCENTILE)
    ended = driver.all(ATTEMPT_ENDED)
    own = [1000, 800, 800, 700, 700]
    assert goals(driver) == own, "number 1 of 1, 2 of 2, and then 2 of the last 3 results"
    assert each(ended, "outcome") == ["success"] * 3 + ["failure"] * 2
    assert each(driver.all(FEEDBACK), "goal") == own
    assert each(driver.all(FEEDBACK), "valence")[3:] == ["negative", "negative"]
    assert {*each(ended, "level")} == {1}
    assert driver.all(LEVEL) == []


def test_each_change_of_the_goal_is_a_message_with_its_reason_and_is_shown() -> None:
    driver = done(**PERCENTILE)
    assert "less than 1 second on average" in driver.waiting.goal
    assert driver.waiting.why == ""
    driver.attempt(800)
    assert "less than 0.8 seconds on average" in driver.waiting.goal
    assert driver.waiting.why
    driver.attempt(600)
    driver.attempt(700)
    first, last = driver.all(GOAL)
    assert facts(first, "previous goal unit reason") == (1000, 800, "ms", "percentile")
    assert first.why == "The goal is the last result at this level."
    assert facts(last, "previous goal") == (800, 700)
    assert last.why == "The goal is number 2 of the last 3 results at this level."


def test_each_level_has_a_goal_from_its_own_results() -> None:
    driver = done(800, **PERCENTILE)
    driver.operate("level", value=3)
    assert "1 second" in driver.waiting.goal
    assert driver.last(GOAL).why == "There is no result at this level yet."
    driver.attempt(900)
    driver.operate("level", value=1)
    assert "0.8 seconds" in driver.waiting.goal
    driver.attempt(700)
    assert goals(driver) == [1000, 1000, 800]


def test_a_goal_of_a_task_with_goals_by_level_is_the_persons_own() -> None:
    driver = lifting(attempts=4, start_level=3, lifts=1, **PERCENTILE)
    for time_ms in (900, 800):
        driver.lift(time_ms)
        driver.wait(500)
        driver.press("enter")
        driver.wait(300)
    assert goals(driver) == [1200, 900]


def test_a_mark_that_takes_a_lift_away_takes_its_goal_away() -> None:
    driver = lifting(attempts=4, lifts=1, **PERCENTILE)
    driver.lift(600)
    driver.wait(500)
    assert driver.last(GOAL).goal == 600
    driver.operate("mark", reason="caught")
    assert facts(driver.last(GOAL), "previous goal") == (600, 1000)


@pytest.mark.parametrize("settings", [PERCENTILE, TARGET], ids=["percentile", "target"])
def test_a_session_is_resumed_with_the_goal_and_the_level_that_it_had(
    settings: dict[str, Any],
) -> None:
    straight = done(800, 700, 900, 650, 720, **settings)
    killed = done(800, 700, 900, **settings)
    resumed = done(650, 720, history=killed.records, **settings)
    same = "goal level"
    after = each(straight.all(ATTEMPT_ENDED), same)[3:]
    assert each(resumed.all(ATTEMPT_ENDED), same) == after


# --- a level that moves


def test_a_target_moves_the_level_by_the_share_of_prompts_and_says_why() -> None:
    driver = done(400, prompts_per_attempt=10, **TARGET)
    change = driver.last(LEVEL)
    assert facts(change, "previous level reason") == (1, 3, "target")
    assert change.why == "10 of 10 prompts reached the goal; the target is 70 %."
    assert "harder" in driver.waiting.why
    driver.attempt(400, wrong=10)
    assert "easier" in driver.waiting.why


def test_a_list_begins_with_its_first_level_in_practice_too() -> None:
    sequence = {"difficulty_policy": "sequence", "level_sequence": [2, 4, 4, 1]}
    driver = done(*[400] * 5, practice_attempts=1, **sequence)
    assert each(driver.all(ATTEMPT_ENDED), "level") == [2, 2, 4, 4, 1]
    assert driver.waiting.why == ""


def test_a_step_that_an_operator_accepts_goes_on_from_its_own_place() -> None:
    """An accepted change is as if nobody had been asked: the steps that follow are the same."""
    settings: dict[str, Any] = {"prompts_per_attempt": 10, "start_level": 5, **TARGET}
    alone = done(**settings)
    asked = done(operator_difficulty="approve", operator_time_ms=60_000, **settings)
    joined = m.OperatorChanged(actor=ANA, state="joined", operated=True)
    asked.session.bus.publish(PRESENCE, joined)
    mode = m.ModeChanged(kind="difficulty", mode="approve", actor=ANA)
    asked.session.bus.publish(MODE, mode)
    for number, wrong in enumerate((0, 9, 0, 9), 1):
        alone.attempt(400, wrong=wrong)
        asked.attempt(400, wrong=wrong)
        if asked.waiting.stage == "answer":
            accepted = m.Decision(action=f"l{number}", verdict="accept", actor=ANA)
            asked.session.bus.publish(DECISION, accepted)
    assert each(alone.all(LEVEL), "level") == each(asked.all(LEVEL), "level")
