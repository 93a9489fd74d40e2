"""Prompts of several frames: each is drawn at its time, stamped, and stored; responses count from
the timed one.
"""

import math
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import FAULT, FRAME, PROMPT, SHOWN, TRIAL, VOIDED
from sar_tui.model.frames import never_shown
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.loop_driver import LoopDriver

CALM = Catalogue().theme("calm")
STOP = (Frame("→", 250), Frame("X"))
CUED = (Frame("<", 100), Frame("", 300), Frame("O", 50, timed=True, awaited=True), Frame("#"))
ON_TIME = [0, 100, 400, 450]


class Framed(Task):
    """Shows the frames that a test sets, and ends at the first key."""

    name = "framed"
    title = "Framed"
    metric = Metric("reaction_time", "ms", "lower")
    frames: Any = CUED
    timeout_ms: Any = None

    @property
    def trials_per_attempt(self) -> int:
        return 2

    def instructions(self) -> str:
        return "Look."

    def stimulus(self, situation: Any) -> Stimulus:
        return Stimulus("one", "f", "Press: f", frames=self.frames, timeout_ms=self.timeout_ms)

    def perceived(self, trial: Trial, percept: Any) -> Result:
        at, details = percept.at, {"frame": trial.frame_at(percept.at)}
        latency = trial.latency_ms(at)
        return Result(
            correct=True, response=percept.key, response_at=at, value=latency, details=details
        )


def session(
    frames: Any = CUED, timeout_ms: Any = None, at: str = "prompt", **more: Any
) -> LoopDriver:
    task = type("Set", (Framed,), {"frames": frames, "timeout_ms": timeout_ms})
    driver = LoopDriver(task, CALM, attempts=2, response_timeout_ms=900, **more)
    if at == "prompt":
        driver.start()
    return driver


def press_after(driver: LoopDriver, ms: float) -> Any:
    driver.wait(ms)
    driver.press("f")
    return driver.last(TRIAL)


def onsets(driver: LoopDriver) -> list[float]:
    """Times of the frames since the first of the last presentation (ms)."""
    last = driver.last(SHOWN)
    shown = [one for one in driver.all(SHOWN) if one.presentation == last.presentation]
    shown = [one for one in shown if one.trial == last.trial]
    return [(one.at - shown[0].at) / MS for one in shown]


def draw_second_frame_after(driver: LoopDriver, ms: float) -> None:
    driver.screen.shows = False
    driver.wait(ms)
    driver.screen.show_frame(1)
    driver.screen.shows = True
    driver.wait(500)


# --- drawing


def test_each_frame_is_drawn_and_stamped_at_its_time() -> None:
    driver = session()
    prompt = driver.last(PROMPT)
    driver.wait(800)
    assert onsets(driver) == ON_TIME
    assert each(driver.all(FRAME), "frame") == [1, 2, 3]
    drawn = [prompt.shown(place) for place in range(4)]
    assert each(drawn, "glyph") == each(drawn, "text") == ["<", "", "O", "#"]


def test_a_delay_of_one_frame_does_not_shift_the_next_and_is_flagged_if_long() -> None:
    driver = session()
    draw_second_frame_after(driver, 112)
    assert onsets(driver) == [0, 112, 400, 450]
    assert press_after(driver, 0).timing.flags == ("late_frame",)


def test_one_slow_drawing_does_not_make_the_next_frame_early() -> None:
    driver = session()
    press_after(driver, 600)
    driver.screen.shows = False
    driver.until(lambda: len(driver.all(PROMPT)) == 2)
    driver.wait(9)
    driver.screen.show(driver.last(PROMPT))
    driver.screen.shows = True
    driver.wait(600)
    assert onsets(driver) == ON_TIME


def test_a_last_frame_with_a_time_is_followed_by_an_empty_one() -> None:
    driver = session((Frame("5", 100),))
    driver.wait(200)
    assert driver.last(PROMPT).frames == (Frame("5", 100), Frame())
    assert onsets(driver) == [0, 100]


# --- responses


def test_the_reaction_time_counts_from_the_timed_frame() -> None:
    driver = session()
    trial = press_after(driver, 400 + 321)
    assert facts(trial, "reaction_time_ms value details") == (321, 321, {"frame": 3})
    assert trial.onset == driver.all(SHOWN)[2].at
    assert list(trial.timing.frame_onsets_ns) == each(driver.all(SHOWN), "at")


def test_it_counts_from_the_first_frame_if_none_is_marked() -> None:
    driver = session(STOP)
    trial = press_after(driver, 200)
    assert facts(trial, "reaction_time_ms details") == (200, {"frame": 0})
    assert len(trial.timing.frame_onsets_ns) == 1
    driver.wait(2000)
    assert each(driver.all(FRAME), "trial") == [2], "the rest of the first prompt was never shown"


def test_a_key_before_the_awaited_frame_is_flagged_and_no_response() -> None:
    driver = session()
    driver.wait(50)
    driver.press("f")
    assert driver.all(TRIAL) == []
    trial = press_after(driver, 350 + 200)
    assert facts(trial, "reaction_time_ms timing.flags") == (200, ("early_key",))


def test_a_response_before_the_timed_frame_is_an_anticipation() -> None:
    trial = press_after(session((Frame("<", 300), Frame("O", timed=True))), 100)
    assert facts(trial, "onset reaction_time_ms value") == (None, None, None)
    assert "anticipation" in trial.timing.flags


def test_a_key_while_a_frame_is_drawn_is_judged_by_its_onset() -> None:
    driver = session()
    driver.wait(380)
    driver.screen.shows = False
    driver.wait(25)
    pressed = driver.clock.now()
    driver.press("f")
    assert driver.all(TRIAL) == []
    driver.screen.show_frame(2, at=pressed - 2 * MS)
    judged = facts(driver.last(TRIAL), "reaction_time_ms timing.flags")
    assert judged == (2, ("anticipation",))


def test_the_time_for_the_response_counts_from_the_timed_frame() -> None:
    driver = session()
    assert driver.last(PROMPT).timeout == (400 + 900) * MS
    driver.wait(400 + 900 + 45)
    assert driver.all(TRIAL) == []
    driver.wait(10)
    assert driver.last(TRIAL).response is None


@pytest.mark.parametrize("frames", [(), STOP])
def test_a_prompt_has_a_time_for_the_response_of_its_own(frames: tuple[Frame, ...]) -> None:
    driver = session(frames, 300)
    assert driver.last(PROMPT).timeout == 300 * MS
    driver.wait(345)
    assert driver.all(TRIAL) == []
    driver.press("f", at=driver.clock.now() - 46 * MS)
    assert driver.last(TRIAL).response == "f", "it was pressed in time"
    driver.to_prompt()
    driver.wait(355)
    assert driver.last(TRIAL).response is None


# --- pause, resume, replay


def test_a_pause_shows_the_prompt_again_from_its_first_frame() -> None:
    driver = session()
    driver.wait(200)
    driver.operate("pause")
    driver.wait(1000)
    assert each(driver.all(SHOWN), "frame") == [0, 1], "nothing is shown in a pause"
    driver.operate("resume")
    driver.to_prompt()
    driver.wait(460)
    assert driver.last(VOIDED).presentation == 1
    assert onsets(driver) == ON_TIME
    assert len(press_after(driver, 0).timing.frame_onsets_ns) == 4


def test_a_session_with_frames_replays_identically() -> None:
    driver = session()
    for _ in range(2):
        driver.to_prompt()
        press_after(driver, 600)
    assert driver.difference() is None


# --- mistakes


@pytest.mark.parametrize(
    ("frames", "timeout_ms", "said"),
    [
        ([Frame("x")], None, "are a tuple of Frame"),
        ((Frame("x"), Frame("y")), None, "Frame 1 of 2 has no ms"),
        ((Frame("x", 3), Frame("y")), None, "Frame 1 has 3 ms; it needs at least 10"),
        ((Frame("x", "30"), Frame("y")), None, "The ms of frame 1 is a number, not '30'"),  # type: ignore[arg-type]
        ((Frame("x", 30, timed=True), Frame("y", timed=True)), None, "More than one frame"),
        ((Frame("", 30), Frame("", 30)), None, "Two empty frames follow each other"),
        *[((), ms, f"The timeout_ms of a prompt is {ms!r}") for ms in (0, -5, math.nan, "900")],
    ],
)
def test_frames_or_times_that_cannot_be_end_the_session_with_a_sentence(
    frames: Any, timeout_ms: Any, said: str
) -> None:
    driver = session(frames, timeout_ms, at="instructions")
    driver.enter()
    driver.press("enter")
    assert said in driver.last(FAULT).error


COUNT = (Frame("1", 400), Frame("2", 400), Frame("3"))


@pytest.mark.parametrize(
    ("shown", "timeout_ms", "place"),
    [
        (COUNT, 700, 2),
        (COUNT, 900, None),
        ((*COUNT[:2], Frame("3", timed=True)), 10, None),
        ((), 10, None),
    ],
)
def test_frames_after_the_time_for_the_response_are_found(
    shown: tuple[Frame, ...], timeout_ms: float, place: int | None
) -> None:
    assert never_shown(shown, timeout_ms) == place
