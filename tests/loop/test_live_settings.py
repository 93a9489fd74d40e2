"""A therapist changes goal, feedback and level during a session; it is replayed and resumed with
them.
"""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.attempts import adjustable, with_setting
from sar_tui.loop.task import Task
from sar_tui.loop.topics import ATTEMPT_ENDED, LEVEL, SETTING
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build
from tests.facts import facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver

New = Callable[..., LoopDriver]


@pytest.fixture
def new(keyboard: type[Task], calm: Theme) -> New:
    """Start a session of the keyboard task; by default six attempts of two prompts."""

    def start(**settings: Any) -> LoopDriver:
        driver = LoopDriver(keyboard, calm, **{"attempts": 6, "prompts_per_attempt": 2, **settings})
        driver.enter()
        return driver

    return start


def set_live(driver: LoopDriver, name: str, value: float) -> None:
    driver.session.bus.publish(SETTING, m.SettingChanged(name=name, value=value))


def goals(driver: LoopDriver) -> list[tuple[float | None, str]]:
    return [(each.goal, each.outcome) for each in driver.all(ATTEMPT_ENDED)]


def test_the_goal_applies_to_the_next_attempt_and_is_announced_before_it(new: New) -> None:
    driver = new()
    set_live(driver, "threshold", 300)
    assert "0.3 seconds" in driver.waiting.goal
    driver.attempt(after_ms=400)
    assert goals(driver) == [(300, "failure")]


def test_a_held_level_stays_until_it_is_released(new: New) -> None:
    driver = new(start_level=3)
    driver.operate("hold")
    driver.attempt()
    driver.attempt(after_ms=1500)
    assert driver.all(LEVEL) == []
    driver.operate("level", value=5)
    driver.attempt()
    assert driver.waiting.level == 5, "by hand it changes, and is held there"
    assert driver.session.next_attempt.is_level_held
    driver.operate("release")
    driver.attempt()
    assert driver.waiting.level == 6


@pytest.mark.parametrize(
    ("name", "value"), [("threshold", 1), ("feedback_every", 0), ("attempts", 3), ("none", 1)]
)
def test_a_value_out_of_bounds_or_another_setting_changes_nothing(
    new: New, name: str, value: float
) -> None:
    driver = new()
    set_live(driver, name, value)
    driver.attempt()
    assert goals(driver) == [(1000, "success")]
    assert driver.session.faults == []
    with pytest.raises(ParameterError):
        with_setting(driver.session.parameters, name, value)


def test_the_last_attempt_is_scored_again_by_the_goal_that_it_had(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, attempts=3, start_level=3)
    driver.begin_lifts()
    driver.lift(500)
    driver.lift(500)
    before = driver.last(ATTEMPT_ENDED)
    set_live(driver, "threshold", 400)
    driver.operate("mark", reason="leaned")
    again = driver.last(ATTEMPT_ENDED)
    assert again is not before
    assert facts(again, "attempt goal outcome") == (before.attempt, before.goal, before.outcome)
    driver.wait(1000)
    driver.press("enter")
    driver.lift(500)
    driver.lift(500)
    assert facts(driver.last(ATTEMPT_ENDED), "goal outcome") == (700, "success"), "level 4"


def _changed_session(driver: LoopDriver) -> None:
    driver.attempt()
    set_live(driver, "threshold", 350)
    set_live(driver, "feedback_every", 2)
    driver.operate("hold")
    driver.press("enter")
    driver.answer()
    set_live(driver, "threshold", 600)  # of the attempt after this one


def test_a_resumed_session_has_the_changes(new: New, keyboard: type[Task], calm: Theme) -> None:
    first = new()
    _changed_session(first)
    second = LoopDriver(keyboard, calm, history=first.records, attempts=6, prompts_per_attempt=2)
    assert first.session.next_attempt.settings["threshold"] == 600
    assert second.session.next_attempt == first.session.next_attempt
    assert second.session.task.parameters == first.session.task.parameters
    second.press("enter")
    second.wait(300)
    second.answer()
    second.wait(1000)
    second.attempt()
    assert goals(second)[-2:] == [(350, "failure"), (600, "success")]
    assert second.waiting.level == 2, "held"


def test_only_settings_with_an_effect_can_be_adjusted(catalogue: Catalogue) -> None:
    def offered(task: str, **settings: object) -> tuple[str, ...]:
        kind = catalogue.task(task)
        return adjustable(kind(build(kind.Parameters, settings)))

    assert offered("keyboard") == offered("pairs") == ("threshold", "feedback_every")
    assert offered("keyboard", feedback_schedule="request") == ("threshold",)
    assert offered("reaching") == ("threshold", "feedback_every")
    own_goals = "900, 1000, 1100, 1200, 1300, 1400"
    assert offered("reaching", goal_times_ms=own_goals) == ("feedback_every",)
    assert offered("keyboard", difficulty_policy="percentile") == ("feedback_every",), (
        "the goal is the person's own"
    )
