"""A session uses the goal and the level of its difficulty policy for all that depends on them, and
says why.
"""

from typing import Any

import pytest

from sar_tui.app.screens.waiting_text import waiting_text
from sar_tui.loop.topics import ATTEMPT_ENDED, DECISION, FEEDBACK, GOAL, LEVEL, MODE, PRESENCE
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from tests.facts import each
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver

PERCENTILE = {"difficulty_policy": "percentile", "percentile_rank": 2, "percentile_results": 3}


def keyboard(calm: Theme, **settings: Any) -> LoopDriver:
    return LoopDriver(
        Catalogue().task("keyboard"), calm, **{"attempts": 6, "prompts_per_attempt": 2, **settings}
    )


def enter_and_do(driver: LoopDriver, *reaction_ms: float, wrong: int = 0) -> None:
    for reaction in reaction_ms:
        driver.attempt(reaction, wrong=wrong)


def goals(driver: LoopDriver) -> list[float | None]:
    return [ended.goal for ended in driver.all(ATTEMPT_ENDED)]


# --- a goal that moves


def test_the_goal_follows_the_results_and_decides_on_success_and_feedback(calm: Theme) -> None:
    driver = keyboard(calm, **PERCENTILE)
    driver.enter()
    enter_and_do(driver, 800, 700, 650, 900, 720)
    ended = driver.all(ATTEMPT_ENDED)
    assert goals(driver) == [1000, 800, 800, 700, 700], (
        "number 1 of 1, 2 of 2, and then 2 of the last 3 results"
    )
    assert each(ended, "outcome") == ["success", "success", "success", "failure", "failure"]
    assert [each.goal for each in driver.all(FEEDBACK)] == goals(driver)
    assert [each.valence for each in driver.all(FEEDBACK)][3:] == ["negative", "negative"]
    assert {each.level for each in ended} == {1}
    assert driver.all(LEVEL) == []


def test_the_participant_reads_the_goal_and_why_it_moved(calm: Theme) -> None:
    driver = keyboard(calm, **PERCENTILE)
    driver.enter()
    assert "less than 1 second on average" in driver.waiting.goal
    assert driver.waiting.why == ""
    driver.attempt(800)
    assert "less than 0.8 seconds on average" in driver.waiting.goal
    shown = waiting_text(driver.waiting, driver.session.task)
    assert shown is not None
    assert shown.text.startswith("The goal follows what you have just done.\n\nYour goal: ")


def test_each_change_of_the_goal_is_a_message_with_its_reason(calm: Theme) -> None:
    driver = keyboard(calm, **PERCENTILE)
    driver.enter()
    enter_and_do(driver, 800, 600, 700)
    first, last = driver.all(GOAL)
    assert (first.previous, first.goal, first.unit, first.reason) == (1000, 800, "ms", "percentile")
    assert first.why == "The goal is the last result at this level."
    assert (last.previous, last.goal) == (800, 700)
    assert last.why == "The goal is number 2 of the last 3 results at this level."


def test_an_attempt_with_too_few_right_responses_makes_no_goal(calm: Theme) -> None:
    driver = keyboard(calm, **PERCENTILE)
    driver.enter()
    enter_and_do(driver, 500, wrong=2)
    enter_and_do(driver, 500)
    assert goals(driver) == [1000, 1000]


def test_practice_makes_no_goal(calm: Theme) -> None:
    driver = keyboard(calm, practice_attempts=1, **PERCENTILE)
    driver.enter()
    enter_and_do(driver, 500, 600, 600)
    assert goals(driver) == [1000, 1000, 600]


def test_each_level_has_a_goal_from_its_own_results(calm: Theme) -> None:
    driver = keyboard(calm, **PERCENTILE)
    driver.enter()
    driver.attempt(800)
    driver.operate("level", value=3)
    assert "1 second" in driver.waiting.goal
    assert driver.last(GOAL).why == "There is no result at this level yet."
    driver.attempt(900)
    driver.operate("level", value=1)
    assert "0.8 seconds" in driver.waiting.goal
    driver.attempt(700)
    assert goals(driver) == [1000, 1000, 800]


def test_an_attempt_under_way_keeps_its_goal_when_the_level_is_set(calm: Theme) -> None:
    driver = keyboard(calm, difficulty_policy="percentile", percentile_rank=1, percentile_results=1)
    driver.enter()
    driver.attempt(800)
    driver.begin_attempt()
    driver.operate("level", value=3)
    driver.answer(700)
    driver.answer(700)
    driver.wait(1000)
    assert goals(driver) == [1000, 800]
    driver.operate("level", value=1)
    assert "0.7 seconds" in driver.waiting.goal, "its result counts at its own level"


def test_a_goal_of_a_task_with_goals_by_level_is_the_persons_own(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, attempts=4, start_level=3, lifts=1, **PERCENTILE)
    driver.begin_lifts()
    for time_ms in (900, 800):
        driver.lift(time_ms)
        driver.wait(500)
        driver.press("enter")
        driver.wait(300)
    assert goals(driver) == [1200, 900]


def test_a_mark_that_takes_a_lift_away_takes_its_goal_away(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, attempts=4, lifts=1, **PERCENTILE)
    driver.begin_lifts()
    driver.lift(600)
    driver.wait(500)
    assert driver.last(GOAL).goal == 600
    driver.operate("mark", reason="caught")
    assert (driver.last(GOAL).previous, driver.last(GOAL).goal) == (600, 1000)


# --- replay and resume


@pytest.mark.parametrize(
    "settings", [PERCENTILE, {"difficulty_policy": "target"}], ids=["percentile", "target"]
)
def test_a_session_is_resumed_with_the_goal_and_the_level_that_it_had(
    calm: Theme, settings: dict[str, Any]
) -> None:
    straight, killed = keyboard(calm, **settings), keyboard(calm, **settings)
    for driver in (straight, killed):
        driver.enter()
        enter_and_do(driver, 800, 700, 900)
    resumed = LoopDriver(
        Catalogue().task("keyboard"),
        calm,
        attempts=6,
        prompts_per_attempt=2,
        history=killed.records,
        **settings,
    )
    resumed.enter()
    for driver in (straight, resumed):
        enter_and_do(driver, 650, 720)
    assert goals(resumed) == goals(straight)[3:]
    assert (
        each(resumed.all(ATTEMPT_ENDED), "level") == each(straight.all(ATTEMPT_ENDED), "level")[3:]
    )


# --- a level that moves


def test_a_target_moves_the_level_by_the_share_of_prompts_and_says_why(calm: Theme) -> None:
    driver = keyboard(calm, difficulty_policy="target", prompts_per_attempt=10)
    driver.enter()
    driver.attempt(400)
    change = driver.last(LEVEL)
    assert (change.previous, change.level, change.reason) == (1, 3, "target")
    assert change.why == "10 of 10 prompts reached the goal; the target is 70 %."
    assert driver.waiting.why == "That went well, so it gets a little harder."
    driver.attempt(400, wrong=10)
    assert driver.waiting.why == "It gets a little easier now."


def test_prompts_right_but_slower_than_the_goal_do_not_reach_it(calm: Theme) -> None:
    driver = keyboard(calm, difficulty_policy="target", start_level=3)
    driver.enter()
    driver.attempt(1200)
    assert driver.last(LEVEL).why == "0 of 2 prompts reached the goal; the target is 70 %."


def test_by_default_the_participant_is_told_nothing_more(calm: Theme) -> None:
    driver = keyboard(calm)
    driver.enter()
    driver.attempt(400)
    assert (driver.last(LEVEL).reason, driver.last(LEVEL).why) == ("success", "Goal reached.")
    assert driver.waiting.why == ""
    assert driver.all(GOAL) == []


def test_a_list_begins_with_its_first_level_in_practice_too(calm: Theme) -> None:
    settings = {
        "difficulty_policy": "sequence",
        "level_sequence": [2, 4, 4, 1],
        "practice_attempts": 1,
    }
    driver = keyboard(calm, **settings)
    driver.enter()
    enter_and_do(driver, 400, 400, 400, 400, 400)
    assert [each.level for each in driver.all(ATTEMPT_ENDED)] == [2, 2, 4, 4, 1]
    assert driver.waiting.why == ""


def test_a_step_that_an_operator_accepts_goes_on_from_its_own_place(calm: Theme) -> None:
    """An accepted change is as if nobody had been asked: the steps that follow are the same."""
    settings: dict[str, Any] = {
        "difficulty_policy": "target",
        "prompts_per_attempt": 10,
        "start_level": 5,
    }
    alone = keyboard(calm, **settings)
    asked = keyboard(calm, operator_difficulty="approve", operator_time_ms=60_000, **settings)
    asked.session.bus.publish(
        PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True)
    )
    asked.session.bus.publish(
        MODE, m.ModeChanged(kind="difficulty", mode="approve", actor="operator.ana")
    )
    for driver in (alone, asked):
        driver.enter()
        for number, wrong in enumerate((0, 9, 0, 9), 1):
            driver.attempt(400, wrong=wrong)
            if driver is asked and driver.waiting.stage == "answer":
                accepted = m.Decision(action=f"l{number}", verdict="accept", actor="operator.ana")
                asked.session.bus.publish(DECISION, accepted)
    assert [each.level for each in alone.all(LEVEL)] == [each.level for each in asked.all(LEVEL)]
