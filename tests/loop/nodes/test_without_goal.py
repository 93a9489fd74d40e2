"""Tasks without a metric, and attempts without a goal: nothing is judged, everything is kept."""

from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import ACTION, ATTEMPT_ENDED, FEEDBACK, GOAL, LEVEL
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Target
from tests.facts import each
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast


class Free(Contrast):
    """The same prompts, without a result."""

    metric = None  # type: ignore[assignment]


class Aimless(Contrast):
    """The same prompts, with results and no goal, except at level 3."""

    def target(self, level: int) -> Target | None:
        return Target(5.0, 1.0) if level == 3 else None


BOTH = pytest.mark.parametrize("kind", [Free, Aimless])


def played(kind: type[Task], theme: Theme, attempts: int = 3, **settings: Any) -> LoopDriver:
    driver = LoopDriver(kind, theme, attempts=attempts, **settings)
    driver.enter()
    for _ in range(attempts):
        driver.attempt()
    return driver


@pytest.mark.parametrize(("kind", "metric"), [(Free, None), (Aimless, 12.5)])
def test_the_attempt_is_kept_and_not_judged(
    calm: Theme, kind: type[Task], metric: float | None
) -> None:
    driver = played(kind, calm)
    ended = driver.all(ATTEMPT_ENDED)
    assert each(ended, "metric goal outcome feedback") == [(metric, None, "none", "none")] * 3
    assert [(one.correct, one.trials, one.accuracy) for one in ended] == [(6, 6, 1.0)] * 3
    assert ended[1].qualities == {"gain": 0.0}
    assert driver.waiting.stage == "review"


@BOTH
def test_there_is_neither_goal_nor_feedback(calm: Theme, kind: type[Task]) -> None:
    driver = played(kind, calm)
    assert driver.all(FEEDBACK) == driver.all(LEVEL) == driver.all(GOAL) == []
    assert "feedback" not in {action.kind for action in driver.all(ACTION)}
    assert driver.waiting.goal == ""


@BOTH
@pytest.mark.parametrize("policy", ["one-up-one-down", "target", "percentile", "fixed"])
def test_no_difficulty_policy_changes_the_level(calm: Theme, kind: type[Task], policy: str) -> None:
    driver = played(kind, calm, attempts=4, difficulty_policy=policy)
    assert [ended.level for ended in driver.all(ATTEMPT_ENDED)] == [1] * 4


@BOTH
def test_a_sequence_of_levels_is_followed(calm: Theme, kind: type[Task]) -> None:
    driver = played(kind, calm, attempts=3, difficulty_policy="sequence", level_sequence=(2, 1, 4))
    assert [ended.level for ended in driver.all(ATTEMPT_ENDED)] == [2, 1, 4]


@BOTH
@pytest.mark.parametrize("schedule", ["request", "summary", "bandwidth", "faded"])
def test_no_schedule_gives_feedback(calm: Theme, kind: type[Task], schedule: str) -> None:
    driver = played(kind, calm, attempts=2, feedback_schedule=schedule)
    assert driver.waiting.ask == ""
    driver.press("tab")
    assert driver.all(FEEDBACK) == []


@BOTH
def test_a_mark_amends_the_attempt(calm: Theme, kind: type[Task]) -> None:
    driver = played(kind, calm, attempts=2)
    driver.operate("mark", "slip")
    assert each(driver.all(ATTEMPT_ENDED), "attempt correct") == [(1, 6), (2, 6), (2, 5)]


@BOTH
def test_it_is_replayed_and_resumed(calm: Theme, kind: type[Task]) -> None:
    driver = played(kind, calm, attempts=2)
    assert driver.difference() is None
    resumed = LoopDriver(kind, calm, attempts=2, history=driver.records)
    assert resumed.waiting.stage == "review"


def test_an_attempt_with_a_goal_among_others_is_judged(calm: Theme) -> None:
    driver = played(
        Aimless, calm, attempts=3, difficulty_policy="sequence", level_sequence=(1, 3, 1)
    )
    expected = [(None, "none"), (5.0, "success"), (None, "none")]
    assert each(driver.all(ATTEMPT_ENDED), "goal outcome") == expected
    assert [feedback.attempt for feedback in driver.all(FEEDBACK)] == [2]
