"""One key takes back what was just done, and the row of keys names it as long as it does."""

from contextlib import closing
from pathlib import Path

from sar_tui.loop.undo import UNDO_FOR
from sar_tui.model.units import MS
from sar_tui.reports import session_facts
from sar_tui.store.database import connect
from sar_tui.store.integrity import flaws
from tests.app.app_driver import AppDriver, OpenSession
from tests.app.test_adjust import choose, open_changes

OFFER = "Backspace Take back"
TOO_LATE_MS = UNDO_FOR / MS + 1


async def answer_pain(driver: AppDriver, pain: str) -> None:
    """Do the first attempt, and say how much pain there is after it."""
    await driver.do_attempt(await driver.to_first_prompt())
    await driver.wait(1500)
    await driver.press(pain, "enter")
    await driver.wait(500)


async def test_backspace_takes_an_answer_back_and_only_the_new_one_is_kept(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session(questions=("pain",), questions_every=1) as driver:
        await answer_pain(driver, "3")
        driver.see("Press Enter for attempt 2", OFFER)
        await driver.press("backspace")
        await driver.wait(500)
        driver.see("How strong is your pain now?")
        assert not driver.sees(OFFER)
        await driver.press("2", "enter")
        await driver.wait(500)
        driver.see("Press Enter for attempt 2")
        session = driver.session_id
    assert driver.stored("SELECT step, answer FROM answers") == [("pain", "2")]
    with closing(connect(data)) as database:
        told = session_facts.taken_back(database, session)
    assert told == ["Taken back by the participant: the answer to pain."]
    assert [each["number"] for each in driver.messages("event_handler/taken_back")] == [1]


async def test_the_key_is_gone_after_ten_seconds(open_session: OpenSession) -> None:
    async with open_session(questions=("pain",), questions_every=1) as driver:
        await answer_pain(driver, "3")
        await driver.wait(TOO_LATE_MS)
        assert not driver.sees(OFFER)
        await driver.press("backspace")
        driver.see("Press Enter for attempt 2")


async def test_a_held_key_takes_back_one_thing(open_session: OpenSession) -> None:
    async with open_session(questions=("exertion", "pain"), questions_every=1) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(1500)
        await driver.press("5", "enter")
        await driver.wait(500)
        await driver.press("3", "enter")
        await driver.wait(500)
        await driver.press(*["backspace"] * 10)
        driver.see("How strong is your pain now?")
    assert len(driver.messages("event_handler/taken_back")) == 1


async def test_backspace_deletes_while_an_answer_is_typed(open_session: OpenSession) -> None:
    async with open_session(questions=("pain", "remark"), questions_every=1) as driver:
        await answer_pain(driver, "3")
        driver.see("Is there anything you would like to tell us?")
        await driver.press("o", "backspace", "backspace")
        driver.see("Is there anything you would like to tell us?", "Take back")
        assert not driver.sees(OFFER)
        await driver.press("ctrl+z")
        driver.see("How strong is your pain now?")


async def test_an_attempt_begun_by_mistake_is_begun_later(
    open_session: OpenSession, data: Path
) -> None:
    async with open_session(attempts=1) as driver:
        await driver.to_first_prompt()
        driver.see("Ctrl-Z Take back")
        await driver.press("ctrl+z")
        await driver.wait(500)
        driver.see("This attempt begins again", "Press Enter")
        await driver.do_attempt(await driver.begin())
        session = driver.session_id
    assert driver.stored("SELECT attempt, trials FROM attempts") == [(2, 2)]
    with closing(connect(data)) as database:
        told = session_facts.skipped_attempts(database, session)
        found = [flaw.what for flaw in flaws(database)]
    assert told == ["Attempt 1 was begun by mistake; attempt 2 began it again."]
    assert found == [], "nothing of the record is missing"


async def test_backspace_is_a_response_while_one_is_awaited(open_session: OpenSession) -> None:
    async with open_session(attempts=1) as driver:
        await driver.to_first_prompt()
        await driver.press("backspace")
        await driver.wait(500)
    assert driver.stored("SELECT attempt, trial, response FROM trials") == [(1, 1, "backspace")]
    assert driver.messages("event_handler/taken_back") == []


async def test_a_change_of_the_therapist_is_taken_back(open_session: OpenSession) -> None:
    async with open_session(max_level=3) as driver:
        await driver.press("enter")
        await open_changes(driver)
        await choose(driver, "Level up")
        driver.see("Level 2", "Ctrl-Z takes the last change back.")
        await driver.press("ctrl+z")
        driver.see("Level 1")
        assert not driver.sees("Ctrl-Z takes the last change back.")


async def test_a_note_that_was_taken_back_is_in_the_log_only(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.press("enter")
        await open_changes(driver)
        await choose(driver, "Write a note")
        await driver.enter("of somebody else")
        await driver.press("ctrl+z")
    assert driver.stored("SELECT text FROM notes") == []
    assert [note["text"] for note in driver.messages("operator/note")] == ["of somebody else"]
