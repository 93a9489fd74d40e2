"""Draws six screens in a small and in a large window: ``python -m docs.screens [FOLDER]``."""

import asyncio
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

from docs.pictures import IMAGES, TODAY, demonstration, save, settle
from sar_tui.app.app import SarTui
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.demonstration import make_demonstration
from sar_tui.runs.plan import make_plan

SIZES = ((80, 24), (160, 48))
SETTINGS = {
    "prompts_per_attempt": 3,
    "attempts": 10,
    "ask_wellbeing": True,
    "threshold": 700.0,
    "days_between_visits": 2,
}
RESPONSE_MS, SLOW_MS, SLOW_ATTEMPT = 450, 900, 4
"""Response times; in one attempt they miss the goal."""


async def draw(folder: Path) -> None:
    """Draw all screens into a folder."""
    catalogue = Catalogue()
    with tempfile.TemporaryDirectory() as data:
        shown = Path(data) / "demonstration"
        make_demonstration(shown, TODAY)
        for size in SIZES:
            await _therapist(shown, catalogue, folder, size)
            await _participant(Path(data) / f"{size[0]}", catalogue, folder, size)


async def _therapist(data: Path, catalogue: Catalogue, folder: Path, size: tuple[int, int]) -> None:
    """The first screen, a person's progress and settings."""
    clock = VirtualClock(SECOND)
    app = demonstration(data, catalogue, clock)
    async with app.run_test(size=size) as pilot:
        await settle(pilot, clock)
        save(app, _name("home", size), folder)
        for key, name in (("f4", "progress"), ("f2", "settings")):
            await pilot.press(key)
            for _ in range(20):
                await settle(pilot, clock)
            save(app, _name(name, size), folder)
            await pilot.press("escape")
            await settle(pilot, clock)


async def _participant(
    data: Path, catalogue: Catalogue, folder: Path, size: tuple[int, int]
) -> None:
    """A session with questions about pain, from before it to its summary."""
    clock = VirtualClock(SECOND)
    app = SarTui(
        data, catalogue, make_plan(catalogue, "keyboard", ["P07"], SETTINGS, seed=3), clock
    )
    async with app.run_test(size=size) as pilot:

        async def wait(ms: int) -> None:
            for _ in range(ms // 50):
                clock.advance(50 * MS)
                await pilot.pause()

        await wait(1000)
        await pilot.press("2")
        await wait(100)
        save(app, _name("pain", size), folder)
        for key in ("enter", "3", "enter", "2", "enter"):
            await wait(800)
            await pilot.press(key)
        trials = 0
        while not _ended(app):
            waiting = _waiting(app)
            if waiting == "response":
                is_slow = trials // SETTINGS["prompts_per_attempt"] + 1 == SLOW_ATTEMPT  # type: ignore[operator]
                clock.advance((SLOW_MS if is_slow else RESPONSE_MS) * MS)
                await pilot.press(_prompted(app))
                trials += 1
            elif waiting == "enter":
                await wait(2500)
                if trials == 6:
                    save(app, _name("feedback", size), folder)
                await pilot.press("enter")
            await wait(50)
        await wait(6000)
        save(app, _name("summary", size), folder)


def _waiting(app: SarTui) -> str:
    waiting = getattr(getattr(app.screen, "stage", None), "waiting", None)
    return waiting.what if waiting else ""


def _ended(app: SarTui) -> bool:
    return _waiting(app) == "nothing"


def _prompted(app: SarTui) -> str:
    """Return the key that is asked for."""
    text = app.export_screenshot().replace("&#160;", " ")
    found: Any = re.search(r"Press: (\S) *<", text)
    return str(found[1])


def _name(screen: str, size: tuple[int, int]) -> str:
    return f"{screen}-{size[0]}x{size[1]}"


if __name__ == "__main__":
    asyncio.run(draw(Path(sys.argv[1]) if len(sys.argv) > 1 else IMAGES / "screens"))
