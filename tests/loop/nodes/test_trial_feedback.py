"""The answer to a trial: shown after it for its time, quiet, and never while a response is
awaited.
"""

from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.trial import trial_feedback
from sar_tui.model import messages as m
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Result, Show, Situation, Trial
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
SITUATION = Situation(2, 5, 1, RandomStreams(1), RandomStreams(1))


class Points(Contrast):
    """Ten points for each right answer, and nothing for a wrong one; six trials an attempt."""

    def perceived(self, trial: Trial, percept: Any) -> Result:
        right = percept.key == "f"
        show = Show("+10", ms=800) if right else None
        given = {"response": percept.key, "response_at": percept.at, "value": 1.0, "show": show}
        return Result(correct=right, **given)


def answered(trials: int = 1, task: type[Task] = Points, **parameters: Any) -> LoopDriver:
    """Start a session, and answer some prompts correctly."""
    driver = LoopDriver(task, CALM, **{"attempts": 2, **parameters})
    driver.start()
    for _ in range(trials):
        driver.answer()
    return driver


def waits_after(driver: LoopDriver, ms: float) -> str:
    driver.wait(ms)
    return driver.waiting.what


def test_it_is_shown_for_its_time_before_the_next_foreperiod() -> None:
    driver = answered()
    shown = facts(driver.last(t.TRIAL_FEEDBACK), "attempt trial text duration")
    assert shown == (1, 1, "+10", 800 * MS)
    assert facts(driver.waiting, "stage what trial") == ("trial", "result", 1)
    assert waits_after(driver, 799) == "result"
    assert waits_after(driver, 1) == "foreperiod", "it has been quiet since the response"
    assert driver.waiting.trial == 2


def test_its_time_counts_from_when_it_was_on_the_screen() -> None:
    driver = answered()
    driver.wait(30)
    shown = m.TrialFeedbackShown(attempt=1, trial=1, at=driver.clock.now(), source="flush")
    driver.session.bus.publish(t.TRIAL_FEEDBACK_SHOWN, shown)
    assert [waits_after(driver, ms) for ms in (799, 1)] == ["result", "foreperiod"]


@pytest.mark.parametrize("trials", [1, 6])
def test_a_pause_ends_it_and_repeats_nothing_that_was_done(trials: int) -> None:
    driver = answered(trials)
    driver.operate("pause")
    driver.wait(5000)
    assert driver.waiting.stage == "paused"
    driver.operate("resume")
    assert len(driver.all(t.TRIAL)) == trials
    if trials == 6:
        assert facts(driver.waiting, "what attempt") == ("enter", 2)
    else:
        assert driver.to_prompt().trial == 2
        assert each(driver.all(t.VOIDED), "trial") == [2]


@pytest.mark.parametrize(
    ("trials", "attempts", "status"), [(6, 1, "completed"), (6, 2, "aborted"), (3, 1, "aborted")]
)
def test_a_session_ended_meanwhile_keeps_the_attempt_that_is_over(
    trials: int, attempts: int, status: str
) -> None:
    driver = answered(trials, attempts=attempts)
    driver.operate("end")
    assert len(driver.all(t.ATTEMPT_ENDED)) == trials // 6
    assert driver.last(t.SESSION_ENDED).status == status


def test_a_mark_meanwhile_is_put_on_the_trial_that_is_over() -> None:
    driver = answered()
    assert driver.session.trial_mark.trial == (1, 1)
    driver.operate("mark", "slip")
    for _ in range(5):
        driver.answer()
    driver.wait(1000)
    assert driver.last(t.ATTEMPT_ENDED).correct == 5


@pytest.mark.parametrize(("trials", "place"), [(1, (1, 2)), (6, (2, 1))])
def test_a_session_resumed_meanwhile_goes_on_after_the_trial(
    trials: int, place: tuple[int, int]
) -> None:
    driver = LoopDriver(Points, CALM, attempts=2, history=answered(trials).records)
    driver.press("enter")
    if trials == 6:
        assert each(driver.all(t.ATTEMPT_ENDED), "trials") == [6]
        driver.wait(300)
        driver.press("enter")
    assert facts(driver.to_prompt(), "attempt trial") == place


def test_it_is_replayed_as_it_was() -> None:
    driver = answered()
    driver.wait(3000)
    again = Session(Points(driver.session.parameters), CALM, driver.clock, 1)
    assert again.compare(driver.records).difference is None


# --- a sign for every task


def test_a_tick_or_a_cross_can_be_shown_for_tasks_that_show_nothing() -> None:
    driver = answered(1, KEYBOARD, trial_feedback_ms=500)
    driver.answer(key="#")
    driver.until(lambda: len(driver.all(t.TRIAL)) == 3)
    assert each(driver.all(t.TRIAL_FEEDBACK), "text") == ["✓", "✗", "✗"]
    assert driver.last(t.TRIAL).response is None


def test_a_task_that_shows_something_keeps_its_own() -> None:
    driver = answered(trial_feedback_ms=500)
    driver.answer(key="x")
    shown = each(driver.all(t.TRIAL_FEEDBACK), "text duration")
    assert shown == [("+10", 800 * MS), ("✗", 500 * MS)]


RIGHT, LATE = Result(correct=True), Result(correct=False, show=Show("late", ms=900))


@pytest.mark.parametrize("flag", ["skipped", "unmeasured"])
def test_no_sign_is_shown_for_what_was_not_judged(flag: str) -> None:
    results = {"A": Result(correct=False, flags=(flag,))}
    assert trial_feedback(SITUATION, results, ("A",), 500) is None


@pytest.mark.parametrize(
    ("results", "told"),
    [
        ({"A": RIGHT, "B": LATE}, ("", ("✓", "late"), "✓ late", 900 * MS)),
        ({"A": RIGHT, "B": RIGHT}, ("", (), "✓", 500 * MS)),
        ({"B": RIGHT}, ("B", (), "✓", 500 * MS)),
    ],
    ids=["each in their half", "one for both", "one in the middle"],
)
def test_two_seats_see_their_own_answer_or_one_for_both(
    results: dict[str, Result], told: tuple[Any, ...]
) -> None:
    shown = trial_feedback(SITUATION, results, ("A", "B"), 500)
    assert facts(shown, "seat halves text duration") == told


@pytest.mark.parametrize(
    ("text", "ms"), [("", 500), ("two\nlines", 500), ("+10", 0), ("+10", 10_001)]
)
def test_what_cannot_be_shown_is_refused(text: str, ms: int) -> None:
    with pytest.raises(ValueError, match="shown after a trial"):
        Show(text, ms)
