"""Tones of prompts: requested before they are due, stamped when they begin, and stored with the
trial.
"""

from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import FAULT, PROMPT, SHOWN, TONE_BEGAN, TONE_DUE, TONES_AHEAD, TRIAL
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus, Tone, Trial
from sar_tui.model.units import MS
from tests.loop_driver import SHOWING, LoopDriver

HIGH, LOW = Tone(1000, 50), Tone(500, 50)
BEATS = (Frame("·", 200), Frame("o", 400, tone=HIGH), Frame("·", 600, tone=LOW), Frame("·"))


class Sounding(Task):
    """Shows and plays what a test sets, and ends at the first key."""

    name = "sounding"
    title = "Sounding"
    metric = Metric("reaction_time", "ms", "lower")
    shown: tuple[Frame, ...] = BEATS
    tone: Tone | None = None

    @property
    def trials_per_attempt(self) -> int:
        return 2

    def instructions(self) -> str:
        return "Listen."

    def stimulus(self, situation: Any) -> Stimulus:
        return Stimulus("one", "f", "Press: f", frames=self.shown, tone=self.tone)

    def perceived(self, trial: Trial, percept: Any) -> Result:
        return Result(
            correct=True,
            response=percept.key,
            response_at=percept.at,
            details={"tones": len(trial.tones)},
        )


class Simple(Sounding):
    shown = ()
    tone = HIGH


def test_the_tone_of_a_frame_is_requested_when_the_one_before_is_shown(calm: Theme) -> None:
    driver = LoopDriver(Sounding, calm, attempts=1)
    driver.start()
    onset = driver.last(SHOWN).at
    assert [(due.frame, due.tone, due.at - onset) for due in driver.all(TONE_DUE)] == [
        (1, HIGH, 200 * MS)
    ]
    driver.wait(300)
    expected = [(1, 200 * MS), (2, 600 * MS)]
    assert [(due.frame, due.at - onset) for due in driver.all(TONE_DUE)] == expected


def test_the_tone_of_a_prompt_is_requested_with_it(calm: Theme) -> None:
    driver = LoopDriver(Simple, calm, attempts=1)
    prompt = driver.start()
    (due,) = driver.all(TONE_DUE)
    assert (prompt.tone, due.tone, due.frame) == (HIGH, HIGH, 0)
    assert due.at == driver.last(SHOWN).at - SHOWING


def test_tones_are_announced_before_the_foreperiod(calm: Theme) -> None:
    driver = LoopDriver(Sounding, calm, attempts=1)
    driver.start()
    topics = [record.topic for record in driver.records]
    assert driver.last(TONES_AHEAD).tones == (HIGH, LOW)
    assert topics.index(TONES_AHEAD) < topics.index(PROMPT)


def test_the_onsets_of_tones_are_stored_with_the_trial(calm: Theme) -> None:
    driver = LoopDriver(Sounding, calm, attempts=1)
    driver.start()
    driver.wait(700)
    driver.press("f")
    trial = driver.last(TRIAL)
    onset = driver.all(SHOWN)[0].at
    assert list(trial.timing.tone_onsets_ns) == [onset + 200 * MS, onset + 600 * MS]
    assert (trial.timing.tone_source, trial.details["tones"]) == ("device", 2)


def test_a_tone_that_is_not_heard_is_flagged(calm: Theme) -> None:
    driver = LoopDriver(Simple, calm, attempts=1)
    driver.screen.hears = "failed"
    driver.start()
    driver.wait(50)
    driver.press("f")
    assert "tone_failed" in driver.last(TRIAL).timing.flags
    assert driver.last(TRIAL).timing.tone_onsets_ns == ()


def test_the_onset_of_an_earlier_tone_is_not_that_of_this_trial(calm: Theme) -> None:
    driver = LoopDriver(Simple, calm, attempts=1)
    driver.start()
    driver.wait(200)
    late = driver.last(TONE_BEGAN)
    driver.press("f")
    driver.to_prompt()
    driver.wait(100)
    own = driver.last(TONE_BEGAN).at
    driver.session.bus.publish(TONE_BEGAN, late)
    driver.wait(200)
    driver.press("f")
    assert driver.last(TRIAL).timing.tone_onsets_ns == (own,)


def test_a_session_with_tones_replays_identically(calm: Theme) -> None:
    driver = LoopDriver(Sounding, calm, attempts=1)
    driver.start()
    for _ in range(2):
        driver.to_prompt()
        driver.wait(800)
        driver.press("f")
    assert driver.difference() is None


@pytest.mark.parametrize(
    ("tone", "said"),
    [
        (Tone(5, 50), "A tone has 5 Hz"),
        (Tone(500, 0), "A tone lasts 0 ms"),
        (Tone("500", 50), "The hz of a tone is a number, not '500'"),  # type: ignore[arg-type]
        (Tone(500, 50, 2.5, 100), "The times of a tone are a whole number"),  # type: ignore[arg-type]
        (Tone(500, 50, times=0, every_ms=100), "A tone sounds 0 times"),
        (Tone(500, 50, times=3), "its every_ms must be at least its ms"),
    ],
)
def test_a_tone_that_cannot_be_played_ends_the_session_with_a_sentence(
    calm: Theme, tone: Tone, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Simple, "tone", tone)
    driver = LoopDriver(Simple, calm, attempts=1)
    driver.enter()
    driver.press("enter")
    assert said in driver.last(FAULT).error
