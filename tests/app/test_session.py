"""A session as its participant sees it, from the instructions to the summary."""

from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from tests.app.app_driver import OpenApp, OpenSession, known, stored
from tests.examples import first


async def test_a_session_from_the_instructions_to_the_summary(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session() as driver:
        assert driver.sees("Press that key as fast as you can, and then wait for the next one.")
        assert driver.sees("An attempt asks for 2 keys.")
        assert driver.sees("Press Enter to go on.")

        await driver.press("enter")
        assert driver.sees("Attempt 1 of 2 · level 1")
        assert driver.sees(
            "press the right key in less than 1 second on average, with 2 of 2 right."
        )
        assert driver.sees("Press Enter to begin attempt 1 of 2.")

        await driver.do_attempt(await driver.begin())
        assert driver.sees("Keys 2 of 2")
        assert driver.sees("Attempts 1 of 2")
        assert "0.40 seconds" in driver.said
        assert "you ━━━━━━━━━━━━━━──────────────────────┊ goal: less than 1 second ✓" in driver.text
        assert driver.sees("Attempt 2 of 2 · level 2")
        assert driver.sees("Press Enter for attempt 2 of 2.")

        await driver.do_attempt(await driver.begin())
        assert driver.waiting.stage == "review"
        assert driver.sees("All done That was the last attempt. Press Enter to see how it went.")
        assert driver.sees("Attempt 2 of 2 · level 2")
        assert driver.sees("Attempts 2 of 2")
        assert "0.40 seconds" in driver.messages("arbiter/action")[-1]["text"]
        assert driver.messages("arbiter/action")[-1]["text"] in driver.said
        assert not driver.session.ended

        await driver.see_the_summary()
        assert driver.session.ended
        assert driver.sees(
            "You did 2 attempts; goal reached in 2. Best: 0.40 seconds. Highest level: 2."
        )
        assert driver.sees("● reached")
        assert driver.sees("Press Enter to finish.")
        await driver.press("enter")
        assert not driver.app.is_running
        assert driver.app.return_code == 0
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    assert stored(
        data,
        "SELECT count(*), sum(correct), min(reaction_time_ms), max(reaction_time_ms) FROM trials",
    ) == [(4, 4, 400.0, 400.0)]


async def test_the_plain_line_is_shown_only_with_a_prompt(open_session: OpenSession) -> None:
    async with open_session(prompts_per_attempt=3) as driver:
        await driver.press("enter")
        await driver.wait(300)
        await driver.press("enter")
        for _ in range(3):
            assert "Press: " not in driver.text
            prompt = await driver.to_prompt()
            assert [row.strip() for row in driver.rows].count(prompt.text) == 1
            assert prompt.text == f"Press: {prompt.expected}"
            await driver.wait(400)
            assert prompt.text in driver.text
            await driver.press(prompt.expected)
        assert "Press: " not in driver.text


async def test_a_prompt_without_a_response_times_out(open_session: OpenSession) -> None:
    async with open_session(response_timeout_ms=2000) as driver:
        prompt = await driver.to_first_prompt()
        await driver.wait(1999)
        assert prompt.text in driver.text
        await driver.wait(100)
        assert "Press: " not in driver.text
        assert driver.stored("SELECT response, correct, reaction_time_ms FROM trials") == [
            (None, 0, None)
        ]


async def test_every_screen_that_waits_for_enter_says_so(open_session: OpenSession) -> None:
    async with open_session(attempts=1, practice_attempts=1) as driver:
        assert "Enter" in driver.text  # the instructions
        await driver.press("enter")
        assert "Enter" in driver.text  # before the practice attempt
        await driver.begin()
        assert "Enter" not in driver.text
        await driver.press("escape")
        assert "Enter" in driver.text  # the pause
        for choice in ("tired", "pain", "finished"):
            await driver.press("down", "enter")
            assert driver.waiting.reason == choice
            assert "Enter" in driver.text
        await driver.press("enter")
        await driver.to_prompt()
        await driver.disk(False)
        await driver.disk(True)
        assert "Enter" in driver.text  # the disk works again
        await driver.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        assert "Enter" in driver.text  # between attempts
        await driver.do_attempt(await driver.begin())
        assert driver.sees("Press Enter to see how it went.")  # after the last attempt
        await driver.see_the_summary()
        assert driver.sees("Press Enter to finish.")  # the summary
        await driver.press("f1")
        assert "Enter" in driver.text  # help


async def test_practice_comes_first_and_does_not_count(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session(practice_attempts=1) as driver:
        await driver.press("enter")
        assert driver.sees("Press Enter to begin practice 1 of 1.")
        assert driver.sees("Practice 0 of 1")
        await driver.do_attempt(await driver.begin())
        assert driver.sees(
            "Practice is over. From here on it counts. Press Enter for attempt 1 of 2."
        )
        assert driver.sees("Attempts 0 of 2")
        assert driver.sees("Attempt 1 of 2 · level 1")
        await driver.do_attempt(await driver.begin())
        assert not driver.sees("Practice is over.")
        await driver.do_attempt(await driver.begin())
        await driver.see_the_summary()
        assert driver.sees("You did 2 attempts; goal reached in 2.")
    assert stored(data, "SELECT attempt, practice FROM attempts") == [(1, 1), (2, 0), (3, 0)]


async def test_a_wrong_key_is_a_response_and_the_agent_mentions_accuracy(
    open_session: OpenSession,
) -> None:
    async with open_session(attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        await driver.wait(300)
        await driver.press("j" if prompt.expected == "f" else "f")
        await driver.answer(await driver.to_prompt())
        assert driver.stored("SELECT correct FROM trials") == [(0,), (1,)]
        text = driver.messages("arbiter/action")[-1]["text"]
        assert "ccuracy" in text
        assert text in driver.said
        await driver.see_the_summary()
        assert driver.sees("You did 1 attempt. ")
        assert not driver.sees("goals reached"), "none was"


async def test_the_header_says_who_is_playing_until_the_end(open_session: OpenSession) -> None:
    async with open_session(participant="P-27", attempts=1) as driver:
        assert driver.rows[0].strip() == "Keyboard reaction · P-27"
        await driver.do_session()
        assert driver.rows[0].startswith(" Keyboard reaction · P-27 ")


async def test_one_attempt_is_singular(open_session: OpenSession) -> None:
    async with open_session(attempts=1, prompts_per_attempt=1) as driver:
        assert driver.sees("An attempt asks for 1 key.")
        await driver.do_session()
        assert driver.sees("You did 1 attempt; goal reached in 1.")


async def test_a_repeated_enter_after_the_last_response_does_not_close_the_summary(
    open_session: OpenSession,
) -> None:
    async with open_session(attempts=1) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(300)
        await driver.press("enter")
        for _ in range(30):  # bounces, or is held
            await driver.wait(40)
            await driver.strike("enter")
        assert driver.app.is_running
        assert driver.sees("Press Enter to finish.")
        await driver.press("enter")
        assert not driver.app.is_running


async def test_an_enter_that_is_held_is_asked_to_be_let_go(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.press("enter")
        for _ in range(2):
            await driver.wait(500)
            await driver.strike("enter")
        assert not driver.sees("let go")
        await driver.wait(500)
        await driver.strike("enter")
        assert driver.sees(
            "Press Enter to begin attempt 1 of 2. Please let go of the keys for a moment."
        )
        await driver.press("enter")
        assert driver.waiting.stage == "trial"
        assert not driver.sees("let go")


async def test_an_enter_that_closes_the_summary_and_is_held_begins_no_other_session(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", attempts=1, prompts_per_attempt=1)
    async with opened() as driver:
        await driver.press("enter", "enter")
        await driver.do_session()
        await driver.press("enter")
        await driver.wait(450)
        for _ in range(60):
            await driver.strike("enter")
            await driver.wait(33)
        assert driver.screen_name == "HomeScreen"
        assert driver.stored("SELECT count(*) FROM sessions") == [(1,)]


async def test_a_repeated_enter_after_ending_early_does_not_close_the_summary(
    open_session: OpenSession,
) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.press("escape", "down", "down", "down", "enter")
        await driver.wait(300)
        assert driver.waiting.reason == "finished"
        await driver.press("down", "enter")
        assert driver.session.ended
        for _ in range(30):
            await driver.wait(40)
            await driver.strike("enter")
        assert driver.app.is_running
        assert driver.sees("Press Enter to finish.")


@pytest.mark.slow
async def test_a_pause_after_the_last_attempt_returns_there_with_all_attempts_counted(
    open_session: OpenSession,
) -> None:
    async with open_session() as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.do_attempt(await driver.begin())
        await driver.press("escape")
        assert driver.sees("Attempts 2 of 2")
        await driver.press("enter")
        assert driver.sees("Press Enter to see how it went.")
        assert driver.sees("Attempts 2 of 2")
        assert driver.sees("Attempt 2 of 2 · level 2")
        await driver.see_the_summary()
        assert driver.sees("Press Enter to finish.")


async def test_a_session_left_after_its_last_attempt_is_resumed_there(
    opened: OpenApp, open_session: OpenSession, data: Path
) -> None:
    async with open_session() as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.do_attempt(await driver.begin())
        session = driver.session_id
        await driver.press("ctrl+q", "down", "enter")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    async with opened(session) as driver:
        assert driver.sees("Press Enter to see how it went.")
        assert "level" not in driver.rows[0]
        assert driver.sees("Keys 2 of 2")
        assert driver.sees("Attempts 2 of 2")
        await driver.press("enter")
        assert driver.sees("You did 2 attempts; goal reached in 2.")
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]


@pytest.mark.parametrize("theme", first(1, ["calm", "high-contrast", "playful"]))
async def test_the_agent_is_silent_during_an_attempt(
    open_session: OpenSession, theme: str, catalogue: Catalogue
) -> None:
    faces = catalogue.theme(theme).faces
    async with open_session(theme=theme) as driver:
        assert faces["happy"].splitlines()[2] in driver.text
        assert driver.said != ""
        await driver.to_first_prompt()
        assert driver.said == ""
        assert all(line in driver.text for line in faces["listening"].splitlines()[1:3])


async def test_a_key_that_waited_while_the_program_was_suspended_is_asked_for_again(
    open_session: OpenSession, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_session() as driver:
        prompt = await driver.to_first_prompt()
        with monkeypatch.context() as suspended:
            suspended.setattr(
                "sar_tui.tui.gc_control.GcControl.is_stalled", lambda control, at: True
            )
            await driver.answer(prompt, after_ms=2800)
        again = await driver.to_prompt()
        assert (again.trial, again.stimulus, again.presentation) == (
            prompt.trial,
            prompt.stimulus,
            2,
        )
        await driver.answer(again)
    assert stored(data, "SELECT trial, reaction_time_ms FROM trials") == [(1, 400.0)]


@pytest.mark.slow
@pytest.mark.parametrize("keys", first(1, [("enter", "space"), ("space", "enter")]))
async def test_two_keys_in_one_burst_close_the_summary_once(
    open_session: OpenSession, keys: tuple[str, ...]
) -> None:
    async with open_session() as driver:
        await driver.do_session()
        await driver.wait(500)
        await driver.write(*keys)
        await driver.settle()
        assert (driver.app.failure, driver.app.return_code) == ("", 0)
