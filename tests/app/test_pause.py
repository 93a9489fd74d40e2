"""A pause is possible at any time without confirmation; ending needs one."""

import pytest

from tests.app.app_driver import AppDriver, OpenSession
from tests.recorded import said


async def test_escape_pauses_a_trial_and_repeats_it(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await driver.press("escape")
    driver.see("Paused")
    assert "Press: " not in driver.text
    assert [voided["trial"] for voided in driver.messages("event_handler/voided")] == [1]

    await driver.wait(60_000)
    await driver.press("enter")
    again = await driver.to_prompt()
    found = (again.trial, again.text, again.presentation)
    assert found == (1, prompt.text, prompt.presentation + 1)
    await driver.answer(again)
    assert driver.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_escape_pauses_before_an_attempt_and_returns_there(driver: AppDriver) -> None:
    for words in ("Press Enter to go on.", "Press Enter to begin attempt 1 of 2."):
        driver.see(words)
        await driver.press("escape")
        driver.see("Take your time.")
        await driver.press("enter")
        driver.see(words)
        await driver.press("enter")


async def test_the_menu_is_used_with_arrows_and_enter(driver: AppDriver) -> None:
    await driver.to_first_prompt()
    await driver.press("escape")
    await driver.press("down", "enter", "escape")
    assert driver.sees("Have a rest"), "a second Escape changes nothing"
    await driver.press("down", "enter")
    await driver.press("enter")
    await driver.to_prompt()
    reasons = [
        act["reason"] for act in driver.messages("operator/act") if act["command"] == "pause"
    ]
    assert reasons == ["", "tired", "pain"]
    here = (driver.session_id, "A", "P01")
    assert driver.stored("SELECT DISTINCT session, seat, participant FROM records") == [here]
    assert said(driver.app.database) == [
        ("pause", "tiredness", "told in a pause"),
        ("pause", "pain", "told in a pause"),
    ]


async def test_the_agent_rests_with_the_participant(driver: AppDriver) -> None:
    await driver.do_attempt(await driver.to_first_prompt())
    assert driver.said
    assert "G O A L   R E A C H E D" in driver.text
    said = driver.said
    await driver.press("escape")
    assert driver.said == ""
    await driver.press("enter")
    assert driver.said == said
    await driver.press("escape", "down", "enter")
    assert driver.said == ""
    assert "─   ─ z" in driver.text, "it sleeps"
    await driver.press("down", "enter")
    assert "●   ●" in driver.text
    assert "─   ─ z" not in driver.text
    await driver.press("enter")
    assert "G O A L   R E A C H E D" not in driver.text, "no result without its words"
    driver.see("Your goal: ")


@pytest.mark.parametrize(("keys", "goes_on"), [(["enter"], True), (["down", "enter"], False)])
async def test_only_ending_asks_for_confirmation(
    open_session: OpenSession, keys: list[str], goes_on: bool
) -> None:
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.press("escape", "up", "up", "enter")
        driver.see("End the session now?")
        assert not driver.session.ended
        await driver.press(*keys)
        assert driver.session.ended is not goes_on
        if not goes_on:
            driver.see("No attempt was finished. That is all right.")
            await driver.wait(300)
            await driver.press("enter")
            assert driver.app.return_code == 0
    assert driver.stored("SELECT status FROM sessions") == [
        ("interrupted" if goes_on else "aborted",)
    ]
    assert driver.stored("SELECT count(*) FROM trials") == [(1,)]


async def test_help_over_a_trial_pauses_it(driver: AppDriver) -> None:
    await driver.to_first_prompt()
    await driver.press("f1")
    assert "Press: " not in driver.text
    assert driver.waiting.stage == "paused"
    await driver.press("escape")
    driver.see("Paused")
    await driver.press("enter")
    assert (await driver.to_prompt()).presentation == 2


async def test_a_window_made_too_small_pauses_a_trial_and_recovers(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await driver.resize(79, 24)
    driver.see("This window is too small.", "It has 79 by 24 characters; 80 by 24 are needed.")
    await driver.press(prompt.expected, "enter")
    await driver.resize(100, 30)
    driver.see("Paused")
    await driver.press("enter")
    assert (await driver.to_prompt()).text == prompt.text
    assert prompt.text in driver.text
    assert driver.stored("SELECT * FROM trials") == []
