"""Reaches are corrected by keys, on a screen that shows one at a time."""

import asyncio
import io
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from sar_tui.app.correction import screen
from sar_tui.app.correction.app import CorrectionApp
from sar_tui.app.correction.dialogs import GoToScreen, UnsavedScreen, seconds_of
from sar_tui.inputs.imu import SourceError
from sar_tui.motion.labels import Correction, Label
from sar_tui.plugins import DEFAULT_THEME, Catalogue
from sar_tui.widgets.language import app_texts
from sar_tui.widgets.speed_chart import Speed, View, draw_speed, mean_speeds
from tests.album import Album
from tests.settle import settle

HOUR_S, RATE_HZ = 3600, 100
BEGINS_S = 1_700_000_000.0


def hour() -> Speed:
    """Return an hour with a reach, out and back, in every ten seconds."""
    time_s = np.arange(HOUR_S * RATE_HZ) / RATE_HZ
    phase = (time_s % 10.0 - 4.0) / 2.0
    is_reach = (phase >= 0) & (phase <= 1)
    return Speed(
        BEGINS_S + time_s, np.where(is_reach, 80.0 * np.abs(np.sin(2 * np.pi * phase)), 1.0)
    )


@pytest.fixture(autouse=True)
def _keys_of_tests_are_not_held(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(screen, "HELD_S", 0.0)


class Driver:
    """Presses keys, and reads the screen."""

    def __init__(self, app: Any, correction: Correction) -> None:
        self.app, self.correction = app, correction
        self.pilot: Any = None

    async def press(self, *keys: str) -> None:
        for key in keys:
            await self.pilot.press(key)
            await settle(self.app)

    async def saved(self) -> None:
        """Wait until corrections have been saved, or that has failed."""
        await asyncio.sleep(2 * screen.SAVE_AFTER_S)
        await settle(self.app)

    @property
    def rows(self) -> list[str]:
        console = Console(width=self.app.size.width, file=io.StringIO(), record=True)
        console.print(self.app.screen._compositor.render_update(full=True))
        return [row.rstrip() for row in console.export_text().splitlines()]

    @property
    def text(self) -> str:
        return "\n".join(self.rows)

    @property
    def states(self) -> list[str]:
        return [label.state for label in self.correction.labels]


class Saved(list[Sequence[Label]]):
    """The labels of each time they were saved. ``error`` is raised instead."""

    error: Exception | None = None

    def save(self, labels: Sequence[Label]) -> None:
        if self.error:
            raise self.error
        self.append(tuple(labels))


@asynccontextmanager
async def opened(
    saved: Saved,
    count: int = 360,
    language: str = "en",
    size: tuple[int, int] = (80, 24),
    looked_at: int = 0,
) -> AsyncIterator[Driver]:
    """Open the screen with reaches, the first of which have been looked at."""
    starts = [BEGINS_S + 10.0 * number + 4.0 for number in range(count)]
    labels = [
        Label(
            start_s=at,
            end_s=at + 2.0,
            state="accepted" if number < looked_at else "found",
            confidence=0.7 if number % 9 == 2 else 0.95,
        )
        for number, at in enumerate(starts)
    ]
    correction = Correction(labels, BEGINS_S, BEGINS_S + HOUR_S)
    app = CorrectionApp(
        Catalogue().theme(DEFAULT_THEME),
        app_texts(language),
        "monday.csv",
        hour(),
        correction,
        saved.save,
    )
    driver = Driver(app, correction)
    async with app.run_test(size=size) as driver.pilot:
        await settle(app)
        yield driver


async def test_reaches_are_accepted_dropped_moved_added_and_saved() -> None:
    saved = Saved()
    async with opened(saved) as driver:
        assert "Reach 1 of 360" in driver.text
        await driver.press("a")
        assert "Reach 2 of 360 · 1 looked at" in driver.text
        await driver.press("d")
        assert "This is no reach." in driver.text
        await driver.press("d", "d", "n")
        assert driver.states[:3] == ["accepted", "dropped", "found"]
        await driver.press("w", "W", "R", "e")
        moved = driver.correction.labels[2]
        assert moved.state == "moved"
        assert moved.start_s - BEGINS_S == pytest.approx(24.0 + 0.55)
        assert moved.end_s - BEGINS_S == pytest.approx(26.0 + 0.45)
        await driver.press("g", *"59:51", "enter")
        assert "No reach was found here." in driver.text
        await driver.press("i")
        assert driver.states[-2:] == ["added", "found"]
        await driver.press("s")
        assert "It is saved." in driver.text
        assert saved[-1] == tuple(driver.correction.labels)
        await driver.press("p", "left", "home")
        assert "Reach 1 of 361" in driver.text
        await driver.press("escape")
    assert driver.app.return_code == 0


async def test_only_unsure_ones_are_gone_through() -> None:
    async with opened(Saved()) as driver:
        await driver.press("u")
        assert "Unsure 1 of 40" in driver.text
        await driver.press("n")
        assert "0:1:54" not in driver.text
        assert "1:54.00 to 1:56.00" in driver.text
        await driver.press("u", "n")
        assert "Reach 13 of 360" in driver.text


async def test_each_correction_is_saved_and_those_of_a_held_key_at_once() -> None:
    saved = Saved()
    async with opened(saved) as driver:
        await driver.press("n", "p")
        await driver.saved()
        assert not saved
        await driver.press("a")
        await driver.saved()
        assert [label.state for label in saved[-1][:2]] == ["accepted", "found"]
        assert "1 looked at · saved" in driver.text
        for _ in range(20):
            driver.app.screen.action_move("end", 1)
        await driver.saved()
        assert saved[1:] == [tuple(driver.correction.labels)]


async def test_every_correction_can_be_taken_back() -> None:
    saved = Saved()
    async with opened(saved) as driver:
        before = list(driver.correction.labels)
        await driver.press("a", "d", "a", "p", "E", "g", *"0:20", "enter", "i")
        assert driver.states[:3] == ["accepted", "moved", "added"]
        await driver.press("z")
        assert "No reach was found here." in driver.text
        await driver.press("z")
        assert "Reach 2 of 360" in driver.text
        await driver.press("ctrl+z", "backspace", "z")
        assert "Reach 1 of 360 · 0 looked at" in driver.text
        assert driver.correction.labels == before
        await driver.press("z")
        assert "There is nothing to take back." in driver.text
        await driver.saved()
        assert saved[-1] == tuple(before)


async def test_enter_on_a_dropped_reach_goes_on_and_leaves_it_dropped() -> None:
    async with opened(Saved()) as driver:
        await driver.press("d")
        assert "Enter: on to the next" in driver.text
        await driver.press("enter")
        assert driver.states[:2] == ["dropped", "found"]
        assert "Reach 2 of 360" in driver.text


async def test_a_held_key_accepts_one_reach_only(monkeypatch: pytest.MonkeyPatch) -> None:
    async with opened(Saved()) as driver:
        monkeypatch.setattr(screen, "HELD_S", 1e6)
        driver.app.screen._accepted_s = -1e9
        await driver.press("enter", "enter", "a", "enter")
        assert driver.states[:3] == ["accepted", "found", "found"]


async def test_letters_mean_the_same_with_caps_lock_but_for_those_that_move_edges() -> None:
    async with opened(Saved()) as driver:
        await driver.press("A", "D", "N", "P")
        assert driver.states[:3] == ["accepted", "dropped", "found"]
        assert "Reach 2 of 360" in driver.text
        await driver.press("Z", "Z", "U")
        assert "Unsure 1 of 40" in driver.text
        await driver.press("G", "escape")
        assert driver.states[:2] == ["found", "found"]


async def test_it_goes_on_where_it_was_left() -> None:
    async with opened(Saved(), looked_at=200) as driver:
        assert "Reach 201 of 360 · 200 looked at" in driver.text
    async with opened(Saved(), count=3, looked_at=3) as driver:
        assert "Reach 1 of 3" in driver.text


async def test_the_end_is_told() -> None:
    async with opened(Saved(), count=3) as driver:
        await driver.press("end", "a")
        assert "There is no reach after this one." in driver.text
        await driver.press("u", "a")
        assert "You have looked at all unsure reaches." in driver.text
        await driver.press("u", "home", "a", "a", "n")
        assert "You have looked at all reaches." in driver.text


async def test_a_shorter_or_longer_time_is_shown() -> None:
    async with opened(Saved()) as driver:
        await driver.press("n", "minus", "minus")
        assert "─ 1 ─" in driver.text
        assert "─ 3 ─" in driver.text
        await driver.press(*["plus"] * 9, "n", "n")
        assert "─ 4 ─" in driver.text
        assert "0:33" not in driver.text, "the time shown stays as short"


async def test_what_cannot_be_saved_is_told_and_leaving_asks() -> None:
    saved = Saved()
    async with opened(saved) as driver:
        saved.error = OSError(28, "No space left on device")
        await driver.press("a")
        await driver.saved()
        assert "not saved" in driver.rows[0]
        assert "S tries again: No space left on device" in driver.text
        await driver.press("n")
        assert "No space left on device" in driver.text
        await driver.press("escape")
        assert isinstance(driver.app.screen, UnsavedScreen)
        assert "No space left on device" in driver.text
        await driver.press("ctrl+q", "ctrl+q", "escape")
        assert not isinstance(driver.app.screen, UnsavedScreen)
        saved.error = SourceError("labels.json was changed by another program meanwhile")
        await driver.press("ctrl+q", "enter")
        assert "labels.json was changed" in driver.text
        assert driver.app.is_running
        saved.error = None
        await driver.press("s")
        assert "It is saved." in driver.text
        assert "not saved" not in driver.text
        await driver.press("escape")
    assert driver.app.return_code == 0
    assert len(saved) == 1


@pytest.mark.parametrize("dialog", ["g", "f1"])
async def test_leaving_from_a_dialog_saves_and_asks_as_well(dialog: str) -> None:
    saved = Saved()
    async with opened(saved) as driver:
        saved.error = OSError(28, "No space left on device")
        await driver.press("a", dialog, "ctrl+q")
        assert isinstance(driver.app.screen, UnsavedScreen)
        saved.error = None
        await driver.press("enter")
    assert saved[-1][0].state == "accepted"


async def test_a_recording_without_reaches_can_be_labelled() -> None:
    async with opened(Saved(), count=0) as driver:
        assert "No reach was found in this recording." in driver.text
        await driver.press("a", "d", "q", "n", "p", "u", "home", "end")
        await driver.press("pagedown", "full_stop", "comma", "i")
        assert driver.states == ["added"]


async def test_a_time_that_is_none_is_asked_again() -> None:
    async with opened(Saved()) as driver:
        await driver.press("g", *"x", "enter")
        assert isinstance(driver.app.screen, GoToScreen)
        assert "such as 12:30" in driver.text


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("90", 90), ("1:30", 90), ("1:00:01,5", 3601.5), ("", None), ("1:2:3:4", None), ("-3", None)],
)
def test_a_time_is_hours_minutes_and_seconds(text: str, seconds: float | None) -> None:
    assert seconds_of(text) == seconds


@pytest.mark.parametrize("language", ["en", "de", "es"])
async def test_keys_and_sentences_fit_in_every_language(language: str) -> None:
    async with opened(Saved(), language=language) as driver:
        tr = driver.app.tr
        for key in ("a", "d", "i", "e"):
            await driver.press(key)
            assert f"ER {tr('End')}" in driver.rows[-1]
            assert f"QW {tr('Onset')}" in driver.rows[-1]
            assert f"F1 {tr('Help')}" in driver.rows[-1]
            assert f"Z {tr('Undo')}" in driver.rows[-1]
            await driver.saved()
            assert driver.rows[0].endswith(tr("saved"))
        await driver.press("f1")
        assert tr("Press Enter to close this.") in driver.text


async def test_snapshots() -> None:
    folder = Path(__file__).parent / "snapshots"
    small, large = Album(folder, "calm", (80, 24)), Album(folder, "calm-large", (160, 48))
    for album in (small, large):
        async with opened(Saved(), size=album._size) as driver:
            await driver.press("n", "d", "n", "R")
            album.take("correction", driver)
    small.check()
    large.check()


def test_only_the_window_is_drawn_and_holes_are_left_open() -> None:
    speed = Speed(np.array([0.0, 1.0, 2.0, 2.1, 2.2]), np.array([0.0, 9.0, 5.0, 5.0, 5.0]))
    means = mean_speeds(speed, 1.0, 2.2, 12)
    assert np.isnan(means[:10]).all()
    assert means[10:] == pytest.approx([5.0, 5.0])
    assert np.isnan(mean_speeds(speed, 50.0, 60.0, 4)).all()


def test_times_count_from_the_beginning_of_the_recording() -> None:
    time_s = 1_700_000_003.4 + np.arange(0.0, 20.0, 0.1)
    speed = Speed(time_s, np.ones(200))
    first_s = float(time_s[0])
    view = View(first_s - 5.0, first_s + 15.0)
    chart = draw_speed(speed, view, 86, 10, lambda at_s: f"{at_s - first_s:.2f}")
    axis = chart.plain.splitlines()[-1]
    assert axis.split() == ["0.00", "5.00", "10.00"]
    assert axis.index("5.00") + 2 == 6 + 40, "the middle of the window"
