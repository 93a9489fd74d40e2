"""The number of trials of an attempt may depend on its level."""

from sar_tui.loop.topics import ATTEMPT_ENDED, ATTEMPT_STARTED, TRIAL
from sar_tui.model.theme import Theme
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast


class Longer(Contrast):
    """As many prompts as the level says, and one."""

    def trials_at(self, level: int) -> int:
        return level + 1


def test_each_attempt_has_the_trials_of_its_level(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=3, threshold=1)
    driver.enter()
    for _ in range(3):
        driver.attempt()
    assert [started.trials for started in driver.all(ATTEMPT_STARTED)] == [2, 3, 4]
    assert [ended.trials for ended in driver.all(ATTEMPT_ENDED)] == [2, 3, 4]
    assert len(driver.all(TRIAL)) == 9


def test_the_last_attempt_is_over_although_the_level_after_it_has_more_trials(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=1, threshold=1)
    driver.enter()
    driver.attempt()
    assert (driver.waiting.stage, driver.waiting.trial, driver.waiting.trials) == ("review", 3, 2)


def test_a_level_set_in_an_attempt_leaves_its_trials_as_they_are(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=2)
    driver.start()
    driver.operate("level", value=5)
    driver.answer()
    driver.answer()
    driver.wait(1000)
    assert [ended.trials for ended in driver.all(ATTEMPT_ENDED)] == [2]
    driver.attempt()
    assert driver.last(ATTEMPT_ENDED).trials == 6


def test_a_day_is_counted_by_the_trials_that_were_done(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=9, threshold=1, repetitions_a_day=9)
    driver.enter()
    for _ in range(3):
        driver.attempt()
    assert driver.waiting.stage == "review"
    assert driver.waiting.notice == "That is enough for today. Well done."
