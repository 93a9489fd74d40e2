"""Screens in windows of several sizes; texts are larger where there is room."""

from pathlib import Path

import pytest

from sar_tui.app.agent.app import AgentApp
from sar_tui.app.screens.message_panel import spread
from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.widgets.choice import Choice
from tests.app.app_driver import AppDriver, OpenApp, OpenSession
from tests.app.test_agent_view import Link
from tests.app.test_progress import open_progress, trained

SIZES = [(60, 20), (13, 24), (1, 1), (20, 200), (200, 1)]


async def shrink_and_grow(driver: AppDriver) -> None:
    """Make the window each size in turn; in the end, the first again, with the same screen in
    it.
    """
    before = driver.screen_name
    driver.app.notify(
        "A notice of some length, so that it takes more than one line.", title="Note", timeout=1000
    )
    for size in SIZES:
        await driver.resize(*size)
    await driver.resize(80, 24)
    driver.app.clear_notifications()
    await driver.settle()
    assert driver.app.is_running
    assert driver.screen_name == before


@pytest.mark.slow
async def test_home_and_the_settings_survive_any_size(home: AppDriver) -> None:
    await shrink_and_grow(home)
    await home.press("f2")
    home.app.screen.query(Choice).first().focus()
    await home.press("enter")
    await shrink_and_grow(home)
    assert home.screen_name == "SettingsScreen"


@pytest.mark.slow
async def test_progress_survives_any_size(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    trained(data, catalogue, 1000, 1000)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        for _ in range(3):
            await shrink_and_grow(driver)
            await driver.press("shift+tab")
        await driver.press("enter")
        await shrink_and_grow(driver)
        assert driver.screen_name == "ExplanationScreen"


@pytest.mark.slow
async def test_the_sensor_check_opens_in_any_size(opened: OpenApp, catalogue: Catalogue) -> None:
    settings = {"imu": "simulated"}
    planned = make_plan(catalogue, "reaching", ["P01"], settings, seed=7)
    async with opened(planned, size=(1, 1)) as driver:
        await driver.press("f1", "escape", "ctrl+p", "escape")
        await driver.resize(80, 24)
        assert driver.screen_name == "SensorCheckScreen"
        await shrink_and_grow(driver)


@pytest.mark.slow
async def test_every_stage_of_a_session_survives_any_size(open_session: OpenSession) -> None:
    async with open_session(rest_after_attempts=1, rest_seconds=600) as driver:
        await shrink_and_grow(driver)
        await driver.to_first_prompt()
        await shrink_and_grow(driver)
        driver.see("Paused")
        await driver.press("up", "enter")
        assert driver.screen_name == "AdjustScreen"
        await shrink_and_grow(driver)
        await driver.press("escape", "enter")
        await driver.do_attempt(await driver.to_prompt())
        await shrink_and_grow(driver)
        driver.see("A short rest")
        await driver.press("ctrl+q")
        await shrink_and_grow(driver)
        driver.see("Leave now?")
        assert driver.session.faults == []


async def test_the_agent_in_a_window_of_its_own_survives_any_size(calm: Theme) -> None:
    link = Link()
    app = AgentApp(calm, link.join)
    async with app.run_test(size=(80, 24)) as pilot:
        link.welcome()
        for size in SIZES:
            await pilot.resize_terminal(*size)
        assert app.is_running


TEXT = WaitingText("Welcome", "A key appears.\nPress that key.\n\nYou may rest.", "Press Enter.")


def test_air_between_lines_comes_first_then_rows_for_the_headline() -> None:
    assert spread(TEXT, 88, 6) == (TEXT.text, 1)
    airy = "A key appears.\n\nPress that key.\n\nYou may rest."
    assert spread(TEXT, 88, 7) == (airy, 1)
    assert spread(TEXT, 88, 11) == (airy, 5)


async def test_only_a_large_window_draws_the_headline_and_the_key(driver: AppDriver) -> None:
    assert "█" not in driver.text
    await driver.resize(100, 30)
    assert "█" in driver.text
    assert "▄▄▄▄▄▄▄▄▄" in driver.text
    driver.see("Press that key as fast as you")
    await driver.resize(80, 24)
    assert "█" not in driver.text
    driver.see("Press Enter to go on.")
