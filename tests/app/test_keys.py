"""Which keys reach the loop: those pressed on a session's screen, as what they are."""

from pathlib import Path

import pytest
from textual.events import AppBlur, AppFocus, Paste

from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.app.chair import known, plan, sit_down, stored


async def test_what_is_typed_into_a_form_is_never_among_the_events(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("enter")
        await chair.write(*"secret7")
        await chair.press("enter", "f2", "end", "backspace", "backspace")
        await chair.write(*"1")
        await chair.press("tab", "tab", "tab")
        await chair.write(*"fj asdf")
        await chair.press("ctrl+s", "escape", "right", "right", "enter")
        assert chair.sees("Welcome")
        await chair.press("enter")
        assert [press["key"] for press in chair.messages("input/key")] == ["enter"]
        assert not any("SECRET7" in text for (text,) in chair.stored("SELECT message FROM events"))


async def test_nothing_is_recorded_after_a_session_is_left(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=1, prompts_per_attempt=1)
    async with sit_down(data, catalogue) as chair:
        await chair.press("right", "right", "right", "enter")
        await chair.do_session()
        await chair.press("enter")
        assert chair.screen_name == "HomeScreen"
        before = chair.stored("SELECT count(*) FROM events")
        chair.app.screen.query_one("#participant").focus()
        await chair.press("up", "enter")
        await chair.write(*"p02")
        await chair.tell(AppBlur())
        await chair.tell(AppFocus())
        assert chair.stored("SELECT count(*) FROM events") == before


async def test_what_is_typed_into_the_palette_is_never_among_the_events(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press("ctrl+p")
        await chair.write(*"help")
        await chair.press("escape")
        assert [press["key"] for press in chair.messages("input/key")] == ["enter", "enter"]


async def test_a_question_mark_asks_for_help_but_in_a_trial_it_is_a_response(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, levels="?x")) as chair:
        await chair.press("?")
        assert chair.screen_name == "HelpScreen"
        assert chair.sees("Press that key as fast as you can, and then wait for the next one.")
        assert chair.sees("To pause, press Escape; nothing is lost.")
        await chair.press("enter")
        assert chair.sees("Press Enter to go on.")
        await chair.to_first_prompt()
        await chair.wait(400)
        await chair.press("?")
        assert chair.screen_name == "SessionScreen"
        assert chair.stored("SELECT response FROM trials") == [("?",)]


@pytest.mark.parametrize("key", ["q", "space", "tab", "left", "backspace"])
async def test_any_other_key_in_a_trial_is_a_response_and_nothing_else(
    key: str, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.wait(400)
        await chair.press(key)
        assert chair.stored("SELECT response, correct FROM trials") == [(key, 0)]
        assert chair.screen_name == "SessionScreen"
        assert chair.app.focused is None


async def test_pasted_text_is_a_paste_and_no_response_and_only_its_length_is_kept(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.tell(Paste(prompt.expected + "ord7"))
        assert [paste["length"] for paste in chair.messages("input/paste")] == [5]
        assert not any("ord7" in text for (text,) in chair.stored("SELECT message FROM events"))
        await chair.answer(prompt)
        ((flags,),) = chair.stored("SELECT json_extract(timing, '$.flags') FROM trials")
        assert "paste" in flags


async def test_a_window_that_loses_the_focus_is_an_event_and_flags_the_trial(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.tell(AppBlur())
        await chair.tell(AppFocus())
        assert [change["focused"] for change in chair.messages("input/focus")] == [False, True]
        await chair.answer(prompt)
        ((flags,),) = chair.stored("SELECT json_extract(timing, '$.flags') FROM trials")
        assert "focus_lost" in flags


async def test_quitting_in_a_trial_leaves_a_session_to_go_on_with(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.answer(await chair.to_first_prompt())
        await chair.to_prompt()
        await chair.press("ctrl+q")
        assert not chair.app.is_running
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert stored(data, "SELECT count(*) FROM trials") == [(1,)]


async def test_ctrl_c_stops_the_app_anywhere_with_its_own_exit_code(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press("ctrl+c")
        assert chair.app.return_code == 130
    async with sit_down(data, catalogue) as chair:
        await chair.press("ctrl+c")
        assert chair.app.return_code == 130
