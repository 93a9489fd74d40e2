"""Screens in windows of several sizes; texts are larger where there is room."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path

import pytest
from textual.widgets import OptionList

from sar_tui.app.agent.app import AgentApp
from sar_tui.app.screens.message_panel import large_message
from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.widgets.choice import Choice
from tests.app.app_driver import SHORT, AppDriver, OpenApp, known, open_app, plan
from tests.app.test_agent_view import Link
from tests.examples import first
from tests.sides_task import write_sides

RESTING = {**SHORT, "rest_after_attempts": 1}
SIZES = [(60, 20), (30, 5), (26, 24), (13, 24), (5, 3), (1, 1), (20, 200), (200, 1)]
WIDE_VIEW = """
from rich.text import Text
from sar_tui.widgets.task_view import TaskView


class Wide(TaskView):
    def prompt_lines(self, prompt, width, height):
        assert width >= 60 and height >= 6
        return super().prompt_lines(prompt, width, height)

    def between_attempts(self):
        return self.draw

    def draw(self, width, height, colors):
        assert width >= 60
        return Text("A wide drawing")
"""
Opened = AbstractAsyncContextManager[AppDriver]
Open = Callable[[Path, Catalogue], Opened]


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


@asynccontextmanager
async def home(data: Path, catalogue: Catalogue) -> AsyncIterator[AppDriver]:
    for code in ("P01", "P02"):
        known(data, code)
    async with open_app(data, catalogue) as driver:
        yield driver


def after(*keys: str, task: str = "", opens: str | type = "") -> Open:
    """Return a function that opens home, chooses a task, presses keys, and opens a field."""

    @asynccontextmanager
    async def opened(data: Path, catalogue: Catalogue) -> AsyncIterator[AppDriver]:
        async with home(data, catalogue) as driver:
            if task:
                tasks = driver.app.screen.query_one("#task", OptionList)
                tasks.highlighted = tasks.get_option_index(task)
                await driver.settle()
            await driver.press(*keys)
            if opens:
                driver.app.screen.query(opens).first().focus()
                await driver.press("enter")
            yield driver

    return opened


def session(task: str, *keys: str, **settings: object) -> Open:
    """Return a function that opens a session, and presses keys."""

    @asynccontextmanager
    async def opened(data: Path, catalogue: Catalogue) -> AsyncIterator[AppDriver]:
        planned = make_plan(catalogue, task, ["P01"], settings, seed=7)
        async with open_app(data, catalogue, planned) as driver:
            await driver.wait(300)
            await driver.press(*keys)
            yield driver

    return opened


@asynccontextmanager
async def forced_rest(data: Path, catalogue: Catalogue) -> AsyncIterator[AppDriver]:
    async with session("keyboard", **RESTING)(data, catalogue) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        yield driver


SCREENS: dict[str, tuple[str, Open]] = {
    "home": ("HomeScreen", home),
    "help": ("HelpScreen", after("f1")),
    "new participant": ("NewParticipantScreen", after("down", "down", "enter")),
    "second participant": (
        "SecondParticipantScreen",
        after("right", "right", "right", "enter", task="pairs"),
    ),
    "settings": ("SettingsScreen", after("f2")),
    "list of a setting": ("SettingsScreen", after("f2", opens=Choice)),
    "find a setting": ("FindSettingScreen", after("f2", "/")),
    "reason of a change": ("SaveReasonScreen", after("f2", "end", "7", "ctrl+s")),
    "presets": ("ChoosePresetScreen", after("f2", opens="#preset")),
    "command palette": ("CommandPalette", after("ctrl+p")),
    "sensor check": ("SensorCheckScreen", session("reaching", imu="simulated")),
    "therapist's changes": (
        "AdjustScreen",
        session("keyboard", "enter", "escape", "up", "enter", **SHORT),
    ),
    "forced rest": ("SessionScreen", forced_rest),
    "session": ("SessionScreen", session("keyboard", **SHORT)),
}


@pytest.mark.parametrize("name", first(3, reversed(SCREENS)))
async def test_a_screen_survives_any_size(name: str, data: Path, catalogue: Catalogue) -> None:
    screen, opened = SCREENS[name]
    async with opened(data, catalogue) as driver:
        assert driver.screen_name == screen
        await shrink_and_grow(driver)


@pytest.mark.parametrize("size", first(1, [(1, 1), (30, 5), (20, 200)]))
async def test_it_opens_in_any_size(opened: OpenApp, size: tuple[int, int], data: Path) -> None:
    known(data, "P01")
    async with opened(size=size) as driver:
        for key in ("f1", "escape", "ctrl+p", "escape", "f2"):
            await driver.press(key)
        await driver.resize(80, 24)
        assert driver.screen_name == "HomeScreen"


@pytest.mark.parametrize("task", ["keyboard", "reaching"])
async def test_a_session_has_any_size(opened: OpenApp, task: str, catalogue: Catalogue) -> None:
    settings = {"imu": "simulated"} if task == "reaching" else SHORT
    planned = make_plan(catalogue, task, ["P01"], settings, seed=7)
    async with opened(planned, size=(1, 1)) as driver:
        await driver.press("f1", "escape", "ctrl+p", "escape")
        await driver.resize(80, 24)
        assert driver.screen_name == (
            "SensorCheckScreen" if task == "reaching" else "SessionScreen"
        )


@pytest.mark.slow
async def test_every_stage_survives_any_size(opened: OpenApp, catalogue: Catalogue) -> None:
    settings = SHORT | {"attempts": 1}
    async with opened(make_plan(catalogue, "keyboard", ["P01"], settings, seed=7)) as driver:
        await driver.press("enter")
        await shrink_and_grow(driver)
        await driver.begin()
        await shrink_and_grow(driver)
        driver.see("Paused")
        await driver.press("ctrl+q")
        await shrink_and_grow(driver)
        driver.see("Leave now?")
        await driver.press("enter", "enter")
        await driver.do_attempt(await driver.to_prompt())
        await shrink_and_grow(driver)
        await driver.see_the_summary()
        await shrink_and_grow(driver)
        driver.see("Press Enter to finish.")
        assert driver.session.faults == []


@pytest.mark.slow
async def test_a_session_for_two_survives_any_size(opened: OpenApp, catalogue: Catalogue) -> None:
    settings = SHORT | {"policy": "alternate"}
    async with opened(make_plan(catalogue, "pairs", ["P01", "P02"], settings, seed=7)) as driver:
        await driver.to_first_prompt()
        await shrink_and_grow(driver)
        driver.see("Paused")
        assert driver.session.faults == []


@pytest.mark.slow
async def test_no_view_is_drawn_in_too_small_a_window(data: Path, tmp_path: Path) -> None:
    catalogue = Catalogue(tasks=(write_sides(tmp_path / "mine", WIDE_VIEW).parent,))
    async with open_app(data, catalogue, plan(catalogue, catalogue.task("sides"))) as driver:
        await driver.to_first_prompt()
        await shrink_and_grow(driver)
        await driver.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        driver.see("A wide drawing")
        await shrink_and_grow(driver)
        assert driver.session.faults == []


async def test_the_agent_in_a_window_of_its_own_survives_any_size(calm: Theme) -> None:
    link = Link()
    app = AgentApp(calm, link.join)
    async with app.run_test(size=(80, 24)) as pilot:
        link.welcome()
        for size in SIZES:
            await pilot.resize_terminal(*size)
        assert app.is_running


TEXT = WaitingText(
    "Welcome", "A key appears.\nPress that key.\n\nYou may rest.", "Press Enter to go on.", "Enter"
)


def test_the_key_comes_first_then_air_then_the_headline() -> None:
    def larger(height: int) -> tuple[bool, bool, bool]:
        message = large_message(TEXT, 88, height)
        assert message.press == TEXT.press
        return bool(message.key), message.text != TEXT.text, message.headline != TEXT.headline

    assert larger(10) == (False, False, False)
    assert larger(15) == (True, False, False)
    assert larger(17) == (True, True, False)
    assert larger(30) == (True, True, True)


def test_a_headline_of_several_words_or_without_large_letters_stays_as_it_is() -> None:
    for headline in ("Now level 2.", "Bienvenidísimos", "続き"):
        assert large_message(TEXT._replace(headline=headline), 88, 40).headline == headline


async def test_only_a_large_window_draws_the_key(driver: AppDriver) -> None:
    assert "█" not in driver.text
    await driver.resize(100, 30)
    assert "█" in driver.text
    driver.see("Press that key as fast as you", "Press Enter to go on.")
    await driver.resize(80, 24)
    assert "█" not in driver.text
