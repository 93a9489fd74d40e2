"""The app opens with the frame of the home screen; its lists are filled after that, and no key is
lost.
"""

import gc
import subprocess
import sys
from pathlib import Path

import pytest
from textual.events import Key

from sar_tui.app.app import SarTui
from sar_tui.app.screens.home import HomeScreen
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from tests.app.app_driver import AppDriver, OpenApp, known, stored
from tests.settle import settle

LATER = {
    "sar_tui.loop.task", "sar_tui.model.messages", "sar_tui.loop.session", "sar_tui.store.sessions",
    "sar_tui.outputs.node", "sar_tui.runs.run", "sar_tui.app.live", "importlib.metadata",
    "filelock", "sqlite_utils", "pyfiglet",
}  # fmt: skip
"""Modules that the frame of the home screen does not need."""


def test_modules_that_the_empty_home_screen_does_not_need_are_not_loaded_before_it_is_shown() -> (
    None
):
    script = (
        "import sys; from sar_tui.app.app import SarTui; from sar_tui.app.screens.home import "
        "HomeScreen; "
        "HomeScreen(); print(*sys.modules)"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "sar_tui.theme_folder" in loaded
    assert not LATER & set(loaded)


async def test_the_frame_of_the_home_screen_is_shown_before_it_is_filled(
    opened: OpenApp, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known(data, "P01")
    seen: list[str] = []
    fill = HomeScreen.fill

    async def see_and_fill(home: HomeScreen) -> None:
        driver = AppDriver(home.app, VirtualClock(SECOND))
        seen.append(driver.text)
        await fill(home)

    monkeypatch.setattr(HomeScreen, "fill", see_and_fill)
    async with opened() as driver:
        assert len(seen) == 1
        assert all(heading in seen[0] for heading in ("sar-tui", "People"))
        assert "START" not in seen[0]
        assert "P01" not in seen[0]
        driver.see("P01", "Keyboard reaction", "No session yet. START begins the first one.")


async def test_early_keys_act_on_the_filled_lists(data: Path, catalogue: Catalogue) -> None:
    known(data, "P02")
    known(data, "P01")
    app = SarTui(data, catalogue, clock=(clock := VirtualClock(SECOND)))
    driver = AppDriver(app, clock)
    for key in ("down", "right", "right", "right", "enter"):
        app.post_message(Key(key, None))
    async with app.run_test(size=(80, 24)) as driver.pilot:
        await driver.settle()
        driver.see("Welcome")
    app.close_session()
    assert stored(data, "SELECT participant FROM seats") == [("P02",)]


async def test_an_early_ctrl_q_ends_the_app(data: Path, catalogue: Catalogue) -> None:
    app = SarTui(data, catalogue)
    app.post_message(Key("ctrl+q", None))
    async with app.run_test(size=(80, 24)):
        await settle(app)
        assert not app.is_running
        assert app.return_code == 0


async def test_at_home_garbage_is_freed(opened: OpenApp, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sar_tui.tui.gc_control.gc", gc)
    gc.disable()
    try:
        async with opened():
            assert gc.isenabled()
    finally:
        gc.enable()
        gc.unfreeze()
