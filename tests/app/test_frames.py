"""A prompt with frames on the session's screen: each frame is drawn in its time, and nothing else
moves.
"""

from pathlib import Path

import pytest
from textual.geometry import Region

from sar_tui.loop.topics import TONE_BEGAN
from sar_tui.model.messages import ToneBegan
from tests.app.app_driver import OpenSession
from tests.app.test_quiet_screen import count_frames

TASK = """
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus


class Masked(Task):
    name = "masked"
    title = "Masked"
    metric = Metric("reaction_time", "ms", "lower")

    def instructions(self):
        return "Look."

    def stimulus(self, situation):
        frames = (Frame("<", 200, text="cue"), Frame("", 300), Frame("O", 50, text="target", timed=True), Frame("#"))
        return Stimulus("masked", "f", "Press: f", frames=frames)

    def perceived(self, trial, percept):
        return Result(correct=True, response=percept.key, response_at=percept.at, value=trial.latency_ms(percept.at))
"""


@pytest.fixture
def masked(tmp_path: Path) -> Path:
    folder = tmp_path / "mytasks" / "masked"
    folder.mkdir(parents=True)
    (folder / "task.py").write_text(TASK, encoding="utf-8")
    return folder


async def test_each_frame_replaces_the_one_before(
    open_task: OpenSession, masked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_task(masked, attempts=1) as driver:
        await driver.to_first_prompt()
        stage = driver.app.screen.query_one("#prompt").region
        driver.see("cue")
        frames = count_frames(driver, monkeypatch)
        await driver.wait(210)
        driver.lacks("cue")
        assert not any(line.strip() for line in driver.rows[stage.y : stage.bottom]), (
            "the second frame is empty"
        )
        await driver.wait(300)
        driver.see("target")
        await driver.wait(50)
        driver.see("#")
        driver.lacks("target")
        await driver.wait(500)
        drawn = [frame for frame in frames if frame is not None]
        assert len(drawn) == 3
        spans = [span for frame in drawn for span in frame.spans]  # type: ignore[attr-defined]
        assert all(
            stage.contains_region(Region(left, y, right - left, 1)) for y, left, right in spans
        )
        await driver.press("f")
        await driver.see_the_summary()
        assert driver.session.faults == []


async def test_unheard_tones_are_told_after_the_attempt(
    open_task: OpenSession, masked: Path
) -> None:
    async with open_task(masked, attempts=2) as driver:
        await driver.to_first_prompt()
        failed = ToneBegan(
            attempt=1, trial=1, presentation=1, frame=0, at=1, source="failed", detail="Plug it in."
        )
        driver.session.bus.post(TONE_BEGAN, failed)
        await driver.wait(600)
        assert not driver.sees("not heard"), "nothing moves in a trial"
        await driver.press("f")
        await driver.wait(500)
        driver.see("The tones of the prompts are not heard.", "Plug it in.")
