"""Prompts of several frames: each is drawn at its time, stamped, and stored; responses count from
the timed one.
"""

import math
from collections.abc import Sequence
from typing import Any

import msgspec
import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import FAULT, FRAME, PROMPT, SHOWN, TRIAL, VOIDED
from sar_tui.model.frames import never_shown
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.store.messages import encoder
from tests.facts import each
from tests.loop_driver import LoopDriver

PARAMETERS: dict[str, Any] = {"attempts": 2, "response_timeout_ms": 900}
STOP = (Frame("→", 250), Frame("X"))
CUED = (Frame("<", 100), Frame("", 300), Frame("O", 50, timed=True, awaited=True), Frame("#"))


class Framed(Task):
    """Shows the frames that a test sets, and ends at the first key."""

    name = "framed"
    title = "Framed"
    metric = Metric("reaction_time", "ms", "lower")
    frames: Sequence[Frame] = STOP
    timeout_ms: float | None = None

    @property
    def trials_per_attempt(self) -> int:
        return 2

    def instructions(self) -> str:
        return "Look."

    def stimulus(self, situation: Any) -> Stimulus:
        return Stimulus("one", "f", "Press: f", frames=self.frames, timeout_ms=self.timeout_ms)  # type: ignore[arg-type]

    def perceived(self, trial: Trial, percept: Any) -> Result:
        at = percept.at
        return Result(
            correct=True,
            response=percept.key,
            response_at=at,
            value=trial.latency_ms(at),
            details={"frame": trial.frame_at(at)},
        )


class Cued(Framed):
    frames = CUED


def onsets(driver: LoopDriver) -> list[float]:
    """Times of the frames since the first of the last presentation (ms)."""
    shown = [
        one for one in driver.all(SHOWN) if one.presentation == driver.last(SHOWN).presentation
    ]
    return [(one.at - shown[0].at) / MS for one in shown]


def test_each_frame_is_drawn_and_stamped_at_its_time(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    prompt = driver.start()
    driver.wait(800)
    assert onsets(driver) == [0, 100, 400, 450]
    assert [due.frame for due in driver.all(FRAME)] == [1, 2, 3]
    assert [prompt.shown(place).glyph for place in range(4)] == ["<", "", "O", "#"]
    assert [prompt.shown(place).text for place in range(4)] == ["<", "", "O", "#"]


def test_a_delay_of_one_frame_does_not_shift_the_next(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.screen.shows = False
    driver.wait(120)
    assert driver.screen.prompt
    driver.screen.show_frame(1)
    driver.screen.shows = True
    driver.wait(500)
    assert onsets(driver) == [0, 120, 400, 450]


def test_the_reaction_time_counts_from_the_timed_frame(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.wait(400 + 321)
    driver.press("f")
    trial = driver.last(TRIAL)
    assert (trial.reaction_time_ms, trial.value, trial.details["frame"]) == (321, 321, 3)
    assert trial.onset == driver.all(SHOWN)[2].at
    assert list(trial.timing.frame_onsets_ns) == [one.at for one in driver.all(SHOWN)]


def test_it_counts_from_the_first_frame_if_none_is_marked(calm: Theme) -> None:
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    driver.start()
    driver.wait(200)
    driver.press("f")
    trial = driver.last(TRIAL)
    assert (trial.reaction_time_ms, trial.details["frame"], len(trial.timing.frame_onsets_ns)) == (
        200,
        0,
        1,
    )
    driver.wait(2000)
    assert each(driver.all(FRAME), "trial") == [2], "the rest of the first prompt was never shown"


def test_a_key_before_the_awaited_frame_is_flagged_and_no_response(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.wait(50)
    driver.press("f")
    assert driver.all(TRIAL) == []
    driver.wait(350 + 200)
    driver.press("f")
    trial = driver.last(TRIAL)
    assert (trial.reaction_time_ms, trial.timing.flags) == (200, ("early_key",))


def test_a_response_before_the_timed_frame_is_an_anticipation(calm: Theme) -> None:
    class Impatient(Framed):
        frames = (Frame("<", 300), Frame("O", timed=True))

    driver = LoopDriver(Impatient, calm, **PARAMETERS)
    driver.start()
    driver.wait(100)
    driver.press("f")
    trial = driver.last(TRIAL)
    assert (trial.onset, trial.reaction_time_ms, trial.value) == (None, None, None)
    assert "anticipation" in trial.timing.flags


def test_a_key_while_a_frame_is_drawn_is_judged_by_its_onset(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.wait(380)
    driver.screen.shows = False
    driver.wait(25)
    pressed = driver.clock.now()
    driver.press("f")
    assert driver.all(TRIAL) == []
    driver.screen.show_frame(2, at=pressed - 2 * MS)
    assert driver.last(TRIAL).timing.flags == ("anticipation",)
    assert driver.last(TRIAL).reaction_time_ms == 2


def test_the_time_for_the_response_counts_from_the_timed_frame(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    assert driver.last(PROMPT).timeout == (400 + 900) * MS
    driver.wait(400 + 900 + 45)
    assert driver.all(TRIAL) == []
    driver.wait(10)
    assert driver.last(TRIAL).response is None


@pytest.mark.parametrize(("frames", "until"), [((), 300), (STOP, 300)])
def test_a_prompt_has_a_time_for_the_response_of_its_own(
    calm: Theme, frames: tuple[Frame, ...], until: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Framed, "frames", frames)
    monkeypatch.setattr(Framed, "timeout_ms", 300)
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    driver.start()
    assert driver.last(PROMPT).timeout == until * MS
    driver.wait(until + 45)
    assert driver.all(TRIAL) == []
    driver.press("f", at=driver.clock.now() - 46 * MS)
    assert driver.last(TRIAL).response == "f", "it was pressed in time"
    driver.to_prompt()
    driver.wait(until + 55)
    assert driver.last(TRIAL).response is None


def test_a_pause_shows_the_prompt_again_from_its_first_frame(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.wait(200)
    driver.operate("pause")
    driver.wait(1000)
    assert [one.frame for one in driver.all(SHOWN)] == [0, 1], "nothing is shown in a pause"
    driver.operate("resume")
    driver.to_prompt()
    driver.wait(460)
    assert driver.last(VOIDED).presentation == 1
    assert onsets(driver) == [0, 100, 400, 450]
    driver.press("f")
    assert len(driver.last(TRIAL).timing.frame_onsets_ns) == 4


def test_a_resumed_session_shows_the_prompt_again_from_its_first_frame(calm: Theme) -> None:
    was = LoopDriver(Cued, calm, **PARAMETERS)
    was.start()
    was.wait(200)
    driver = LoopDriver(Cued, calm, history=was.records, **PARAMETERS)
    driver.press("enter")
    driver.to_prompt()
    driver.wait(460)
    assert onsets(driver) == [0, 100, 400, 450]
    assert driver.last(PROMPT).trial == 1


def test_a_session_with_frames_replays_identically(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    for _ in range(2):
        driver.to_prompt()
        driver.wait(600)
        driver.press("f")
    replayed = LoopDriver(Cued, calm, begin=False, **PARAMETERS)
    assert replayed.session.compare(driver.records).difference is None


@pytest.mark.parametrize(
    ("frames", "said"),
    [
        ([Frame("x")], "are a tuple of Frame"),
        ((Frame("x"), Frame("y")), "Frame 1 of 2 has no ms"),
        ((Frame("x", 3), Frame("y")), "Frame 1 has 3 ms; it needs at least 10"),
        ((Frame("x", "30"), Frame("y")), "The ms of frame 1 is a number, not '30'"),  # type: ignore[arg-type]
        ((Frame("x", 30, timed=True), Frame("y", timed=True)), "More than one frame is timed"),
        ((Frame("", 30), Frame("", 30)), "Two empty frames follow each other"),
    ],
)
def test_frames_that_cannot_be_shown_end_the_session_with_a_sentence(
    calm: Theme, frames: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Framed, "frames", frames)
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    driver.enter()
    driver.press("enter")
    assert said in driver.last(FAULT).error


@pytest.mark.parametrize("timeout_ms", [0, -5, math.nan, "900"])
def test_a_time_for_the_response_that_is_none_ends_the_session_with_a_sentence(
    calm: Theme, timeout_ms: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Framed, "timeout_ms", timeout_ms)
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    driver.enter()
    driver.press("enter")
    assert f"The timeout_ms of a prompt is {timeout_ms!r}" in driver.last(FAULT).error


def test_a_last_frame_with_a_time_is_followed_by_an_empty_one(
    calm: Theme, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Framed, "frames", (Frame("5", 100),))
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    prompt = driver.start()
    driver.wait(200)
    assert prompt.frames == (Frame("5", 100), Frame())
    assert onsets(driver) == [0, 100]


def test_a_prompt_without_frames_is_stored_as_before(
    calm: Theme, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Framed, "frames", ())
    driver = LoopDriver(Framed, calm, **PARAMETERS)
    driver.start()
    driver.wait(200)
    driver.press("f")
    assert driver.all(FRAME) == []
    assert b"frame_onsets" not in msgspec.json.encode(driver.last(TRIAL))
    assert "[]" not in encoder(PROMPT)(driver.last(PROMPT))


def test_one_slow_drawing_does_not_make_the_next_frame_early(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.wait(600)
    driver.press("f")
    driver.screen.shows = False
    driver.until(lambda: len(driver.all(PROMPT)) == 2)
    driver.wait(9)
    assert driver.screen.prompt
    driver.screen.show(driver.screen.prompt)
    driver.screen.shows = True
    driver.wait(600)
    first = driver.all(SHOWN)[-4].at
    assert [(one.at - first) / MS for one in driver.all(SHOWN)[-4:]] == [0, 100, 400, 450]


def test_a_frame_that_is_seen_late_is_flagged(calm: Theme) -> None:
    driver = LoopDriver(Cued, calm, **PARAMETERS)
    driver.start()
    driver.screen.shows = False
    driver.wait(112)
    driver.screen.show_frame(1)
    driver.screen.shows = True
    driver.wait(500)
    driver.press("f")
    assert driver.last(TRIAL).timing.flags == ("late_frame",)


@pytest.mark.parametrize(
    ("shown", "timeout_ms", "place"),
    [
        ((Frame("1", 400), Frame("2", 400), Frame("3")), 700, 2),
        ((Frame("1", 400), Frame("2", 400), Frame("3")), 900, None),
        ((Frame("1", 400), Frame("2", 400), Frame("3", timed=True)), 10, None),
        ((), 10, None),
    ],
)
def test_frames_after_the_time_for_the_response_are_found(
    shown: tuple[Frame, ...], timeout_ms: float, place: int | None
) -> None:
    assert never_shown(shown, timeout_ms) == place
