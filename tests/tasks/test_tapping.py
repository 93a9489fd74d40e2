"""The tapping task: the taps of a round, their regularity, and what is no tap."""

import itertools
from statistics import stdev

import pytest

from sar_tui.loop.topics import PROMPT, TRIAL
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver


@pytest.fixture
def driver(calm: Theme) -> LoopDriver:
    """Begin a round of two seconds."""
    driver = LoopDriver(Catalogue().task("tapping"), calm, attempts=1, seconds=2)
    driver.start()
    return driver


def tap(driver: LoopDriver, *intervals_ms: float) -> None:
    for interval in intervals_ms:
        driver.wait(interval)
        driver.press("space")


def test_taps_are_counted_for_the_time_of_the_round(driver: LoopDriver) -> None:
    tap(driver, 300, 200, 150, 250, 200)
    driver.press("x")
    driver.wait(1500)
    tap(driver, 100)  # it is over
    row = driver.last(TRIAL)
    assert (row.value, row.correct) == (5.0, True)
    assert row.details["interval_ms"] == pytest.approx(200, abs=1)
    assert row.details["variation"] == pytest.approx(stdev((200, 150, 250, 200)) / 200, abs=0.01)
    assert row.details["first_ms"] == pytest.approx(300, abs=5)


@pytest.mark.parametrize(("delay_ms", "every_ms"), [(250, 25), (500, 40), (660, 50)])
def test_a_key_that_its_keyboard_repeats_is_one_tap(
    driver: LoopDriver, delay_ms: int, every_ms: int
) -> None:
    driver.wait(200)
    driver.strike("space")
    driver.wait(delay_ms)
    late = itertools.cycle((0, 9, 3, 14, 0, 6, 11))  # a busy machine reads them unevenly
    for _ in range(1000 // every_ms):
        driver.strike("space", at=driver.clock.now() + next(late) * MS)
        driver.wait(every_ms)
    driver.wait(2000)
    row = driver.last(TRIAL)
    assert (row.value, row.details["taps"]) == (1.0, 1)
    assert "repeat_key" in row.timing.flags


def test_taps_before_and_after_a_held_key_are_counted(driver: LoopDriver) -> None:
    tap(driver, 300, 150, 140)
    driver.wait(400)
    driver.hold("space", 600, every_ms=33)
    tap(driver, 120, 150)
    driver.wait(2000)
    assert driver.last(TRIAL).value == 5.0


def test_a_round_without_taps_is_missed(driver: LoopDriver) -> None:
    driver.wait(3000)
    row = driver.last(TRIAL)
    assert (row.correct, row.value, row.details["taps"]) == (False, None, 0)
    assert driver.all(PROMPT)
