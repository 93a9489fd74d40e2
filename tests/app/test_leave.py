"""Ctrl-Q in a session asks first; everywhere else it leaves at once."""

from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import connect
from sar_tui.store.record_changes import BY_MISTAKE, why_discarded
from tests.app.app_driver import OpenApp, OpenSession, known, stored
from tests.examples import first

QUESTION = "Leave now?"


@pytest.mark.parametrize("go_on", first(1, ["enter", "escape"]))
async def test_in_a_trial_it_asks_and_going_on_repeats_the_trial(
    open_session: OpenSession, go_on: str, data: Path
) -> None:
    async with open_session(attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        await driver.press("ctrl+q")
        assert driver.sees(QUESTION)
        assert driver.sees("What you did is kept. You can go on with this session later.")
        assert driver.waiting.stage == "paused"
        await driver.press(go_on)
        assert not driver.sees(QUESTION)
        assert driver.waiting.stage == "trial", "no second Go on is needed"
        again = await driver.to_prompt()
        assert (again.trial, again.stimulus) == (prompt.trial, prompt.stimulus)
        await driver.do_attempt(again)
        await driver.see_the_summary()
    assert stored(data, "SELECT count(*) FROM trials") == [(2,)]
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]


async def test_only_the_second_choice_leaves_and_the_session_can_be_resumed(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.press("ctrl+q", "down", "enter")
        assert not driver.app.is_running
        assert driver.app.return_code in (None, 0)
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert stored(data, "SELECT count(*) FROM trials") == [(1,)]


async def test_keys_that_arrive_together_with_it_are_no_answers(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.write("ctrl+q", "ctrl+q", "ctrl+q")
        assert [type(screen).__name__ for screen in driver.app.screen_stack].count(
            "LeaveScreen"
        ) == 1
        await driver.press("enter")
        await driver.to_prompt()
        await driver.write("ctrl+q", "down", "enter")
        assert driver.sees(QUESTION)
        await driver.press("down", "enter")
        assert not driver.app.is_running


async def test_between_attempts_going_on_changes_nothing(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.press("enter")
        await driver.wait(1500)
        before = driver.text
        await driver.press("ctrl+q")
        assert driver.sees(QUESTION)
        await driver.press("enter")
        assert driver.text == before
        assert driver.messages("operator/act") == []


@pytest.mark.slow
async def test_in_a_pause_going_on_returns_to_the_pause(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.press("escape", "down", "enter")
        before = driver.text
        await driver.press("ctrl+q", "enter")
        assert driver.text == before
        assert driver.sees("Have a rest")


async def test_the_palettes_quit_asks_too(open_session: OpenSession) -> None:
    async with open_session() as driver:
        commands = {
            command.title: command for command in driver.app.get_system_commands(driver.app.screen)
        }
        driver.app.call_later(commands["Quit"].callback)
        await driver.settle()
        assert driver.sees(QUESTION)


async def test_under_a_cover_it_asks_and_the_answer_is_read_when_the_window_is_large_again(
    open_session: OpenSession,
) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.press("ctrl+q")
        await driver.resize(1, 1)
        await driver.resize(80, 24)
        assert driver.sees(QUESTION)
        await driver.press("enter")
        assert driver.waiting.stage == "trial"


async def test_while_the_disk_is_full_it_does_not_say_that_everything_is_kept(
    open_session: OpenSession,
) -> None:
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.disk(False)
        await driver.press("f1", "ctrl+q")
        assert driver.sees(QUESTION)
        assert driver.sees(
            "Your last answer may not be saved yet. If you leave now, it may be lost."
        )
        assert not driver.sees("What you did is kept.")
        await driver.press("enter", "escape")
        await driver.disk(True)
        await driver.press("ctrl+q")
        assert driver.sees("What you did is kept. You can go on with this session later.")


async def test_after_the_session_it_leaves_at_once(open_session: OpenSession, data: Path) -> None:
    async with open_session(attempts=1) as driver:
        await driver.do_session()
        await driver.press("ctrl+q")
        assert not driver.app.is_running
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]


@pytest.mark.parametrize("keys", first(1, [("f2",), (), ("f1",)]))
async def test_without_a_session_it_leaves_at_once(
    opened: OpenApp, keys: tuple[str, ...], data: Path
) -> None:
    known(data)
    async with opened() as driver:
        await driver.press(*keys, "ctrl+q")
        assert not driver.app.is_running


async def test_unsaved_settings_are_discarded_only_by_a_second_press(
    opened: OpenApp, data: Path
) -> None:
    known(data)
    async with opened() as driver:
        await driver.press("f2")
        await driver.write("7")
        await driver.press("ctrl+q")
        assert driver.app.is_running
        assert driver.sees("Not saved. Save with Ctrl-S, or")
        await driver.press("ctrl+q")
        assert not driver.app.is_running


async def test_the_question_is_in_the_sessions_language(open_session: OpenSession) -> None:
    async with open_session(language="es") as driver:
        await driver.press("ctrl+q")
        assert driver.sees("¿Salir ahora?")
        assert driver.sees("Seguir")
        assert driver.sees("Sí, salir")


async def test_a_session_that_was_started_by_mistake_is_discarded_and_can_be_restored(
    opened: OpenApp, open_session: OpenSession, data: Path
) -> None:
    known(data)
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
        await driver.press("ctrl+q")
        assert driver.sees("It was started by mistake")
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
        assert driver.sees("No session yet. START begins the first one.")
        assert driver.sees("started by mistake")
        await driver.press("f6")
        assert driver.sees("Take back")
        await driver.press("delete")
        assert driver.sees("interrupted: Enter resumes")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]


async def test_only_the_first_attempt_can_be_a_mistake(open_session: OpenSession) -> None:
    async with open_session(attempts=2) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.press("ctrl+q")
        assert driver.sees(QUESTION)
        assert not driver.sees("It was started by mistake")


async def test_a_mistake_can_be_said_at_the_end_that_is_chosen_in_a_pause(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session(ask_wellbeing=True) as driver:
        await driver.press("0", "1")
        await driver.to_first_prompt()
        await driver.press("escape", "down", "down", "down", "enter")
        assert driver.sees("It was started by mistake")
        await driver.press("down", "down", "enter")
        await driver.wait(300)
        assert driver.sees("That is all right. This session does not count.")
        assert not driver.sees("Ended early")
        await driver.press("enter")
        assert driver.app.return_code == 0, "nothing more is asked"
    assert stored(data, "SELECT status FROM sessions") == [("discarded",)]
