"""Attempts of a continuous task follow each other without Enter, but never where a person may need
a moment.
"""

import pytest

from sar_tui.loop.script import CONTINUES_AFTER, READING
from sar_tui.loop.topics import ATTEMPT_STARTED, FEEDBACK
from sar_tui.model.theme import Theme
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast

PAUSE_MS = CONTINUES_AFTER // 1_000_000
READING_MS = READING // 1_000_000
SILENT = {"feedback_schedule": "none", "encouragement": False, "rest_every": 0}


class Stream(Contrast):
    """The same prompts, in one stream."""

    @property
    def continuous(self) -> bool:
        return True


def answered(driver: LoopDriver) -> LoopDriver:
    """Answer the six prompts of an attempt that has begun."""
    for _ in range(6):
        driver.answer()
    return driver


def begun(theme: Theme, **settings: object) -> LoopDriver:
    driver = LoopDriver(Stream, theme, **{"attempts": 3, **SILENT, **settings})  # type: ignore[arg-type]
    driver.enter()
    assert driver.waiting.until == 0, "the first attempt waits for Enter"
    driver.press("enter")
    return driver


def test_the_next_attempt_begins_by_itself(calm: Theme) -> None:
    driver = answered(begun(calm))
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "attempt")
    assert driver.waiting.until == driver.clock.now() + CONTINUES_AFTER
    driver.wait(PAUSE_MS - 1)
    assert len(driver.all(ATTEMPT_STARTED)) == 1
    driver.wait(1)
    assert len(driver.all(ATTEMPT_STARTED)) == 2
    answered(answered(driver))
    assert driver.waiting.stage == "review"
    driver.wait(60_000)
    assert driver.waiting.stage == "review"


@pytest.mark.parametrize("schedule", ["every", "request"])
def test_feedback_can_be_read_first(calm: Theme, schedule: str) -> None:
    driver = answered(begun(calm, feedback_schedule=schedule))
    if schedule == "request":
        driver.wait(1000)
        driver.press("tab")
    assert len(driver.all(FEEDBACK)) == 1
    driver.wait(READING_MS - 1)
    assert len(driver.all(ATTEMPT_STARTED)) == 1
    driver.wait(1)
    assert len(driver.all(ATTEMPT_STARTED)) == 2


@pytest.mark.parametrize(
    "settings",
    [{"practice_attempts": 1}, {"rest_after_attempts": 1, "rest_seconds": 10}],
    ids=["practice", "a rest"],
)
def test_enter_is_needed_after_practice_or_a_rest(calm: Theme, settings: dict[str, int]) -> None:
    driver = answered(begun(calm, **settings))
    driver.wait(60_000)
    assert (driver.waiting.stage, driver.waiting.attempt, driver.waiting.until) == ("attempt", 2, 0)
    assert len(driver.all(ATTEMPT_STARTED)) == 1


def test_enter_is_needed_after_a_pause_between_attempts(calm: Theme) -> None:
    driver = answered(begun(calm))
    driver.operate("pause")
    driver.wait(60_000)
    driver.operate("resume")
    driver.wait(60_000)
    assert (driver.waiting.stage, driver.waiting.until) == ("attempt", 0)
    driver.press("enter")
    assert len(driver.all(ATTEMPT_STARTED)) == 2


@pytest.mark.parametrize("wait_ms", [0, 1000, PAUSE_MS + 100])
def test_it_is_replayed_and_resumed(calm: Theme, wait_ms: int) -> None:
    driver = answered(begun(calm))
    driver.wait(wait_ms)
    assert driver.difference() is None
    resumed = LoopDriver(Stream, calm, attempts=3, history=driver.records, **SILENT)
    resumed.press("enter")
    resumed.wait(300)
    if wait_ms < PAUSE_MS:
        assert (resumed.waiting.stage, resumed.waiting.until) == ("attempt", 0)
        resumed.press("enter")
    assert resumed.to_prompt().attempt == 2
