"""A session as its participant sees it, from the instructions to the summary."""

from pathlib import Path

import pytest

from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.app.chair import plan, sit_down, stored


async def test_it_leads_from_the_instructions_to_the_summary(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        assert chair.sees("Press that key as fast as you can, and then wait for the next one.")
        assert chair.sees("An attempt asks for 2 keys.")
        assert chair.sees("Press Enter to go on.")

        await chair.press("enter")
        assert chair.sees("Attempt 1 of 2 · level 1")
        assert chair.sees("press the right key in less than 1 second on average, with at least 2 of 2 right.")
        assert chair.sees("Press Enter to begin attempt 1 of 2.")

        await chair.do_attempt(await chair.begin())
        assert chair.sees("Prompts 2 of 2")
        assert chair.sees("Attempts 1 of 2")
        assert "400 ms" in chair.said
        assert "1000 ms" in chair.said
        assert chair.sees("Attempt 2 of 2 · level 2")
        assert chair.sees("Press Enter to begin attempt 2 of 2.")

        await chair.do_attempt(await chair.begin())
        assert chair.waiting.stage == "review"
        assert chair.sees("You have done it That was the last attempt. Press Enter to see how it went.")
        assert chair.sees("Attempt 2 of 2 · level 2")
        assert chair.sees("Attempts 2 of 2")
        assert "400 ms" in chair.messages("arbiter/action")[-1]["text"]
        assert chair.messages("arbiter/action")[-1]["text"] in chair.said
        assert not chair.session.ended

        await chair.see_the_summary()
        assert chair.session.ended
        assert chair.sees("You did 2 attempts; goal reached in 2. Best: 400 ms. Highest level: 2.")
        assert chair.sees("● reached")
        assert chair.sees("Press Enter to finish.")
        await chair.press("enter")
        assert not chair.app.is_running
        assert chair.app.return_code == 0
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    assert stored(data, "SELECT count(*), sum(correct), min(reaction_time_ms), max(reaction_time_ms) FROM trials") == [
        (4, 4, 400.0, 400.0)
    ]


async def test_the_plain_line_is_there_while_a_prompt_is_up_and_gone_between_prompts(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, prompts_per_attempt=3)) as chair:
        await chair.press("enter")
        await chair.wait(300)
        await chair.press("enter")
        for _ in range(3):
            assert "Press: " not in chair.text
            prompt = await chair.to_prompt()
            assert [row.strip() for row in chair.rows].count(prompt.text) == 1
            assert prompt.text == f"Press: {prompt.expected}"
            await chair.wait(400)
            assert prompt.text in chair.text
            await chair.press(prompt.expected)
        assert "Press: " not in chair.text


async def test_a_prompt_without_an_answer_goes_away_by_itself(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, response_timeout_ms=2000)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.wait(1999)
        assert prompt.text in chair.text
        await chair.wait(100)
        assert "Press: " not in chair.text
        assert chair.stored("SELECT response, correct, reaction_time_ms FROM trials") == [(None, 0, None)]


async def test_every_screen_that_waits_for_enter_says_so(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1, practice_attempts=1)) as chair:
        assert "Enter" in chair.text  # the instructions
        await chair.press("enter")
        assert "Enter" in chair.text  # before the practice attempt
        await chair.begin()
        assert "Enter" not in chair.text
        await chair.press("escape")
        assert "Enter" in chair.text  # the pause
        for choice in ("tired", "pain", "finished"):
            await chair.press("down", "enter")
            assert chair.waiting.reason == choice
            assert "Enter" in chair.text
        await chair.press("enter")
        await chair.to_prompt()
        await chair.disk(False)
        await chair.disk(True)
        assert "Enter" in chair.text  # the disk works again
        await chair.press("enter")
        await chair.do_attempt(await chair.to_prompt())
        assert "Enter" in chair.text  # between attempts
        await chair.do_attempt(await chair.begin())
        assert chair.sees("Press Enter to see how it went.")  # after the last attempt
        await chair.see_the_summary()
        assert chair.sees("Press Enter to finish.")  # the summary
        await chair.press("f1")
        assert "Enter" in chair.text  # help


async def test_practice_comes_first_and_does_not_count(data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    async with sit_down(data, catalogue, plan(keyboard, practice_attempts=1)) as chair:
        await chair.press("enter")
        assert chair.sees("Press Enter to begin practice 1 of 1.")
        assert chair.sees("Practice 0 of 1")
        await chair.do_attempt(await chair.begin())
        assert chair.sees("Press Enter to begin attempt 1 of 2.")
        assert chair.sees("Attempts 0 of 2")
        assert chair.sees("Attempt 1 of 2 · level 1")
        await chair.do_attempt(await chair.begin())
        await chair.do_attempt(await chair.begin())
        await chair.see_the_summary()
        assert chair.sees("You did 2 attempts; goal reached in 2.")
    assert stored(data, "SELECT attempt, practice FROM attempts") == [(1, 1), (2, 0), (3, 0)]


async def test_a_wrong_key_is_a_response_and_the_agent_names_accuracy(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.wait(300)
        await chair.press("j" if prompt.expected == "f" else "f")
        await chair.answer(await chair.to_prompt())
        assert chair.stored("SELECT correct FROM trials") == [(0,), (1,)]
        last_words = chair.messages("arbiter/action")[-1]["text"]
        assert "ccuracy" in last_words
        assert last_words in chair.said
        await chair.see_the_summary()
        assert chair.sees("You did 1 attempt. ")
        assert chair.sees("○ missed")


async def test_one_attempt_is_spoken_of_as_one(data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1, prompts_per_attempt=1)) as chair:
        assert chair.sees("An attempt asks for 1 key.")
        await chair.do_session()
        assert chair.sees("You did 1 attempt; goal reached in 1.")


async def test_an_enter_that_bounces_on_the_last_answer_does_not_close_the_summary(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        await chair.wait(300)
        await chair.press("enter")
        for _ in range(10):  # bounces, or is held
            await chair.wait(40)
            await chair.press("enter")
        assert chair.app.is_running
        assert chair.sees("Press Enter to finish.")
        await chair.wait(300)
        await chair.press("enter")
        assert not chair.app.is_running


async def test_an_enter_that_bounces_when_the_session_is_ended_early_does_not_close_the_summary(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        await chair.press("escape", "down", "down", "down", "enter")
        await chair.wait(300)
        assert chair.waiting.reason == "finished"
        await chair.press("down", "enter")
        assert chair.session.ended
        await chair.wait(40)
        await chair.press("enter")
        assert chair.app.is_running
        assert chair.sees("Press Enter to finish.")


async def test_a_pause_after_the_last_attempt_leads_back_to_it_and_every_attempt_stays_counted(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        await chair.do_attempt(await chair.begin())
        await chair.press("escape")
        assert chair.sees("Attempts 2 of 2")
        await chair.press("enter")
        assert chair.sees("Press Enter to see how it went.")
        assert chair.sees("Attempts 2 of 2")
        assert chair.sees("Attempt 2 of 2 · level 2")
        await chair.see_the_summary()
        assert chair.sees("Press Enter to finish.")


async def test_a_session_that_was_left_after_its_last_attempt_goes_on_there(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        await chair.do_attempt(await chair.begin())
        session = chair.session_id
        await chair.press("ctrl+q")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    async with sit_down(data, catalogue, session) as chair:
        assert chair.sees("Press Enter to see how it went.")
        assert "level" not in chair.rows[0]
        assert chair.sees("Prompts 2 of 2")
        assert chair.sees("Attempts 2 of 2")
        await chair.press("enter")
        assert chair.sees("You did 2 attempts; goal reached in 2.")
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]


@pytest.mark.parametrize("theme", ["calm", "high-contrast", "playful"])
async def test_the_agent_looks_on_in_silence_while_an_attempt_lasts(
    theme: str, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    faces = catalogue.theme(theme).faces
    async with sit_down(data, catalogue, plan(keyboard, theme=theme)) as chair:
        assert faces["happy"].splitlines()[2] in chair.text
        assert chair.said != ""
        await chair.to_first_prompt()
        assert chair.said == ""
        assert all(line in chair.text for line in faces["listening"].splitlines()[1:3])
