"""A therapist's mark corrects the trial, its attempt and the level."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.marks import TrialMark
from sar_tui.loop.session import Session
from sar_tui.loop.topics import ACTION, ATTEMPT_ENDED, FEEDBACK, LEVEL, MARKED, TRIAL
from sar_tui.model.theme import Theme
from tests.facts import facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver

NewSession = Callable[..., LiftDriver]


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session, ready for the first lift; by default three attempts of two lifts each."""

    def start(**settings: Any) -> LiftDriver:
        driver = LiftDriver(Lift, calm, **{"attempts": 3, "start_level": 3, **settings})
        driver.begin_lifts()
        return driver

    return start


def mark(driver: LoopDriver, name: str) -> None:
    driver.operate("mark", reason=name)


def marked(driver: LoopDriver) -> list[tuple[int, int, str, bool]]:
    return [(m.attempt, m.trial, m.mark, m.correct) for m in driver.all(MARKED)]


def test_the_last_trials_mark_is_known_in_the_next_trial_and_after_a_resume(
    new_session: NewSession, calm: Theme
) -> None:
    driver = new_session()
    driver.lift(400)
    mark(driver, "caught")
    driver.press("space")
    driver.to_prompt()
    assert driver.session.trial_mark == TrialMark(
        done=(1, 1), open=(1, 2), marks={(1, 1): "caught", (1, 2): ""}
    )
    resumed = LiftDriver(Lift, calm, attempts=3, start_level=3, history=driver.records)
    assert facts(resumed.session.trial_mark, "trial present") == ((1, 1), "caught")


# --- the open trial


def test_a_mark_in_a_trial_is_stored_and_the_trial_does_not_count(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "caught")
    assert driver.all(TRIAL) == [], "a mark ends nothing"
    driver.press("k")
    driver.wait(400)
    driver.press("u")
    trial = driver.last(TRIAL)
    assert (trial.response, trial.correct, trial.value) == ("lift", False, None)
    assert trial.details == {"sway": 4.0, "grip": 50.0, "mark": "caught"}
    assert marked(driver) == [(1, 1, "caught", False)], (
        "the mark took effect at once, with no second message"
    )
    driver.wait(300)
    driver.lift(500)
    ended = driver.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.correct, ended.accuracy, ended.qualities["sway"]) == (
        500.0,
        1,
        0.5,
        5.0,
    )


def test_a_counting_mark_leaves_the_trial_correct(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "leaned")
    driver.press("k")
    driver.wait(400)
    driver.press("u")
    trial = driver.last(TRIAL)
    assert (trial.correct, trial.value, trial.details["mark"]) == (True, 400.0, "leaned")


def test_a_counting_mark_does_not_make_a_failed_trial_correct(new_session: NewSession) -> None:
    driver = new_session()
    driver.lift(end="d")
    mark(driver, "leaned")
    assert marked(driver) == [(1, 1, "leaned", False)]


def test_the_last_of_two_marks_in_a_trial_counts(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "caught")
    mark(driver, "leaned")
    driver.press("k")
    driver.wait(400)
    driver.press("u")
    assert (driver.last(TRIAL).correct, driver.last(TRIAL).details["mark"]) == (True, "leaned")


@pytest.mark.parametrize("broken_off", ["?", "pause"])
def test_a_mark_on_a_voided_trial_is_not_on_its_repetition(
    new_session: NewSession, broken_off: str
) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "caught")
    if broken_off == "pause":
        driver.operate("pause")
        driver.wait(1000)
        driver.operate("resume")
    else:
        driver.press("?")
        driver.wait(1000)
    driver.lift()
    assert (driver.last(TRIAL).correct, "mark" in driver.last(TRIAL).details) == (True, False)


# --- the last trial


def test_between_trials_the_last_one_is_marked(new_session: NewSession) -> None:
    driver = new_session()
    driver.lift(400)
    assert driver.waiting.what == "start"
    mark(driver, "caught")
    assert marked(driver) == [(1, 1, "caught", False)]
    assert driver.all(ATTEMPT_ENDED) == []
    driver.lift(600)
    ended = driver.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.correct, ended.outcome) == (600.0, 1, "failure")
    assert driver.last(FEEDBACK).reason == "accuracy"


def test_before_the_first_trial_of_a_session_there_is_nothing_to_mark(
    new_session: NewSession,
) -> None:
    driver = new_session()
    mark(driver, "caught")
    assert marked(driver) == []
    driver.lift()
    assert "mark" not in driver.last(TRIAL).details


def test_a_mark_after_an_attempt_corrects_its_score_and_the_level(new_session: NewSession) -> None:
    driver = new_session()
    driver.lift(400)
    driver.lift(500)
    before = driver.last(ATTEMPT_ENDED)
    assert (before.metric, before.outcome, before.feedback, driver.waiting.level) == (
        450.0,
        "success",
        "positive",
        4,
    )
    said = len(driver.all(ACTION))
    mark(driver, "caught")
    assert marked(driver) == [(1, 2, "caught", False)]
    again = driver.last(ATTEMPT_ENDED)
    assert facts(again, "attempt level metric correct outcome") == (1, 3, 400.0, 1, "failure")
    assert (again.started, again.ended, again.goal) == (before.started, before.ended, before.goal)
    assert again.feedback == "positive", "the feedback that was given stands"
    assert facts(driver.last(LEVEL), "previous level reason") == (4, 2, "mark")
    assert (driver.waiting.stage, driver.waiting.attempt, driver.waiting.level) == ("attempt", 2, 2)
    assert driver.waiting.goal == "Your goal: less than 1.1 seconds, with at least 80% right."
    assert len(driver.all(ACTION)) == said, "no further feedback is given"


def test_another_mark_replaces_the_first(new_session: NewSession) -> None:
    driver = new_session()
    driver.lift(400)
    driver.lift(500)
    original = driver.last(ATTEMPT_ENDED)
    mark(driver, "caught")
    mark(driver, "leaned")
    assert marked(driver) == [(1, 2, "caught", False), (1, 2, "leaned", True)]
    assert driver.last(ATTEMPT_ENDED) == original
    assert driver.waiting.level == 4


def test_a_counting_mark_changes_neither_score_nor_level(new_session: NewSession) -> None:
    driver = new_session()
    driver.lift(400)
    driver.lift(500)
    levels = len(driver.all(LEVEL))
    mark(driver, "leaned")
    first, again = driver.all(ATTEMPT_ENDED)
    assert first == again
    assert len(driver.all(LEVEL)) == levels


def test_the_last_trial_of_the_last_attempt_can_be_marked(new_session: NewSession) -> None:
    driver = new_session(attempts=1)
    driver.lift(400)
    driver.lift(500)
    assert driver.waiting.stage == "review"
    mark(driver, "caught")
    assert marked(driver) == [(1, 2, "caught", False)]
    again = driver.last(ATTEMPT_ENDED)
    assert facts(again, "metric correct outcome feedback") == (400.0, 1, "failure", "positive")
    assert driver.waiting.stage == "review"
    mark(driver, "leaned")
    assert driver.last(ATTEMPT_ENDED) == driver.all(ATTEMPT_ENDED)[0]


def test_a_mark_may_lead_to_the_same_level(new_session: NewSession) -> None:
    """The level falls after two consecutive failures: the mark makes the first, the next attempt is
    the second.
    """
    driver = new_session(consecutive_successes=2, consecutive_failures=2)
    driver.lift(400)
    driver.lift(500)
    mark(driver, "caught")
    assert driver.all(LEVEL) == []
    assert driver.waiting.level == 3
    driver.press("enter")
    driver.wait(300)
    driver.lift(end="d")
    driver.lift(end="d")
    assert (driver.last(LEVEL).level, driver.last(LEVEL).reason) == (2, "failure")


def test_after_the_next_attempt_has_begun_the_last_cannot_be_marked(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.lift()
    driver.lift()
    driver.press("enter")
    driver.wait(300)
    mark(driver, "caught")
    assert marked(driver) == []
    assert len(driver.all(ATTEMPT_ENDED)) == 1


@pytest.mark.parametrize("attempts", [1, 3])
def test_a_level_set_by_hand_is_not_undone_by_a_mark(
    new_session: NewSession, attempts: int
) -> None:
    driver = new_session(attempts=attempts)
    driver.lift()
    driver.lift()
    driver.operate("level", value=7)
    ended = len(driver.all(ATTEMPT_ENDED))
    mark(driver, "caught")
    assert (marked(driver), len(driver.all(ATTEMPT_ENDED)), driver.last(LEVEL).level) == (
        [],
        ended,
        7,
    )


def test_a_mark_in_practice_does_not_change_the_level(new_session: NewSession) -> None:
    driver = new_session(practice_attempts=1)
    driver.lift()
    driver.lift()
    mark(driver, "caught")
    again = driver.last(ATTEMPT_ENDED)
    assert (again.practice, again.outcome, driver.waiting.level) == (True, "failure", 3)
    assert driver.all(LEVEL) == []


@pytest.mark.parametrize("name", ["", "dropped", "f7"])
def test_an_unknown_mark_is_ignored(new_session: NewSession, name: str) -> None:
    driver = new_session()
    driver.lift()
    mark(driver, name)
    assert marked(driver) == []
    assert driver.session.faults == []


def test_a_session_with_marks_can_be_replayed(new_session: NewSession, calm: Theme) -> None:
    driver = new_session(attempts=1)
    driver.press("space")
    driver.to_prompt()
    mark(driver, "leaned")
    driver.press("k")
    driver.wait(300)
    driver.press("u")
    mark(driver, "caught")
    driver.wait(700)
    driver.lift()
    mark(driver, "caught")
    driver.press("enter")
    again = Session(driver.session.task, calm, driver.clock, 1)
    derived: list[Any] = []
    again.bus.tap(derived.extend)
    again.replay(driver.records)
    assert derived == driver.records
    assert marked(driver) == [
        (1, 1, "leaned", True),
        (1, 1, "caught", False),
        (1, 2, "caught", False),
    ]


def test_the_same_mark_again_removes_it(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    for _ in range(2):
        mark(driver, "caught")
    driver.press("k")
    driver.wait(300)
    driver.press("u")
    (lift,) = driver.all(TRIAL)
    assert (lift.correct, lift.details.get("mark")) == (True, None)
    for _ in range(2):
        mark(driver, "caught")
    assert marked(driver)[-2:] == [(1, 1, "caught", False), (1, 1, "", True)]


def test_voiding_a_trial_removes_its_mark(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "caught")
    driver.operate("pause")
    driver.operate("resume")
    driver.wait(700)
    driver.lift()
    (lift,) = driver.all(TRIAL)
    assert (lift.correct, lift.details.get("mark")) == (True, None)
    assert marked(driver)[-1] == (1, 1, "", True)
