"""Faults of a disk, a task or a window are reported in a clear sentence, and lose no data."""

import sqlite3
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from textual.widgets import OptionList

from sar_tui.app import app as app_module
from sar_tui.app.app import SarTui, run_app
from sar_tui.inputs.keyboard import Keyboard
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Result, Trial
from sar_tui.plugins import Catalogue
from sar_tui.store.database import StoreError
from tests.app.app_driver import AppDriver, OpenApp, known, open_app, plan
from tests.examples import first


async def test_a_failed_write_asks_for_the_experimenter(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await driver.disk(False)
    driver.see("Please fetch the experimenter", "Please leave this screen open")
    driver.see("For the experimenter: The disk is full.")
    assert "Press: " not in driver.text

    await driver.press("enter", "escape", prompt.expected)
    await driver.wait(60_000)
    driver.see("Please fetch the experimenter")

    await driver.disk(True)
    driver.see("Thank you for waiting Everything is saved again.", "Press Enter to go on.")
    await driver.press("enter")
    assert (await driver.to_prompt()).text == prompt.text
    await driver.answer(prompt)
    assert driver.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_a_task_that_raises_asks_for_the_experimenter_and_the_app_fails(
    opened: OpenApp, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    class Loose(keyboard):  # type: ignore[valid-type, misc]
        def perceived(self, trial: Trial, percept: Any) -> Result:
            if trial.situation.trial == 2:
                raise RuntimeError("a wire is loose")
            return Result(correct=True, response=percept.key, response_at=percept.at, value=1.0)

    async with opened(plan(catalogue, Loose)) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        driver.see("Please fetch the experimenter", "Everything you did is kept.")
        assert "wire" not in driver.text
        assert "Traceback" not in driver.text
        driver.see("Press Enter to close.")
        await driver.press("enter")
        assert not driver.app.is_running
        assert driver.app.return_code == 1
        assert "The task keyboard failed" in driver.app.failure
        assert "a wire is loose" in driver.app.failure
    assert driver.stored("SELECT status FROM sessions") == [("interrupted",)]
    assert driver.stored("SELECT count(*) FROM trials") == [(1,)]


@pytest.mark.parametrize("member", first(1, ["instructions", "goal", "trials_per_attempt"]))
async def test_a_task_that_raises_before_its_first_screen_asks_for_the_experimenter(
    opened: OpenApp, catalogue: Catalogue, keyboard: type[Task], member: str
) -> None:
    def fail(*_: object) -> str:
        raise RuntimeError("a wire is loose")

    body = {member: property(fail) if member == "trials_per_attempt" else fail}
    loose = type("Loose", (keyboard,), body | {"__module__": __name__})
    async with opened(plan(catalogue, loose)) as driver:
        await driver.wait(1000)
        driver.see("Please fetch the experimenter", "Press Enter to close.")
        await driver.press("enter")
        assert "The task keyboard failed (RuntimeError: a wire is loose" in driver.app.failure


async def test_a_task_that_is_not_set_up_is_told(data: Path, catalogue: Catalogue) -> None:
    class Missing(Catalogue):
        def task(self, name: str) -> type[Task]:
            class Unplugged(catalogue.task(name)):  # type: ignore[misc]
                def __init__(self, parameters: object) -> None:
                    raise OSError("no sensor")

            return Unplugged

    known(data, "P01")
    async with open_app(data, Missing()) as driver:
        await driver.fail_to_start("cannot be set up (OSError: no sensor)")


async def test_too_small_a_window_is_covered_once_and_recovers(opened: OpenApp) -> None:
    def covers() -> int:
        screens = [type(screen).__name__ for screen in driver.app.screen_stack]
        return screens.count("TooSmallScreen")

    async with opened(size=(79, 24)) as driver:
        driver.see("It has 79 by 24 characters; 80 by 24 are needed.")
        await driver.press("f1")
        await driver.resize(60, 20)
        assert covers() == 1
        await driver.press("escape")
        driver.see("It has 60 by 20 characters; 80 by 24 are needed.")
        await driver.resize(80, 24)
        assert driver.screen_name == "HomeScreen"
        await driver.resize(80, 23)
        assert covers() == 1
        await driver.press("f1")
        await driver.resize(120, 40)
        await driver.press("escape")
        assert driver.screen_name == "HomeScreen"
        driver.see("+ New participant")


def _refuse(driver: AppDriver) -> None:
    """Make all further writes of the app fail."""
    driver.app.database.execute("PRAGMA query_only=ON")


@pytest.mark.slow
async def test_a_failure_to_save_settings_is_reported_and_the_form_stays(home: AppDriver) -> None:
    await home.press("f2", "pagedown", "end", "7")
    _refuse(home)
    await home.press("ctrl+s", "x", "enter")
    assert home.screen_name == "SettingsScreen"
    home.see("is read-only", "Not saved.", "◆ 1 not saved")


async def test_a_failed_write_is_reported_on_the_home_screen(home: AppDriver) -> None:
    _refuse(home)
    home.app.screen.query_one("#theme", OptionList).highlighted = 2
    await home.fail_to_start("is read-only")


@pytest.mark.slow
async def test_a_failure_to_store_a_new_session_is_reported_on_the_home_screen(
    opened: OpenApp, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("disk I/O error")

    known(data, "P01")
    monkeypatch.setattr("sar_tui.store.sessions.create", refuse)
    async with opened() as driver:
        await driver.fail_to_start("disk I/O error")


@pytest.mark.slow
async def test_an_unsaved_code_stays(opened: OpenApp, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise StoreError("The disk is full.")

    monkeypatch.setattr("sar_tui.store.participants.add", refuse)
    async with opened() as driver:
        await driver.press("enter")
        await driver.enter("P07")
        assert driver.screen_name == "NewParticipantScreen"
        driver.see("The disk is full.", "P07")


@pytest.mark.slow
async def test_unsaved_messages_are_reported_when_the_session_is_left(
    opened: OpenApp, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse() -> None:
        raise StoreError("The disk is full.")

    known(data, "P01")
    async with opened() as driver:
        await driver.press("right", "right", "right", "enter")
        await driver.do_session()
        assert driver.app.live
        monkeypatch.setattr(driver.app.live.run.recorder, "write", refuse)
        driver.app.live.keyboard.focused(True, 1.0)
        await driver.settle()
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        driver.see("The session's last messages could not be written")


async def test_a_session_whose_disk_is_too_slow_stays_locked_and_unsaved(
    data: Path, catalogue: Catalogue, keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    app = SarTui(data, catalogue, plan(catalogue, keyboard))
    async with app.run_test() as pilot:
        await pilot.pause()
        assert app.live
        run = app.live.run
        closed: list[bool] = []
        close = run.close
        monkeypatch.setattr(run.recorder, "wait", lambda seconds: False)
        monkeypatch.setattr(run, "close", lambda: closed.append(True))
        app.close_session()
        assert closed == []
    close()


@pytest.mark.parametrize(
    ("failure", "rescued", "code"),
    [("", "", 0), ("The task failed.", "", 1), ("", "The session goes on elsewhere.", 1)],
    ids=["as intended", "failed", "not in the database"],
)
def test_the_exit_code_reports_a_failure_however_the_app_was_left(
    failure: str,
    rescued: str,
    code: int,
    data: Path,
    catalogue: Catalogue,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    live = SimpleNamespace(
        unsaved=0, rescued=rescued, can_be_joined=False, is_mistake=False, is_closed=True,
        trouble="", run=SimpleNamespace(id="x"), session=SimpleNamespace(ended=True, broken=None),
        close=lambda app: None,
    )  # fmt: skip

    async def left(app: SarTui) -> None:
        app.failure = failure
        app.live = live  # type: ignore[assignment]

    monkeypatch.setattr(app_module.SarTui, "run_async", left)
    monkeypatch.setattr("sar_tui.tui.base_app.stamp_keys_as_read", lambda: None)
    assert run_app(data, catalogue) == code


def test_keys_before_the_start_of_a_session_are_ignored() -> None:
    keyboard = Keyboard()
    keyboard.pressed("f", "f", 1.0)
    keyboard.pasted(3, 1.0)
    keyboard.focused(False, 1.0)
