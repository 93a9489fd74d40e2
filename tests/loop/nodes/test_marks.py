"""A therapist's mark corrects the trial, its attempt and the level."""

from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.marks import TrialMark
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver

CALM = Catalogue().theme("calm")


def session(**settings: Any) -> LiftDriver:
    """Start a session, ready for the first of, by default, two lifts in each of three attempts."""
    driver = LiftDriver(Lift, CALM, **{"attempts": 3, "start_level": 3, **settings})
    driver.begin_lifts()
    return driver


def lifted(*times_ms: float, **settings: Any) -> LiftDriver:
    driver = session(**settings)
    for time_ms in times_ms:
        driver.lift(time_ms)
    return driver


def lift_marked(driver: LiftDriver, *names: str, time_ms: float = 400) -> Any:
    """Mark a lift in the middle of it; return its trial."""
    driver.press("space")
    driver.to_prompt()
    for name in names:
        mark(driver, name)
    driver.press("k")
    driver.wait(time_ms)
    driver.press("u")
    return driver.last(t.TRIAL)


def mark(driver: LoopDriver, name: str) -> None:
    driver.operate("mark", reason=name)


def marked(driver: LoopDriver) -> list[tuple[int, int, str, bool]]:
    return each(driver.all(t.MARKED), "attempt trial mark correct")


def test_the_last_trials_mark_is_known_in_the_next_trial_and_after_a_resume() -> None:
    driver = lifted(400)
    mark(driver, "caught")
    driver.press("space")
    driver.to_prompt()
    known = TrialMark(done=(1, 1), open=(1, 2), marks={(1, 1): "caught", (1, 2): ""})
    assert driver.session.trial_mark == known
    resumed = LiftDriver(Lift, CALM, attempts=3, start_level=3, history=driver.records)
    assert facts(resumed.session.trial_mark, "trial present") == ((1, 1), "caught")


# --- the open trial


def test_a_mark_in_a_trial_is_stored_and_the_trial_does_not_count() -> None:
    driver = session()
    trial = lift_marked(driver, "caught")
    assert len(driver.all(t.TRIAL)) == 1, "a mark ends nothing"
    assert facts(trial, "response correct value") == ("lift", False, None)
    assert trial.details == {"sway": 4.0, "grip": 50.0, "mark": "caught"}
    assert marked(driver) == [(1, 1, "caught", False)], "it took effect at once"
    driver.wait(300)
    driver.lift(500)
    ended = driver.last(t.ATTEMPT_ENDED)
    assert facts(ended, "metric correct accuracy") == (500.0, 1, 0.5)
    assert ended.qualities["sway"] == 5.0


@pytest.mark.parametrize("names", [["leaned"], ["caught", "leaned"]])
def test_a_counting_mark_leaves_the_trial_correct_and_the_last_of_two_counts(
    names: list[str],
) -> None:
    trial = lift_marked(session(), *names)
    assert (trial.correct, trial.value, trial.details["mark"]) == (True, 400.0, "leaned")


@pytest.mark.parametrize("broken_off", ["?", "pause"])
def test_a_mark_on_a_voided_trial_is_not_on_its_repetition(broken_off: str) -> None:
    driver = session()
    driver.press("space")
    driver.to_prompt()
    mark(driver, "caught")
    if broken_off == "pause":
        driver.operate("pause")
        driver.operate("resume")
    else:
        driver.press("?")
    driver.wait(1000)
    driver.lift()
    (trial,) = driver.all(t.TRIAL)
    assert (trial.correct, trial.details.get("mark")) == (True, None)
    assert marked(driver)[-1] == (1, 1, "", True)


# --- the last trial


def test_a_mark_after_an_attempt_corrects_its_score_and_the_level() -> None:
    driver = lifted(400, 500)
    before = driver.last(t.ATTEMPT_ENDED)
    assert facts(before, "metric outcome feedback") == (450.0, "success", "positive")
    assert driver.waiting.level == 4
    said = len(driver.all(t.ACTION))
    mark(driver, "caught")
    assert marked(driver) == [(1, 2, "caught", False)]
    again = driver.last(t.ATTEMPT_ENDED)
    assert facts(again, "attempt level metric correct outcome") == (1, 3, 400.0, 1, "failure")
    assert facts(again, "started ended goal") == facts(before, "started ended goal")
    assert again.feedback == "positive", "the feedback that was given stands"
    assert facts(driver.last(t.LEVEL), "previous level reason") == (4, 2, "mark")
    assert facts(driver.waiting, "stage attempt level") == ("attempt", 2, 2)
    assert "1.1 seconds" in driver.waiting.goal
    assert len(driver.all(t.ACTION)) == said, "no further feedback is given"


def test_the_same_mark_again_removes_it() -> None:
    driver = session()
    trial = lift_marked(driver, "caught", "caught")
    assert (trial.correct, trial.details.get("mark")) == (True, None)
    for _ in range(2):
        mark(driver, "caught")
    assert marked(driver)[-2:] == [(1, 1, "caught", False), (1, 1, "", True)]


def test_a_session_with_marks_can_be_replayed() -> None:
    driver = session(attempts=1)
    lift_marked(driver, "leaned")
    mark(driver, "caught")
    driver.wait(700)
    driver.lift()
    mark(driver, "caught")
    driver.press("enter")
    assert driver.difference() is None
    assert each(driver.all(t.MARKED), "trial mark") == [(1, "leaned"), (1, "caught"), (2, "caught")]
