"""Prompts that are answered by typing: echoed, sent, timed; resumed and replayed."""

from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import TRIAL, TYPED
from sar_tui.model.messages import TextPerceived
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric, Result, Stimulus, Trial
from sar_tui.model.units import MS
from tests.loop_driver import LoopDriver

PARAMETERS: dict[str, Any] = {"attempts": 2, "response_timeout_ms": 9000}


class Recall(Task):
    """Takes two words, and ends with what was not sent if the time is over."""

    name = "recall"
    title = "Recall"
    metric = Metric("words", "", "higher")

    @property
    def trials_per_attempt(self) -> int:
        return 2

    def instructions(self) -> str:
        return "Type what you remember."

    def stimulus(self, situation: Any) -> Stimulus:
        return Stimulus("list", "sun", "Type a word.", hint="Now", expects="text")

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        assert isinstance(percept, TextPerceived)
        words = [each.text for each in (*trial.percepts, percept)]
        if len(words) < 2:
            return None
        return Result(
            correct=True,
            response=" ".join(words),
            onset_at=trial.percepts[0].began,
            response_at=percept.at,
            value=float(len(words)),
        )

    def timed_out(self, trial: Trial) -> Result:
        return Result(correct=False, response=f"({trial.typed})")


class Pair(Recall):
    seats = ("A", "B")

    def seat_of(self, key: str) -> str:
        return "A"


def write(driver: LoopDriver, *keys: str) -> None:
    for key in keys:
        driver.wait(100)
        driver.press(key)


def echoed(driver: LoopDriver) -> list[str]:
    return [typed.text for typed in driver.all(TYPED)]


def test_text_is_echoed_and_judged_when_it_is_sent(calm: Theme) -> None:
    driver = LoopDriver(Recall, calm, **PARAMETERS)
    prompt = driver.start()
    onset = driver.screen.onset
    assert onset is not None
    assert prompt.shown().hint == "_"
    write(driver, "s", "u", "m", "backspace", "n", "left", "enter")
    assert echoed(driver) == ["s", "su", "sum", "su", "sun", ""]
    assert prompt.shown(-1, "sun").hint == "sun_"
    assert driver.all(TRIAL) == []
    write(driver, "s", "e", "a", "enter")
    trial = driver.last(TRIAL)
    assert trial.response == "sun sea"
    assert trial.reaction_time_ms == 100
    assert trial.onset == onset + 100 * MS
    assert trial.response_at == onset + 1100 * MS
    assert trial.timing.handler_delay_ms == 0


def test_what_was_not_sent_is_there_when_the_time_is_over(calm: Theme) -> None:
    driver = LoopDriver(Recall, calm, **PARAMETERS)
    driver.start()
    write(driver, "s", "u")
    driver.until(lambda: driver.all(TRIAL))
    assert driver.last(TRIAL).response == "(su)"


def test_a_held_key_types_once_and_a_paste_nothing(calm: Theme) -> None:
    driver = LoopDriver(Recall, calm, **PARAMETERS)
    driver.start()
    driver.wait(500)
    driver.hold("s", 300)
    driver.paste()
    driver.focus(False)
    write(driver, "enter", "a", "enter")
    assert driver.last(TRIAL).response == "s a"
    assert set(driver.last(TRIAL).timing.flags) == {"repeat_key", "paste", "focus_lost"}


def test_a_pause_clears_what_was_typed(calm: Theme) -> None:
    driver = LoopDriver(Recall, calm, **PARAMETERS)
    driver.start()
    write(driver, "s", "u")
    driver.operate("pause")
    driver.operate("resume")
    driver.to_prompt()
    write(driver, "a", "enter", "b", "enter")
    assert driver.last(TRIAL).response == "a b"
    assert driver.last(TRIAL).timing.presentation == 2


def test_a_session_goes_on_in_the_middle_of_a_word(calm: Theme) -> None:
    driver = LoopDriver(Recall, calm, **PARAMETERS)
    driver.start()
    write(driver, "s", "u")
    assert driver.difference() is None


def test_two_people_cannot_type_at_one_keyboard(calm: Theme) -> None:
    driver = LoopDriver(Pair, calm, **PARAMETERS)
    with pytest.raises(AssertionError, match="broken"):
        driver.start()
    assert driver.session.broken
    assert "only in a task with one participant" in driver.session.broken.error
