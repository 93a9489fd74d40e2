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
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result, Show, Situation, Trial
from sar_tui.model.units import MS
from tests.facts import facts
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast

SITUATION = Situation(2, 5, 1, RandomStreams(1), RandomStreams(1))


class Points(Contrast):
    """Ten points for each right answer, and nothing for a wrong one."""

    def perceived(self, trial: Trial, percept: Any) -> Result:
        is_right = percept.key == "f"
        show = Show("+10", ms=800) if is_right else None
        return Result(
            correct=is_right, response=percept.key, response_at=percept.at, value=1.0, show=show
        )


def begun(task: type[Task], theme: Theme, **parameters: object) -> LoopDriver:
    driver = LoopDriver(task, theme, attempts=2, **parameters)
    driver.start()
    return driver


def test_it_is_shown_for_its_time_before_the_next_foreperiod(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    shown = driver.last(t.TRIAL_FEEDBACK)
    assert (shown.attempt, shown.trial, shown.text, shown.duration) == (1, 1, "+10", 800 * MS)
    assert facts(driver.waiting, "stage what trial") == ("trial", "result", 1)
    driver.wait(799)
    assert driver.waiting.what == "result"
    driver.wait(1)
    # it has been quiet since the response
    assert (driver.waiting.what, driver.waiting.trial) == ("foreperiod", 2)


def test_its_time_counts_from_when_it_was_on_the_screen(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    driver.wait(30)
    shown = m.TrialFeedbackShown(attempt=1, trial=1, at=driver.clock.now(), source="flush")
    driver.session.bus.publish(t.TRIAL_FEEDBACK_SHOWN, shown)
    driver.wait(799)
    assert driver.waiting.what == "result"
    driver.wait(1)
    assert driver.waiting.what == "foreperiod"


def test_a_trial_without_an_answer_goes_on_at_once(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer(key="x")
    assert driver.all(t.TRIAL_FEEDBACK) == []
    assert driver.waiting.what == "quiet"


def test_keys_meanwhile_are_no_responses_and_lengthen_the_quiet(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    driver.wait(700)
    driver.press("f")
    driver.wait(100)
    assert driver.waiting.what == "quiet"
    driver.wait(399)
    assert driver.waiting.what == "quiet"
    driver.wait(1)
    assert driver.waiting.what == "foreperiod"
    assert len(driver.all(t.TRIAL)) == 1
    assert driver.last(t.TRIAL).timing.false_starts == 0


def test_after_the_last_trial_the_attempt_ends_when_it_was_seen(calm: Theme) -> None:
    driver = begun(Points, calm)
    for _ in range(6):
        driver.answer()
    assert driver.all(t.ATTEMPT_ENDED) == []
    driver.wait(800)
    assert len(driver.all(t.ATTEMPT_ENDED)) == 1


@pytest.mark.parametrize("trials", [1, 6])
def test_a_pause_ends_it_and_repeats_nothing_that_was_done(calm: Theme, trials: int) -> None:
    driver = begun(Points, calm)
    for _ in range(trials):
        driver.answer()
    driver.operate("pause")
    driver.wait(5000)
    assert driver.waiting.stage == "paused"
    driver.operate("resume")
    assert len(driver.all(t.TRIAL)) == trials
    if trials == 6:
        assert (driver.waiting.what, driver.waiting.attempt) == ("enter", 2)
    else:
        assert driver.to_prompt().trial == 2
        assert [voided.trial for voided in driver.all(t.VOIDED)] == [2]


@pytest.mark.parametrize(
    ("trials", "attempts", "status"), [(6, 1, "completed"), (6, 2, "aborted"), (3, 1, "aborted")]
)
def test_a_session_ended_meanwhile_keeps_the_attempt_that_is_over(
    calm: Theme, trials: int, attempts: int, status: str
) -> None:
    driver = LoopDriver(Points, calm, attempts=attempts)
    driver.start()
    for _ in range(trials):
        driver.answer()
    driver.operate("end")
    assert len(driver.all(t.ATTEMPT_ENDED)) == trials // 6
    assert driver.last(t.SESSION_ENDED).status == status


def test_the_attempt_can_be_left_out_meanwhile(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    assert driver.session.can_skip_attempt
    driver.operate("skip", reason="attempt")
    driver.wait(5000)
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 2)
    assert driver.all(t.ATTEMPT_ENDED) == []


def test_a_mark_meanwhile_is_put_on_the_trial_that_is_over(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    assert driver.session.trial_mark.trial == (1, 1)
    driver.operate("mark", "slip")
    for _ in range(5):
        driver.answer()
    driver.wait(1000)
    assert driver.last(t.ATTEMPT_ENDED).correct == 5


def test_a_level_set_meanwhile_holds_from_the_next_attempt(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    driver.operate("level", value=4)
    assert driver.to_prompt().level == 1


@pytest.mark.parametrize("steps", [1, 6])
def test_a_session_resumed_meanwhile_goes_on_after_the_trial(calm: Theme, steps: int) -> None:
    whole = begun(Points, calm)
    for _ in range(steps):
        whole.answer()
    driver = LoopDriver(Points, calm, attempts=2, history=whole.records)
    driver.press("enter")
    if steps == 6:
        assert [ended.trials for ended in driver.all(t.ATTEMPT_ENDED)] == [6]
        driver.wait(300)
        driver.press("enter")
    prompt = driver.to_prompt()
    assert (prompt.attempt, prompt.trial) == ((1, 2) if steps == 1 else (2, 1))


def test_it_is_replayed_as_it_was(calm: Theme) -> None:
    driver = begun(Points, calm)
    driver.answer()
    driver.wait(3000)
    assert (
        Session(Points(driver.session.parameters), calm, driver.clock, 1)
        .compare(driver.records)
        .difference
        is None
    )


# --- a sign for every task


def test_a_tick_or_a_cross_can_be_shown_for_tasks_that_show_nothing(
    keyboard: type[Task], calm: Theme
) -> None:
    driver = begun(keyboard, calm, trial_feedback_ms=500)
    driver.answer()
    driver.answer(key="#")
    driver.until(lambda: len(driver.all(t.TRIAL)) == 3)
    assert [shown.text for shown in driver.all(t.TRIAL_FEEDBACK)] == ["✓", "✗", "✗"]
    assert driver.last(t.TRIAL).response is None


def test_by_default_no_task_shows_it(keyboard: type[Task], calm: Theme) -> None:
    driver = begun(keyboard, calm)
    driver.answer()
    assert driver.all(t.TRIAL_FEEDBACK) == []
    assert "result" not in {waiting.what for waiting in driver.all(t.WAITING)}
    assert driver.all(t.PROMPT)


def test_a_task_that_shows_something_keeps_its_own(calm: Theme) -> None:
    driver = begun(Points, calm, trial_feedback_ms=500)
    driver.answer()
    driver.answer(key="x")
    assert [(shown.text, shown.duration // MS) for shown in driver.all(t.TRIAL_FEEDBACK)] == [
        ("+10", 800),
        ("✗", 500),
    ]


@pytest.mark.parametrize("flag", ["skipped", "unmeasured"])
def test_no_sign_is_shown_for_what_was_not_judged(flag: str) -> None:
    assert (
        trial_feedback(SITUATION, {"A": Result(correct=False, flags=(flag,))}, ("A",), 500) is None
    )


# --- two participants


def test_two_seats_see_their_own_answer_each_in_their_half() -> None:
    results = {"A": Result(correct=True), "B": Result(correct=False, show=Show("late", ms=900))}
    shown = trial_feedback(SITUATION, results, ("A", "B"), 500)
    assert shown is not None
    assert facts(shown, "seat halves text duration") == ("", ("✓", "late"), "✓ late", 900 * MS)


def test_one_answer_for_both_is_shown_once() -> None:
    results = dict.fromkeys(("A", "B"), Result(correct=True))
    shown = trial_feedback(SITUATION, results, ("A", "B"), 500)
    assert shown is not None
    assert (shown.seat, shown.halves, shown.text) == ("", (), "✓")


def test_an_answer_to_one_seat_stands_in_the_middle() -> None:
    shown = trial_feedback(SITUATION, {"B": Result(correct=True)}, ("A", "B"), 500)
    assert shown is not None
    assert (shown.seat, shown.halves, shown.text) == ("B", (), "✓")


@pytest.mark.parametrize(
    ("text", "ms"), [("", 500), ("two\nlines", 500), ("+10", 0), ("+10", 10_001)]
)
def test_what_cannot_be_shown_is_refused(text: str, ms: int) -> None:
    with pytest.raises(ValueError, match="shown after a trial"):
        Show(text, ms)
