"""Prompts and measures that follow from earlier results: of the same attempt, and of the attempts
before.
"""

import pytest

from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ATTEMPT_ENDED, PROMPT, VOIDED
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast

KEYS = "ffxfxf"


def played(theme: Theme, *attempts: str) -> LoopDriver:
    """A session in which these keys were pressed, a text an attempt."""
    driver = LoopDriver(Contrast, theme, attempts=8)
    driver.enter()
    for keys in attempts:
        driver.press("enter")
        for key in keys:
            driver.answer(key=key)
        driver.wait(1000)
    return driver


def prompts(driver: LoopDriver) -> list[str]:
    return [prompt.text for prompt in driver.all(PROMPT)]


def test_a_prompt_follows_from_the_results_of_its_attempt(calm: Theme) -> None:
    driver = played(calm, KEYS)
    assert prompts(driver) == [f"Contrast:{contrast}:" for contrast in (10, 11, 12, 11, 12, 11)]


def test_results_begin_anew_with_each_attempt_and_scores_stay(calm: Theme) -> None:
    driver = played(calm, KEYS, "xfffff", "f")
    assert prompts(driver)[6:] == [
        *(f"Contrast:{contrast}:4" for contrast in (10, 9, 10, 11, 12, 13)),
        "Contrast:10:4-5",
    ]


def test_a_prompt_repeated_after_a_pause_has_the_same_results(calm: Theme) -> None:
    driver = played(calm, "ff")
    before = driver.to_prompt()
    driver.operate("pause")
    driver.operate("resume")
    again = driver.to_prompt()
    assert driver.last(VOIDED).trial == 3
    assert (before.text, again.text) == ("Contrast:12:", "Contrast:12:")
    assert again.presentation == 2


@pytest.mark.parametrize("cut", [1, 3, 6, 8, 11, 14])
def test_they_are_the_same_in_a_resumed_session(calm: Theme, cut: int) -> None:
    whole = played(calm, KEYS, "xfffff", "ffx")
    expected = {(prompt.attempt, prompt.trial): prompt.text for prompt in whole.all(PROMPT)}
    last = whole.all(PROMPT)[cut]
    end = next(place for place, record in enumerate(whole.records) if record.message is last)
    driver = LoopDriver(Contrast, calm, attempts=8, history=history_before(whole, end))
    driver.press("enter")
    again = driver.to_prompt()
    assert again.text == expected[again.attempt, again.trial]
    assert (again.attempt, again.trial) == (last.attempt, last.trial)


def history_before(driver: LoopDriver, end: int) -> list[Record]:
    """The record up to the end of the cascade that holds a message."""
    at = driver.records[end].at
    while (
        end < len(driver.records)
        and driver.records[end].topic.origin != "input"
        and driver.records[end].at == at
    ):
        end += 1
    return driver.records[:end]


def test_a_mark_after_the_attempt_changes_its_score_for_the_next(calm: Theme) -> None:
    driver = played(calm, "ffffff")
    driver.operate("mark", "slip")
    driver.press("enter")
    assert driver.to_prompt().text == "Contrast:10:5"


def test_practice_is_in_the_history_too(calm: Theme) -> None:
    driver = LoopDriver(Contrast, calm, attempts=2, practice_attempts=1)
    driver.enter()
    driver.attempt()
    driver.press("enter")
    assert driver.to_prompt().text == "Contrast:10:6"


def test_a_learning_score_compares_an_attempt_with_those_before(calm: Theme) -> None:
    driver = played(calm, "fxxxxx", "ffffxx", "fffxxx")
    ended: list[m.AttemptEnded] = driver.all(ATTEMPT_ENDED)
    assert [attempt.qualities for attempt in ended] == [{}, {"gain": 3.0}, {"gain": -1.0}]
