"""Given a therapist who watches, when they mark a trial with one key, then trial, attempt and level follow."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.framework.session import Session
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import ACTION, ATTEMPT_ENDED, FEEDBACK, LEVEL, MARKED, TRIAL
from tests.desk import Desk
from tests.lifting import Bench, Lift

Sit = Callable[..., Bench]


@pytest.fixture
def sit(calm: Theme) -> Sit:
    """Sit down to three attempts of two lifts each, unless told otherwise; ready to start the first."""

    def at(**settings: Any) -> Bench:
        desk = Bench(Lift, calm, **{"attempts": 3, "start_level": 3, **settings})
        desk.begin_lifts()
        return desk

    return at


def mark(desk: Desk, name: str) -> None:
    desk.operate("mark", reason=name)


def marked(desk: Desk) -> list[tuple[int, int, str, bool]]:
    return [(m.attempt, m.trial, m.mark, m.correct) for m in desk.all(MARKED)]


# --- the trial under way ------------------------------------------------------------------------------------


def test_a_mark_in_a_trial_is_kept_with_it_and_it_does_not_count(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    mark(desk, "caught")
    assert desk.all(TRIAL) == [], "a mark ends nothing"
    desk.press("k")
    desk.wait(400)
    desk.press("u")
    trial = desk.last(TRIAL)
    assert (trial.response, trial.correct, trial.value) == ("lift", False, None)
    assert trial.details == {"sway": 4.0, "grip": 50.0, "mark": "caught"}
    assert marked(desk) == [(1, 1, "caught", False)], "it was heard at once, and needs no second telling"
    desk.wait(300)
    desk.lift(500)
    ended = desk.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.correct, ended.accuracy, ended.qualities["sway"]) == (500.0, 1, 0.5, 5.0)


def test_a_mark_that_counts_leaves_the_trial_correct(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    mark(desk, "leaned")
    desk.press("k")
    desk.wait(400)
    desk.press("u")
    trial = desk.last(TRIAL)
    assert (trial.correct, trial.value, trial.details["mark"]) == (True, 400.0, "leaned")


def test_a_mark_that_counts_makes_no_failed_trial_correct(sit: Sit) -> None:
    desk = sit()
    desk.lift(end="d")
    mark(desk, "leaned")
    assert marked(desk) == [(1, 1, "leaned", False)]


def test_of_two_marks_in_a_trial_the_last_stands(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    mark(desk, "caught")
    mark(desk, "leaned")
    desk.press("k")
    desk.wait(400)
    desk.press("u")
    assert (desk.last(TRIAL).correct, desk.last(TRIAL).details["mark"]) == (True, "leaned")


@pytest.mark.parametrize("broken_off", ["?", "pause"])
def test_a_mark_on_a_trial_that_is_broken_off_is_not_on_its_repetition(sit: Sit, broken_off: str) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    mark(desk, "caught")
    if broken_off == "pause":
        desk.operate("pause")
        desk.wait(1000)
        desk.operate("resume")
    else:
        desk.press("?")
        desk.wait(1000)
    desk.lift()
    assert (desk.last(TRIAL).correct, "mark" in desk.last(TRIAL).details) == (True, False)


# --- the last trial ------------------------------------------------------------------------------------------


def test_between_two_trials_the_last_one_is_marked_and_the_attempt_is_scored_with_it(sit: Sit) -> None:
    desk = sit()
    desk.lift(400)
    assert desk.waiting.what == "start"
    mark(desk, "caught")
    assert marked(desk) == [(1, 1, "caught", False)]
    assert desk.all(ATTEMPT_ENDED) == []
    desk.lift(600)
    ended = desk.last(ATTEMPT_ENDED)
    assert (ended.metric, ended.correct, ended.outcome) == (600.0, 1, "failure")
    assert desk.last(FEEDBACK).reason == "accuracy"


def test_before_the_first_trial_of_a_session_there_is_nothing_to_mark(sit: Sit) -> None:
    desk = sit()
    mark(desk, "caught")
    assert marked(desk) == []
    desk.lift()
    assert "mark" not in desk.last(TRIAL).details


def test_after_an_attempt_its_last_trial_is_marked_and_the_attempt_and_the_level_are_put_right(sit: Sit) -> None:
    desk = sit()
    desk.lift(400)
    desk.lift(500)
    before = desk.last(ATTEMPT_ENDED)
    assert (before.metric, before.outcome, before.feedback, desk.waiting.level) == (450.0, "success", "positive", 4)
    said = len(desk.all(ACTION))
    mark(desk, "caught")
    assert marked(desk) == [(1, 2, "caught", False)]
    again = desk.last(ATTEMPT_ENDED)
    assert (again.attempt, again.level, again.metric, again.correct, again.outcome) == (1, 3, 400.0, 1, "failure")
    assert (again.started, again.ended, again.goal) == (before.started, before.ended, before.goal)
    assert again.feedback == "positive", "that is what was said"
    assert (desk.last(LEVEL).previous, desk.last(LEVEL).level, desk.last(LEVEL).reason) == (4, 2, "mark")
    assert (desk.waiting.stage, desk.waiting.attempt, desk.waiting.level) == ("attempt", 2, 2)
    assert desk.waiting.goal == "Your goal: less than 1100 ms, with at least 80% right."
    assert len(desk.all(ACTION)) == said, "nothing more is said of it"


def test_another_mark_takes_the_place_of_the_first(sit: Sit) -> None:
    desk = sit()
    desk.lift(400)
    desk.lift(500)
    original = desk.last(ATTEMPT_ENDED)
    mark(desk, "caught")
    mark(desk, "leaned")
    assert marked(desk) == [(1, 2, "caught", False), (1, 2, "leaned", True)]
    assert desk.last(ATTEMPT_ENDED) == original
    assert desk.waiting.level == 4


def test_a_mark_that_counts_changes_neither_score_nor_level(sit: Sit) -> None:
    desk = sit()
    desk.lift(400)
    desk.lift(500)
    levels = len(desk.all(LEVEL))
    mark(desk, "leaned")
    first, again = desk.all(ATTEMPT_ENDED)
    assert first == again
    assert len(desk.all(LEVEL)) == levels


def test_after_the_last_attempt_too_its_last_trial_can_be_marked(sit: Sit) -> None:
    desk = sit(attempts=1)
    desk.lift(400)
    desk.lift(500)
    assert desk.waiting.stage == "review"
    mark(desk, "caught")
    assert marked(desk) == [(1, 2, "caught", False)]
    again = desk.last(ATTEMPT_ENDED)
    assert (again.metric, again.correct, again.outcome, again.feedback) == (400.0, 1, "failure", "positive")
    assert desk.waiting.stage == "review"
    mark(desk, "leaned")
    assert desk.last(ATTEMPT_ENDED) == desk.all(ATTEMPT_ENDED)[0]


def test_a_mark_may_lead_to_the_same_level_by_another_way(sit: Sit) -> None:
    """With two failures in a row to fall, the first is counted after the mark and the second falls."""
    desk = sit(consecutive_successes=2, consecutive_failures=2)
    desk.lift(400)
    desk.lift(500)
    mark(desk, "caught")
    assert desk.all(LEVEL) == []
    assert desk.waiting.level == 3
    desk.press("enter")
    desk.wait(300)
    desk.lift(end="d")
    desk.lift(end="d")
    assert (desk.last(LEVEL).level, desk.last(LEVEL).reason) == (2, "failure")


def test_once_the_next_attempt_has_begun_the_last_is_closed(sit: Sit) -> None:
    desk = sit()
    desk.lift()
    desk.lift()
    desk.press("enter")
    desk.wait(300)
    mark(desk, "caught")
    assert marked(desk) == []
    assert len(desk.all(ATTEMPT_ENDED)) == 1


@pytest.mark.parametrize("attempts", [1, 3])
def test_a_level_set_by_hand_is_not_undone_by_a_mark(sit: Sit, attempts: int) -> None:
    desk = sit(attempts=attempts)
    desk.lift()
    desk.lift()
    desk.operate("level", value=7)
    ended = len(desk.all(ATTEMPT_ENDED))
    mark(desk, "caught")
    assert (marked(desk), len(desk.all(ATTEMPT_ENDED)), desk.last(LEVEL).level) == ([], ended, 7)


def test_practice_is_marked_like_the_rest_and_has_no_level_to_change(sit: Sit) -> None:
    desk = sit(practice_attempts=1)
    desk.lift()
    desk.lift()
    mark(desk, "caught")
    again = desk.last(ATTEMPT_ENDED)
    assert (again.practice, again.outcome, desk.waiting.level) == (True, "failure", 3)
    assert desk.all(LEVEL) == []


@pytest.mark.parametrize("name", ["", "dropped", "f7"])
def test_a_mark_that_the_task_does_not_have_is_none(sit: Sit, name: str) -> None:
    desk = sit()
    desk.lift()
    mark(desk, name)
    assert marked(desk) == []
    assert desk.session.faults == []


def test_a_session_with_marks_is_derived_again_from_its_inputs(sit: Sit, calm: Theme) -> None:
    desk = sit(attempts=1)
    desk.press("space")
    desk.to_prompt()
    mark(desk, "leaned")
    desk.press("k")
    desk.wait(300)
    desk.press("u")
    mark(desk, "caught")
    desk.wait(700)
    desk.lift()
    mark(desk, "caught")
    desk.press("enter")
    again = Session(desk.session.task, calm, desk.clock, 1)
    derived: list[Any] = []
    again.bus.tap(derived.extend)
    again.replay(desk.records)
    assert derived == desk.records
    assert marked(desk) == [(1, 1, "leaned", True), (1, 1, "caught", False), (1, 2, "caught", False)]


def test_a_mark_given_again_is_taken_back(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    for _ in range(2):
        mark(desk, "caught")
    desk.press("k")
    desk.wait(300)
    desk.press("u")
    (lift,) = desk.all(TRIAL)
    assert (lift.correct, lift.details.get("mark")) == (True, None)
    for _ in range(2):
        mark(desk, "caught")
    assert marked(desk)[-2:] == [(1, 1, "caught", False), (1, 1, "", True)]


def test_a_mark_goes_with_the_trial_that_is_broken_off(sit: Sit) -> None:
    desk = sit()
    desk.press("space")
    desk.to_prompt()
    mark(desk, "caught")
    desk.operate("pause")
    desk.operate("resume")
    desk.wait(700)
    desk.lift()
    (lift,) = desk.all(TRIAL)
    assert (lift.correct, lift.details.get("mark")) == (True, None)
    assert marked(desk)[-1] == (1, 1, "", True)
