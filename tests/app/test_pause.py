"""A pause: at once, unconfirmed, in the middle of anything; only ending asks again."""

from pathlib import Path

import pytest

from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.app.chair import plan, sit_down, stored


async def test_escape_pauses_at_once_in_mid_trial_and_the_trial_is_repeated(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.press("escape")
        assert chair.sees("Paused")
        assert "Press: " not in chair.text
        assert [voided["trial"] for voided in chair.messages("event_handler/voided")] == [1]

        await chair.wait(60_000)
        await chair.press("enter")
        again = await chair.to_prompt()
        assert (again.trial, again.text, again.presentation) == (1, prompt.text, prompt.presentation + 1)
        await chair.answer(again)
        assert chair.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_escape_pauses_before_an_attempt_too_and_leads_back_there(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        for words in ("Press Enter to go on.", "Press Enter to begin attempt 1 of 2."):
            assert chair.sees(words)
            await chair.press("escape")
            assert chair.sees("Take your time.")
            await chair.press("enter")
            assert chair.sees(words)
            await chair.press("enter")


async def test_the_menu_is_gone_through_with_arrows_and_enter(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press("escape")
        for choice in ("Go on", "I am tired", "I am in pain", "I am finished"):
            assert chair.sees(choice)
        await chair.press("down", "enter")
        assert chair.sees("Take all the rest you need.")
        await chair.press("down", "enter")
        assert chair.sees("Tell your therapist or the experimenter about the pain")
        await chair.press("enter")
        await chair.to_prompt()
        reasons = [act["reason"] for act in chair.messages("operator/act") if act["command"] == "pause"]
        assert reasons == ["", "tired", "pain"]


async def test_a_second_escape_changes_nothing(data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press("escape", "down", "enter", "escape")
        assert chair.sees("Have a rest")


@pytest.mark.parametrize(("keys", "goes_on"), [(["enter"], True), (["down", "enter"], False)])
async def test_only_ending_asks_again(
    keys: list[str], goes_on: bool, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.answer(await chair.to_first_prompt())
        await chair.press("escape", "up", "enter")
        assert chair.sees("End the session now?")
        assert not chair.session.ended
        await chair.press(*keys)
        assert chair.session.ended is not goes_on
        if not goes_on:
            assert chair.sees("Ended early, after 0 attempts.")
            await chair.wait(300)
            await chair.press("enter")
            assert chair.app.return_code == 0
    assert stored(data, "SELECT status FROM sessions") == [("interrupted" if goes_on else "aborted",)]
    assert stored(data, "SELECT count(*) FROM trials") == [(1,)]


@pytest.mark.parametrize("key", ["f1", "ctrl+p"])
async def test_help_or_the_palette_over_a_trial_pauses_it(
    key: str, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press(key)
        assert "Press: " not in chair.text
        assert chair.waiting.stage == "paused"
        await chair.press("escape")
        assert chair.sees("Paused")
        await chair.press("enter")
        assert (await chair.to_prompt()).presentation == 2


async def test_a_window_made_too_small_pauses_a_trial_and_recovers(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.resize(79, 24)
        assert chair.sees("This window is too small.")
        assert chair.sees("It has 79 by 24 characters; 80 by 24 are needed.")
        await chair.press(prompt.expected, "enter")
        await chair.resize(100, 30)
        assert chair.sees("Paused")
        await chair.press("enter")
        assert (await chair.to_prompt()).text == prompt.text
        assert prompt.text in chair.text
        assert chair.stored("SELECT * FROM trials") == []
