"""Attempts whose prompts, condition or number of trials follow from earlier results, their number
or their level.
"""

import pytest

from sar_tui.loop.bus import Record
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FEEDBACK,
    PROMPT,
    TRIAL,
)
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Situation, Stimulus
from tests.facts import each, facts
from tests.loop_driver import LoopDriver
from tests.staircase_task import Contrast

# --- prompts and measures that follow from earlier results


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


def test_a_prompt_follows_from_the_results_of_its_attempt_and_the_scores_before(
    calm: Theme,
) -> None:
    driver = played(calm, "ffxfxf", "xfffff", "f")
    assert each(driver.all(PROMPT), "text") == [
        *(f"Contrast:{contrast}:" for contrast in (10, 11, 12, 11, 12, 11)),
        *(f"Contrast:{contrast}:4" for contrast in (10, 9, 10, 11, 12, 13)),
        "Contrast:10:4-5",
    ]


@pytest.mark.parametrize("cut", [1, 6, 8])
def test_prompts_are_the_same_in_a_resumed_session(calm: Theme, cut: int) -> None:
    whole = played(calm, "ffxfxf", "xfffff", "ffx")
    cut_off = whole.all(PROMPT)[cut]
    history = records_until(whole, cut_off)
    driver = LoopDriver(Contrast, calm, attempts=8, history=history)
    driver.press("enter")
    same = "attempt trial text"
    assert facts(driver.to_prompt(), same) == facts(cut_off, same)


def records_until(driver: LoopDriver, message: m.Message) -> list[Record]:
    """The record up to the end of the cascade that holds a message."""
    place = next(at for at, record in enumerate(driver.records) if record.message is message)
    later = driver.records[place:]
    inputs = (at for at, record in enumerate(later) if record.topic.origin == "input")
    return driver.records[: place + next(inputs)]


def test_a_mark_after_the_attempt_changes_its_score_for_the_next(calm: Theme) -> None:
    driver = played(calm, "ffffff")
    driver.operate("mark", "slip")
    driver.press("enter")
    assert driver.to_prompt().text == "Contrast:10:5"


def test_a_learning_score_compares_an_attempt_with_those_before(calm: Theme) -> None:
    driver = played(calm, "fxxxxx", "ffffxx", "fffxxx")
    assert each(driver.all(ATTEMPT_ENDED), "qualities") == [{}, {"gain": 3.0}, {"gain": -1.0}]


# --- the condition of an attempt


class Blocked(Contrast):
    """Each second attempt is cued; the prompt names the condition, and those of the attempts
    before.
    """

    def condition(self, situation: Situation) -> str:
        assert situation.trial == 1
        return "cued" if situation.attempt % 2 == 0 else ""

    def stimulus(self, situation: Situation) -> Stimulus:
        before = "-".join(past.condition for past in situation.history)
        return Stimulus(name="c1", expected="f", text=f"Now:{situation.condition}:{before}")


def test_the_condition_is_kept_with_the_attempt_and_known_to_its_prompts(calm: Theme) -> None:
    driver = LoopDriver(Blocked, calm, attempts=3)
    driver.enter()
    for _ in range(3):
        driver.attempt()
    for topic in (ATTEMPT_STARTED, ATTEMPT_ENDED, FEEDBACK):
        assert each(driver.all(topic), "condition") == ["", "cued", ""]
    assert each(driver.all(PROMPT), "text")[::6] == ["Now::", "Now:cued:", "Now::-cued"]


def test_the_condition_is_kept_by_a_resumed_session_and_by_an_attempt_scored_again(
    calm: Theme,
) -> None:
    whole = LoopDriver(Blocked, calm, attempts=3)
    whole.enter()
    whole.attempt()
    whole.begin_attempt()
    whole.answer()
    driver = LoopDriver(Blocked, calm, attempts=3, history=whole.records)
    driver.press("enter")
    assert driver.to_prompt().text == "Now:cued:"
    for _ in range(5):
        driver.answer()
    driver.wait(1000)
    driver.operate("mark", "slip")
    assert each(driver.all(ATTEMPT_ENDED), "condition") == ["cued", "cued"]


@pytest.mark.parametrize("returned", [None, 3, "two\nlines"])
def test_a_condition_that_cannot_be_stored_ends_the_session_with_a_sentence(
    calm: Theme, returned: object
) -> None:
    class Wrong(Contrast):
        def condition(self, situation: Situation) -> str:
            return returned  # type: ignore[return-value]

    driver = LoopDriver(Wrong, calm, attempts=1)
    driver.enter()
    driver.press("enter")
    assert driver.session.broken
    assert "not a line of plain text" in driver.session.broken.error


# --- the number of trials


class Longer(Contrast):
    """As many prompts as the level says, and one."""

    def trials_at(self, level: int) -> int:
        return level + 1


def test_each_attempt_has_the_trials_of_its_level_and_a_day_counts_those_done(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=9, threshold=1, repetitions_a_day=9)
    driver.enter()
    for _ in range(3):
        driver.attempt()
    assert each(driver.all(ATTEMPT_STARTED), "trials") == [2, 3, 4]
    assert each(driver.all(ATTEMPT_ENDED), "trials") == [2, 3, 4]
    assert len(driver.all(TRIAL)) == 9
    assert facts(driver.waiting, "stage notice") == (
        "review",
        "That is enough for today. Well done.",
    )


def test_a_level_set_in_an_attempt_leaves_its_trials_as_they_are(calm: Theme) -> None:
    driver = LoopDriver(Longer, calm, attempts=2)
    driver.start()
    driver.operate("level", value=5)
    driver.answer()
    driver.answer()
    driver.wait(1000)
    driver.attempt()
    assert each(driver.all(ATTEMPT_ENDED), "trials") == [2, 6]
