"""An attempt whose prompts build on each other begins again after an interruption, under the next
number.
"""

from collections.abc import Callable

import pytest

from sar_tui.loop.topics import ATTEMPT_ENDED, ATTEMPT_STARTED, LEVEL, TRIAL
from sar_tui.model.theme import Theme
from tests.facts import each, facts
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast


class Remembered(Contrast):
    """The same prompts, which must follow from each other without a gap."""

    @property
    def restarts_attempts(self) -> bool:
        return True


def interrupted(theme: Theme, done: int = 3, **settings: object) -> LoopDriver:
    """A session that was paused in its first attempt, after some of its trials."""
    driver = LoopDriver(Remembered, theme, **{"attempts": 2, **settings})  # type: ignore[arg-type]
    driver.start()
    for _ in range(done):
        driver.answer()
    driver.operate("pause")
    driver.wait(1000)
    return driver


def test_it_begins_again_when_the_session_goes_on(calm: Theme) -> None:
    driver = interrupted(calm)
    driver.operate("resume")
    waiting = driver.waiting
    assert facts(waiting, "stage what attempt trial") == ("attempt", "enter", 2, 1)
    assert (waiting.attempt_name, waiting.restarts) == ("attempt 1 of 2", 1)
    assert waiting.notice == "This attempt begins again."
    driver.wait(300)
    driver.attempt()
    assert driver.waiting.notice == "", "it is given once"
    driver.attempt()
    expected = [(1, False), (2, False), (3, False)]
    assert each(driver.all(ATTEMPT_STARTED), "attempt practice") == expected
    assert each(driver.all(ATTEMPT_ENDED), "attempt trials") == [(2, 6), (3, 6)]
    assert [trial.trial for trial in driver.all(TRIAL) if trial.attempt == 1] == [1, 2, 3], (
        "what was done stays"
    )
    assert driver.waiting.stage == "review"


@pytest.mark.parametrize(
    "interrupt",
    [lambda driver: driver.operate("repeat"), lambda driver: driver.press("f", stalled=True)],
    ids=["repeated by the operator", "suspended"],
)
def test_it_begins_again_when_a_prompt_is_repeated(
    calm: Theme, interrupt: Callable[[LoopDriver], None]
) -> None:
    driver = LoopDriver(Remembered, calm, attempts=2)
    driver.start()
    for _ in range(3):
        driver.answer()
    driver.to_prompt()
    interrupt(driver)
    assert facts(driver.waiting, "stage attempt restarts") == ("attempt", 2, 1)
    driver.wait(300)
    driver.attempt()
    assert each(driver.all(ATTEMPT_ENDED), "attempt trials") == [(2, 6)]


def test_before_its_first_answer_there_is_nothing_to_begin_again(calm: Theme) -> None:
    driver = interrupted(calm, done=0)
    driver.operate("resume")
    assert (driver.to_prompt().attempt, driver.waiting.restarts) == (1, 0)


def test_an_interrupted_practice_stays_practice(calm: Theme) -> None:
    driver = interrupted(calm, practice_attempts=1, attempts=1)
    driver.operate("resume")
    assert driver.waiting.attempt_name == "practice 1 of 1"
    driver.wait(300)
    driver.attempt()
    assert driver.waiting.attempt_name == "attempt 1 of 1"
    assert driver.waiting.notice == "Practice is over. From here on it counts."
    driver.attempt()
    assert each(driver.all(ATTEMPT_ENDED), "attempt practice") == [(2, True), (3, False)]
    assert driver.waiting.stage == "review"


def test_a_level_set_in_the_pause_holds_at_once_and_the_prompts_begin_anew(calm: Theme) -> None:
    driver = interrupted(calm)
    driver.operate("level", value=4)
    driver.operate("resume")
    assert (driver.waiting.level, driver.last(LEVEL).level) == (4, 4)
    driver.wait(300)
    assert facts(driver.begin_attempt(), "level text") == (4, "Contrast:10:")


@pytest.mark.parametrize("after", ["pause", "kill"])
def test_it_is_the_same_resumed_and_replayed(calm: Theme, after: str) -> None:
    driver = interrupted(calm)
    if after == "pause":
        driver.operate("resume")
        driver.wait(300)
        driver.begin_attempt()
        driver.answer()
    assert driver.difference() is None
    resumed = LoopDriver(Remembered, calm, attempts=2, history=driver.records)
    resumed.operate("resume")
    restarts = 2 if after == "pause" else 1
    assert (resumed.waiting.attempt, resumed.waiting.restarts) == (1 + restarts, restarts)
    assert resumed.waiting.attempt_name == "attempt 1 of 2"
