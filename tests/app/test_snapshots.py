"""Snapshots of the screens at 80 by 24, as plain text.

They are kept in ``snapshots/``. ``SAR_TUI_UPDATE_SNAPSHOTS=1`` updates them; then read the diff.
"""

from datetime import date
from pathlib import Path

import pytest

from tests.album import Album
from tests.app.app_driver import OpenApp, OpenSession


@pytest.fixture(autouse=True)
def friday(monkeypatch: pytest.MonkeyPatch) -> None:
    """The date that the home screen shows."""
    monkeypatch.setattr("sar_tui.app.app.SarTui.today", staticmethod(lambda: date(2026, 3, 20)))


@pytest.fixture
def album() -> Album:
    return Album(Path(__file__).parent / "snapshots", "calm", (80, 24))


@pytest.mark.slow
async def test_snapshots_of_home_and_settings(opened: OpenApp, album: Album) -> None:
    async with opened() as driver:
        album.take("home", driver)
        await driver.press("f1")
        album.take("help", driver)
        await driver.press("enter", "enter")
        await driver.write(*"Peter Maier")
        album.take("new-participant", driver)
        await driver.press("ctrl+u")
        await driver.enter("p01")
        album.take("home-with-a-participant", driver)
        await driver.press("f2")
        await driver.app.workers.wait_for_complete()
        await driver.settle()
        album.take("settings", driver)
        await driver.press("pagedown", "end")
        await driver.write("x")
        album.take("settings-to-fix", driver)
        await driver.press("f5")
        album.take("settings-versions", driver)
        await driver.press("escape")
        await driver.resize(60, 20)
        album.take("too-small", driver)
    album.check()


async def test_snapshots_of_a_session(open_session: OpenSession, album: Album) -> None:
    async with open_session(attempts=4, practice_attempts=1) as driver:
        album.take("instructions", driver)
        await driver.press("enter")
        album.take("before-practice", driver)
        prompt = await driver.begin()
        album.take("prompt", driver)
        await driver.answer(prompt)
        album.take("between-prompts", driver)
        await driver.to_prompt()
        await driver.press("escape")
        album.take("paused", driver)
        for name in ("tired", "in-pain", "end-now"):
            await driver.press("down", "enter")
            album.take(name, driver)
        await driver.press("ctrl+q")
        album.take("leave-now", driver)
        await driver.press("escape", "enter")
        await driver.answer(await driver.to_prompt())
        album.take("before-an-attempt", driver)
        await driver.do_attempt(await driver.begin())
        await driver.begin()
        await driver.disk(False)
        album.take("disk-full", driver)
        await driver.disk(True)
        album.take("disk-works-again", driver)
        await driver.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        await driver.answer(await driver.begin(), after_ms=1900)
        await driver.answer(await driver.to_prompt(), after_ms=900)
        await driver.begin()
        await driver.wait(6000)
        await driver.to_prompt()
        await driver.wait(6000)
        album.take("review", driver)
        await driver.see_the_summary()
        await driver.wait(8000)  # the last gestures end
        album.take("summary", driver)
    album.check()


async def test_snapshots_of_the_questions_on_pain(open_session: OpenSession, album: Album) -> None:
    async with open_session(ask_wellbeing=True) as driver:
        await driver.press("6")
        album.take("pain", driver)
        await driver.press("enter")
        album.take("pain-place", driver)
        await driver.press("3", "enter", "tab")
        album.take("pain-advice", driver)
    album.check()
