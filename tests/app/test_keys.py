"""Keys reach the loop only from the screens of a session; help and the palette name those of a screen."""

from pathlib import Path

import pytest
from textual.events import AppBlur, AppFocus, Paste

from tests.app.app_driver import AppDriver, OpenApp, OpenSession, known


def flags_of_the_trial(driver: AppDriver) -> str:
    """Return the flags in the only trial's timing, as JSON."""
    ((flags,),) = driver.stored("SELECT json_extract(timing, '$.flags') FROM trials")
    return str(flags)


@pytest.mark.slow
async def test_characters_typed_into_forms_and_the_palette_are_never_recorded(
    first_run: AppDriver,
) -> None:
    await first_run.press("enter")
    await first_run.enter("secret7")
    await first_run.press("f2", "end", "backspace")
    await first_run.write(*"1")
    await first_run.press("ctrl+s")
    await first_run.enter("secret8")
    await first_run.press("escape", "right", "right", "enter")
    first_run.see("Welcome")
    await first_run.press("ctrl+p")
    await first_run.write(*"secret9")
    await first_run.press("escape", "enter")
    assert [press["key"] for press in first_run.messages("input/key")] == ["enter"]
    events = first_run.stored("SELECT message FROM events")
    assert not [text for (text,) in events if "secret" in text.lower()]


async def test_nothing_is_recorded_after_a_session_is_left(opened: OpenApp, data: Path) -> None:
    known(data, "P01", attempts=1, prompts_per_attempt=1)
    async with opened() as driver:
        await driver.press("right", "right", "right", "enter")
        await driver.do_session()
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        before = driver.stored("SELECT count(*) FROM events")
        driver.app.screen.query_one("#participant").focus()
        await driver.press("up", "enter")
        await driver.write(*"p02")
        await driver.send_event(AppBlur())
        await driver.send_event(AppFocus())
        assert driver.stored("SELECT count(*) FROM events") == before


async def test_a_question_mark_opens_help_except_in_a_trial(open_session: OpenSession) -> None:
    async with open_session(levels="?x") as driver:
        await driver.press("?")
        assert driver.screen_name == "HelpScreen"
        driver.see("Press that key as fast as you", "To pause, press Escape", "Ctrl-Q Quit")
        driver.see("Ctrl-P Everything that can be done here")
        await driver.press("enter")
        driver.see("Press Enter to go on.")
        await driver.to_first_prompt()
        await driver.wait(400)
        await driver.press("?")
        assert driver.screen_name == "SessionScreen"
        assert driver.stored("SELECT response FROM trials") == [("?",)]


@pytest.mark.parametrize("key", ["q", "tab"])
async def test_any_other_key_in_a_trial_is_only_a_response(driver: AppDriver, key: str) -> None:
    await driver.to_first_prompt()
    await driver.wait(400)
    await driver.press(key)
    assert driver.stored("SELECT response, correct FROM trials") == [(key, 0)]
    assert driver.screen_name == "SessionScreen"
    assert driver.app.focused is None


async def test_pasted_text_is_no_response_and_only_its_length_is_stored(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await driver.send_event(Paste(prompt.expected + "ord7"))
    assert [paste["length"] for paste in driver.messages("input/paste")] == [5]
    assert not any("ord7" in text for (text,) in driver.stored("SELECT message FROM events"))
    await driver.answer(prompt)
    assert "paste" in flags_of_the_trial(driver)


async def test_a_window_that_loses_the_focus_flags_the_trial(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await driver.send_event(AppBlur())
    await driver.send_event(AppFocus())
    assert [change["focused"] for change in driver.messages("input/focus")] == [False, True]
    await driver.answer(prompt)
    assert "focus_lost" in flags_of_the_trial(driver)


async def test_help_and_the_palette_describe_a_screen_and_its_keys(first_run: AppDriver) -> None:
    await first_run.press("?")
    first_run.see("People who need a look come first", "F2 Settings", "Ctrl-Q Quit")
    for keys in (("enter",), ("f1", "f1")):
        await first_run.press(*keys)
        assert first_run.screen_name == "HomeScreen"
    await first_run.press("ctrl+p")
    first_run.see("Help", "New participant", "Settings", "Progress", "Sessions", "Quit")
    await first_run.write(*"theme")
    first_run.see("Theme: Calm", "Theme: High contrast")


async def test_in_a_session_the_palette_offers_no_theme(driver: AppDriver) -> None:
    await driver.press("ctrl+p")
    driver.see("Quit")
    driver.lacks("Theme:")
