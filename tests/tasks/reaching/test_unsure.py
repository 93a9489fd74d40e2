"""Reaches of which the detector is not sure are shown, and not scored until a therapist marks them."""

import pytest
from msgspec.structs import replace

from sar_tui.link.peer import Frame
from sar_tui.loop.topics import ATTEMPT_ENDED, FEEDBACK, LEVEL, MARKED, TRIAL
from sar_tui.model.messages import AttemptEnded, TrialEnded
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import responses
from tests.tasks.reaching.reaching_driver import REACH_OUT, ReachingDriver

SHORT_OF_HOME = replace(REACH_OUT, peak_back=-0.85)
"""The hand comes back by little more than half of the way, and stays there."""
NOT_CLEARLY = "I did not see that one clearly, so it does not count. That is all right."


@pytest.fixture
def driver() -> ReachingDriver:
    driver = ReachingDriver(start_level=2)
    driver.start_session()
    return driver


def last_attempt(driver: ReachingDriver) -> AttemptEnded:
    return driver.last(ATTEMPT_ENDED)


def confidence(trial: TrialEnded) -> float:
    found = trial.details["confidence"]
    assert isinstance(found, float)
    return found


def test_an_unsure_reach_is_stored_and_nothing_follows_from_it(driver: ReachingDriver) -> None:
    trial = driver.reach(SHORT_OF_HOME)
    driver.wait(3000)
    assert trial.is_unsure
    assert confidence(trial) < 0.6
    assert trial.details["reach_time_ms"] is not None
    ended = last_attempt(driver)
    assert (ended.outcome, ended.metric, ended.accuracy, ended.trials) == ("none", None, None, 1)
    assert not driver.all(FEEDBACK)
    assert not driver.all(LEVEL)
    assert driver.waiting.level == 2
    assert driver.waiting.why == NOT_CLEARLY


def test_a_mark_that_counts_lets_it_be_scored_and_the_same_again_takes_that_back(
    driver: ReachingDriver,
) -> None:
    driver.reach(SHORT_OF_HOME)
    driver.wait(3000)
    driver.operate("mark", "whole")
    driver.wait(100)
    marked = last_attempt(driver)
    assert marked.outcome == "success"
    assert marked.metric == pytest.approx(driver.last(TRIAL).details["reach_time_ms"])
    assert driver.last(LEVEL).level == 3
    assert driver.last(FEEDBACK).valence == "positive"
    assert driver.waiting.why != NOT_CLEARLY
    driver.operate("mark", "whole")
    driver.wait(100)
    assert last_attempt(driver).outcome == "none"
    assert driver.last(LEVEL).level == 2


def test_a_mark_that_does_not_count_lets_the_attempt_fail(driver: ReachingDriver) -> None:
    driver.reach(SHORT_OF_HOME)
    driver.wait(3000)
    driver.operate("mark", "missed")
    driver.wait(100)
    assert last_attempt(driver).outcome == "failure"
    assert last_attempt(driver).accuracy == 0


def test_it_is_left_out_of_the_mean_and_the_share_of_whole_reaches() -> None:
    driver = ReachingDriver(reaches_per_attempt=2, min_accuracy=1)
    driver.start_session()
    sure = driver.reach()
    driver.to_start()
    driver.wait(3000)
    assert driver.reach(SHORT_OF_HOME).is_unsure
    driver.wait(3000)
    ended = last_attempt(driver)
    assert ended.metric == pytest.approx(sure.value)
    assert (ended.accuracy, ended.correct, ended.trials) == (1, 1, 2)
    assert ended.outcome == "success"


def test_with_a_least_confidence_of_zero_every_reach_is_scored() -> None:
    driver = ReachingDriver(least_confidence=0)
    driver.start_session()
    trial = driver.reach(SHORT_OF_HOME)
    driver.wait(3000)
    assert confidence(trial) < 0.6
    assert not trial.is_unsure
    assert last_attempt(driver).outcome == "success"


def test_a_usual_reach_is_sure(driver: ReachingDriver) -> None:
    trial = driver.reach()
    assert not trial.is_unsure
    assert confidence(trial) > 0.9


def test_the_operator_sees_it_until_it_is_marked(driver: ReachingDriver) -> None:
    trial = driver.reach(SHORT_OF_HOME)
    driver.wait(3000)
    driver.operate("mark", "whole")
    driver.wait(100)
    state = SessionState().receive((Frame(1, 0, TRIAL, trial),))
    percent = round(100 * confidence(trial))
    assert (
        state.log[-1].text
        == f"Attempt 1, trial 1 is unsure ({percent} %): it is not scored without a mark."
    )
    assert responses(state.seat("A").trials, 40)[0][0].startswith("?")
    state = state.receive((Frame(2, 0, MARKED, driver.last(MARKED)),))
    assert responses(state.seat("A").trials, 40)[0][0].startswith("✓")
