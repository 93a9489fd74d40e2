"""Ctrl-Q in a session asks first; everywhere else it leaves at once."""

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.app.app import SarTui
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.store.database import connect
from sar_tui.store.record_changes import BY_MISTAKE, why_discarded
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, given, known, stored

QUESTION = "Leave now?"


async def test_in_a_trial_it_asks_and_repeats_the_trial(open_session: OpenSession) -> None:
    async with open_session(attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        await driver.press("ctrl+q")
        driver.see(QUESTION, "What you did is kept. You can go on with this session later.")
        assert driver.waiting.stage == "paused"
        await driver.press("escape")
        driver.lacks(QUESTION)
        assert driver.waiting.stage == "trial", "no second Go on is needed"
        again = await driver.to_prompt()
        assert (again.trial, again.stimulus) == (prompt.trial, prompt.stimulus)
        await driver.finish(again)
    assert driver.stored("SELECT count(*) FROM trials") == [(2,)]
    assert driver.stored("SELECT status FROM sessions") == [("completed",)]


async def test_only_the_second_choice_leaves(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.press("ctrl+q", "down", "enter")
        assert not driver.app.is_running
        assert driver.app.return_code in (None, 0)
    assert driver.stored("SELECT status FROM sessions") == [("interrupted",)]
    assert driver.stored("SELECT count(*) FROM trials") == [(1,)]


async def test_keys_that_arrive_together_with_it_are_no_answers(driver: AppDriver) -> None:
    await driver.to_first_prompt()
    await driver.write("ctrl+q", "ctrl+q", "ctrl+q")
    assert [type(screen).__name__ for screen in driver.app.screen_stack].count("LeaveScreen") == 1
    await driver.press("enter")
    await driver.to_prompt()
    await driver.write("ctrl+q", "down", "enter")
    driver.see(QUESTION)
    await driver.press("down", "enter")
    assert not driver.app.is_running


@pytest.mark.parametrize("keys", [("enter",), ("escape", "down", "enter")])
async def test_elsewhere_going_on_changes_nothing(driver: AppDriver, keys: tuple[str, ...]) -> None:
    await driver.press(*keys)
    await driver.wait(1500)
    before, acts = driver.text, driver.messages("operator/act")
    await driver.press("ctrl+q")
    driver.see(QUESTION)
    await driver.press("enter")
    assert driver.text == before
    assert driver.messages("operator/act") == acts


async def test_with_a_full_disk_nothing_is_said_to_be_kept(driver: AppDriver) -> None:
    await driver.answer(await driver.to_first_prompt())
    await driver.disk(False)
    await driver.press("f1", "ctrl+q")
    driver.see(QUESTION, "Your last answer may not be")
    driver.lacks("What you did is kept.")
    await driver.press("enter", "escape")
    await driver.disk(True)
    await driver.press("ctrl+q")
    driver.see("What you did is kept. You can go on with this session later.")


async def test_after_the_session_it_leaves_at_once(open_session: OpenSession) -> None:
    async with open_session(attempts=1) as driver:
        await driver.do_session()
        await driver.press("ctrl+q")
        assert not driver.app.is_running
    assert driver.stored("SELECT status FROM sessions") == [("completed",)]


async def test_without_a_session_it_leaves_at_once(home: AppDriver) -> None:
    await home.press("f2", "ctrl+q")
    assert not home.app.is_running


async def test_unsaved_settings_are_discarded_only_by_a_second_press(home: AppDriver) -> None:
    await home.press("f2", "pagedown")
    await home.write("7")
    await home.press("ctrl+q")
    assert home.app.is_running
    home.see("Not saved: Prompts per attempt.", "Ctrl-Q again leaves without.")
    await home.press("ctrl+q")
    assert not home.app.is_running


@pytest.mark.slow
async def test_a_session_that_was_started_by_mistake_is_discarded_and_can_be_restored(
    opened: OpenApp, open_session: OpenSession, data: Path
) -> None:
    known(data)
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
        await driver.press("ctrl+q")
        driver.see("It was started by mistake")
        await driver.press("down", "down", "enter")
        assert not driver.app.is_running
        assert (
            "The session does not count, as it was started by mistake."
            in driver.app.leaving.lines(0)[0]
        )
    assert stored(data, "SELECT status FROM sessions") == [("discarded",)]
    assert stored(data, "SELECT count(*) FROM trials") == [(1,)], "nothing is deleted"
    with closing(connect(data)) as database:
        why = why_discarded(database, session)
        assert why is not None
        assert (why.actor, why.reason) == ("participant", BY_MISTAKE)
    async with opened() as driver:
        driver.see("No session yet.", "Begun by mistake today.")
        await driver.press("f6", "delete")
        driver.see("interrupted: Enter resumes")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]


async def test_only_the_first_attempt_can_be_a_mistake(open_session: OpenSession) -> None:
    async with open_session(attempts=2) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.press("ctrl+q")
        driver.see(QUESTION)
        driver.lacks("It was started by mistake")


async def test_a_mistake_can_be_said_in_a_pause(open_session: OpenSession) -> None:
    async with open_session(ask_wellbeing=True) as driver:
        await driver.press(*given("0", "1"))
        await driver.to_first_prompt()
        await driver.press("escape", "down", "down", "down", "enter")
        driver.see("It was started by mistake")
        await driver.press("down", "down", "enter")
        await driver.wait(300)
        driver.see("That is all right", "This session does not count.")
        driver.lacks("Ended early")
        await driver.press("enter")
        assert driver.app.return_code == 0, "nothing more is asked"
    assert driver.stored("SELECT status FROM sessions") == [("discarded",)]


@pytest.mark.parametrize(
    ("task", "settings", "working", "keys"),
    [
        ("keyboard", {}, {"session", "storage"}, ["ctrl+q", "down", "enter"]),
        ("reaching", {"imu": "simulated"}, {"sensor check"}, ["escape"]),
    ],
)
async def test_the_workers_of_a_session_and_of_its_sensor_check_end_with_the_app(
    data: Path,
    catalogue: Catalogue,
    task: str,
    settings: dict[str, Any],
    working: set[str],
    keys: list[str],
) -> None:
    app = SarTui(data, catalogue, make_plan(catalogue, task, ["P01"], settings, seed=7))
    async with app.run_test() as pilot:
        await pilot.pause()
        assert {worker.name for worker in app.workers if worker.is_running} == working
        await pilot.press(*keys)
    app.close_session()
    assert not [worker for worker in app.workers if worker.is_running]
    if app.live:
        assert app.live.unsaved == 0
        assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
