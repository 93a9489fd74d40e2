"""Changes that a therapist makes in a pause, behind the passphrase if there is one."""

import time
from pathlib import Path

import pytest

from sar_tui.store import passphrase
from sar_tui.store.passphrase import Passphrase
from tests.app.app_driver import AppDriver, OpenSession

RIGHT = "quiet river"


async def open_changes(driver: AppDriver) -> None:
    """Pause, and choose the last line of the menu."""
    await driver.press("escape", "up", "enter")


async def choose(driver: AppDriver, words: str) -> None:
    """Choose a line of the list."""
    for _ in range(8):
        choices = driver.app.screen.query_one("#changes")
        if str(choices.highlighted_option.prompt).startswith(words):
            await driver.press("enter")
            return
        await driver.press("down")
    raise AssertionError(f"{words} is not in the list")


async def type_over(driver: AppDriver, text: str) -> None:
    await driver.press("end", *["backspace"] * 12)
    await driver.enter(text)


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passphrase, "_COST", 16)


@pytest.mark.slow
async def test_goal_and_feedback_change_from_the_next_attempt_on(open_session: OpenSession) -> None:
    async with open_session(attempts=4) as driver:
        first = await driver.to_first_prompt()
        await open_changes(driver)
        driver.see("Changes apply from the next attempt on.")
        await choose(driver, "Goal: 1 second")
        await type_over(driver, "0.7")
        await choose(driver, "Feedback: after every attempt")
        await type_over(driver, "2")
        driver.see("Goal: 0.7 seconds", "Feedback: after every 2 attempts")
        await driver.press("escape", "enter")
        await driver.do_attempt(await driver.to_prompt())
        driver.see("in less than 0.7 seconds on average")
        await driver.do_attempt(await driver.begin())
        await driver.do_attempt(await driver.begin())
        found = driver.stored("SELECT goal, feedback FROM attempts")
        assert found == [(1000.0, "positive"), (700.0, "none"), (700.0, "positive")]
        assert [
            (act["name"], act["value"], act["actor"]) for act in driver.messages("operator/setting")
        ] == [("threshold", 700.0, "therapist"), ("feedback_every", 2, "therapist")]
        assert first.attempt == 1


@pytest.mark.slow
async def test_the_level_goes_up_and_down_and_is_held(open_session: OpenSession) -> None:
    async with open_session(attempts=4, max_level=3) as driver:
        await driver.press("enter")
        await open_changes(driver)
        await choose(driver, "Level up")
        await choose(driver, "Level up")
        driver.see("Level 3")
        await choose(driver, "Hold the level")
        driver.see("Level 3 · held")
        await choose(driver, "Level down")
        await choose(driver, "Back")
        await driver.press("enter")
        await driver.do_attempt(await driver.begin())
        await driver.do_attempt(await driver.begin())
        await open_changes(driver)
        await choose(driver, "Let the level change again")
        await driver.press("escape", "enter")
        await driver.do_attempt(await driver.begin())
        assert driver.stored("SELECT level FROM attempts") == [(2,), (2,), (2,)]
        assert driver.waiting.level == 3
        assert {
            act["actor"] for act in driver.messages("operator/act") if act["command"] == "level"
        } == {"therapist"}


async def test_a_note_is_stored_as_the_therapists(driver: AppDriver) -> None:
    await open_changes(driver)
    await choose(driver, "Write a note")
    await driver.enter("wore glasses?")
    driver.see("The note is kept.")
    assert driver.stored("SELECT author, text FROM notes") == [("therapist", "wore glasses?")]


async def test_a_session_that_is_left_can_be_gone_on_with(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.answer(await driver.to_first_prompt())
        await open_changes(driver)
        await choose(driver, "Stop, and go on later")
        assert not driver.app.is_running
        assert "Resume it: sar-tui resume" in driver.app.leaving.lines(0)[0]
    assert driver.stored("SELECT status FROM sessions") == [("interrupted",)]


async def test_feedback_that_has_no_frequency_is_not_offered(open_session: OpenSession) -> None:
    async with open_session(feedback_schedule="request") as driver:
        await open_changes(driver)
        driver.see("Goal: 1 second")
        driver.lacks("Feedback:")


@pytest.mark.usefixtures("cheap")
async def test_only_the_right_passphrase_opens_it(open_session: OpenSession, data: Path) -> None:
    Passphrase(data).set(RIGHT)
    async with open_session() as driver:
        await open_changes(driver)
        driver.see("Please enter the passphrase.")
        await driver.write(*"quiet rivers")
        assert "quiet" not in driver.text
        await driver.press("enter")
        driver.see("That is not the passphrase.")
        await driver.press("enter")
        assert driver.sees("Paused"), "nothing entered: back to the pause"
        await driver.press("up", "enter")
        await driver.enter(RIGHT)
        driver.see("Changes apply from the next attempt on.")
    found = [(each.result, each.where) for each in Passphrase(data).tries()]
    assert found == [("wrong", "pause"), ("right", "pause")]


async def test_a_goal_out_of_bounds_is_refused(driver: AppDriver) -> None:
    await open_changes(driver)
    driver.see("For the therapist", "Level 1", "Back")
    await choose(driver, "Goal")
    for bad in ("700", "much", "nan"):
        await type_over(driver, bad)
        assert driver.sees("The goal is a number of seconds, 0.1 to 60."), bad
    await driver.press("escape", "escape")
    driver.see("Paused")
    assert driver.messages("operator/setting") == []


@pytest.mark.usefixtures("cheap")
async def test_after_errors_even_the_right_passphrase_has_to_wait(
    open_session: OpenSession, data: Path
) -> None:
    moments = [time.time() - 155]
    stored = Passphrase(data, lambda: moments[-1])
    stored.set(RIGHT)
    for _ in range(8):
        stored.check("wrong one")
        moments.append(moments[-1] + stored.wait_s)
    async with open_session() as driver:
        await open_changes(driver)
        await driver.enter(RIGHT)
        assert driver.screen_name == "PassphraseScreen"
