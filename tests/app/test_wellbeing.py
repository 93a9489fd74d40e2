"""Pain and tiredness are asked before and after a session, with nothing chosen beforehand."""

from collections.abc import AsyncIterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from textual.widgets import Button

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.store import records, wellbeing
from sar_tui.store.database import connect
from sar_tui.store.record_changes import change_status
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, given, known
from tests.recorded import said


@pytest.fixture
async def asked(open_session: OpenSession) -> AsyncIterator[AppDriver]:
    """A session that asks for pain and tiredness."""
    async with open_session(ask_wellbeing=True) as driver:
        yield driver


def answers(driver: AppDriver) -> list[tuple[Any, ...]]:
    """Return what is stored of pain and tiredness, once all is stored."""
    driver.stored("SELECT 1")
    return said(driver.app.database)


async def test_a_session_asks_before_and_after(asked: AppDriver) -> None:
    asked.see("How much pain do you have now?", "no pain", "worst pain imaginable")
    asked.see("Press the number or an arrow key, then Enter.")
    asked.lacks("Ctrl-P", "Ctrl-Q")
    await asked.press("enter", "space", "q")
    asked.see("Please choose first, then press Enter.")
    assert answers(asked) == [], "nothing is chosen beforehand"
    await asked.press("7", "left", "2")
    asked.see("┃ 2 ┃", "Press Enter to go on.")
    assert answers(asked) == [], "it is chosen, and not yet said"
    await asked.press("enter")
    asked.see("Where does it hurt?", "You said: 2.", "9 somewhere else")
    await asked.press("5", "enter")
    asked.see("How tired are you now?")
    await asked.press("tab")
    await asked.do_session()
    await asked.press("enter")
    asked.see("How much pain do you have now?")
    await asked.press("0", "enter", "left", "enter")
    assert asked.app.return_code == 0
    session = asked.session_id
    assert answers(asked) == [
        ("before", "pain", 2, "left shoulder"),
        ("before", "tiredness", "not said"),
        ("after", "pain", 0),
        ("after", "tiredness", 10),
    ]
    assert asked.stored("SELECT DISTINCT session FROM records") == [(session,)]


async def test_a_held_key_answers_once_and_the_last_of_corrected_answers_counts(
    asked: AppDriver,
) -> None:
    await asked.press("0")
    await asked.wait(700)
    await asked.write("enter", "enter", "enter")
    asked.see("How tired are you now?", "Press the number")
    assert answers(asked) == [("before", "pain", 0)]
    await asked.press("backspace")
    asked.see("┃ 0 ┃")
    await asked.press("9", "enter", "backspace", "0", "enter", "3", "enter")
    assert asked.screen_name == "SessionScreen", "the pain that was corrected is no reason to stop"
    assert answers(asked) == [("before", "pain", 0), ("before", "tiredness", 3)]
    found = asked.stored("SELECT kind, version FROM records ORDER BY recorded_at")
    assert found == [("pain", 1), ("pain", 2), ("pain", 3), ("tiredness", 1)]


async def test_no_pain_after_all_hurts_nowhere(asked: AppDriver) -> None:
    await asked.press(*given("3", "2"), "backspace", "backspace", *given("0", "1"))
    assert answers(asked) == [("before", "pain", 0), ("before", "tiredness", 1)]


async def test_ten_is_a_one_and_a_zero_and_another_zero_corrects_it(asked: AppDriver) -> None:
    await asked.press("1", "0")
    asked.see("┃ 10 ┃")
    await asked.press("0")
    asked.see("┃ 0 ┃")
    await asked.press("1", "0", "enter")
    asked.see("Where does it hurt?", "You said: 10. Backspace goes back.")


async def test_pain_above_the_limit_before_a_session_is_a_reason_not_to_begin(
    opened: OpenApp, data: Path
) -> None:
    known(data, ask_wellbeing=True)
    async with opened() as driver:
        driver.app.screen.query_one("#start", Button).active_effect_duration = 0
        await driver.press("right", "right", "right", "enter", *given("6", "3", "4"))
        driver.see("Please do not train now Rest, and tell your therapist", "Nobody is watching")
        await driver.press("5", "space", "n", "tab")
        assert driver.sees("Please do not train now"), "only the keys on the screen leave it"
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        stopped = [("before", "pain", 6, "left arm", "stopped"), ("before", "tiredness", 4)]
        assert answers(driver) == stopped
        assert driver.stored("SELECT DISTINCT session FROM records") == [(None,)]
        driver.see("1 person needs a look.", "P01 Pain 6")
        driver.see("P01 · Keyboard reaction Pain 6 today, limit 5.")

        await driver.press("enter", *given("7", "3", "5"), "g")
        assert driver.screen_name == "SessionScreen"
        went_on = [("before", "pain", 7, "left arm", "went on"), ("before", "tiredness", 5)]
        assert answers(driver) == stopped + went_on
        sessions = driver.stored("SELECT DISTINCT session FROM records WHERE session IS NOT NULL")
        assert sessions == [(driver.session_id,)]


async def test_escape_goes_back_to_what_was_there_before_the_questions(asked: AppDriver) -> None:
    await asked.press("2", "enter", "escape")
    asked.see("How much pain do you have now?")
    await asked.press("escape")
    assert asked.app.return_code == 0
    assert answers(asked) == [("before", "pain", 2)]
    assert asked.stored("SELECT 1 FROM sessions") == []


async def test_after_too_much_pain_escape_leads_to_the_advice(asked: AppDriver) -> None:
    await asked.press("9", "enter", "escape", "escape")
    asked.see("Please do not train now")
    await asked.press("escape", "1", "enter", "escape", "escape")
    assert asked.stored("SELECT 1 FROM sessions") == [], "the pain was corrected"
    assert answers(asked) == [("before", "pain", 1, "shown")]


@pytest.mark.slow
async def test_pain_that_rose_much_is_a_reason_to_stop_in_a_resumed_session_too(
    opened: OpenApp, open_session: OpenSession
) -> None:
    async with open_session(ask_wellbeing=True) as driver:
        await driver.press(*given("1", "2", "3"))
        await driver.to_first_prompt()
        session = driver.session_id
    async with opened(session) as driver:
        assert driver.screen_name == "SessionScreen"
        await driver.press("enter")
        await driver.finish(await driver.to_prompt())
        await driver.press("enter", *given("3", "2", "3"))
        driver.see("Please rest now Rest, and tell your therapist about the pain")
        driver.see("Nobody is watching")
        await driver.press("g")
        assert driver.sees("Press Enter to close."), "there is nothing to go on with"
        await driver.press("enter")
        assert driver.app.return_code == 0
        assert ("after", "pain", 3, "right hand", "shown") in answers(driver)
    assert driver.stored("SELECT DISTINCT session FROM records") == [(session,)]


async def test_after_too_much_pain_in_a_pause_one_key_goes_on_and_enter_ends(
    asked: AppDriver,
) -> None:
    told = ("escape", "down", "down", "enter")
    await asked.press(*given("2", "5", "1"))
    prompt = await asked.to_first_prompt()
    await asked.press(*told)
    asked.see("How much pain do you have now?")
    assert not asked.sees("Stop voice"), "there is none"
    await asked.press(*given("6", "5"))
    assert asked.sees("Please stop for today Rest, and tell your therapist about the pain now."), (
        "it rose by 4"
    )
    assert not asked.sees("Nobody is watching"), "there may be an operator"
    await asked.press("g")
    asked.see("Tell your therapist or the experimenter about the pain before you go on.")
    await asked.press("enter")
    assert (await asked.to_prompt()).text == prompt.text, "the session goes on"
    assert {each for each in answers(asked) if each[0] == "pause"} == {
        ("pause", "pain", "told in a pause"),
        ("pause", "pain", 6, "left shoulder", "went on"),
    }
    await asked.press(*told, *given("6", "5"), "enter")
    assert asked.waiting.stage == "ended"
    assert ("pause", "pain", 6, "left shoulder", "stopped") in answers(asked)


@pytest.mark.slow
async def test_two_participants_are_asked_in_turn_and_an_adverse_event_names_one(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    settings = {"attempts": 1, "prompts_per_attempt": 2, "ask_wellbeing": True}
    async with opened(make_plan(catalogue, "pairs", ["P01", "P02"], settings, seed=7)) as driver:
        driver.see("Left (P01) How much pain")
        await driver.press(*given("0", "1"))
        driver.see("Right (P02) How much pain")
        await driver.press("2", "enter", "tab", "3", "enter")
        assert driver.screen_name == "SessionScreen"
        assert answers(driver) == [
            ("before", "pain", 0),
            ("before", "tiredness", 1),
            ("before", "pain", 2, "not said"),
            ("before", "tiredness", 3),
        ]
        people = driver.stored("SELECT DISTINCT participant, seat FROM records")
        assert people == [("P01", "A"), ("P02", "B")]
        await driver.press("enter", "ctrl+q", "down", "enter")
    with closing(connect(data)) as database:
        change_status(database, data, driver.session_id, "dismissed", actor="therapist")
    async with opened() as driver:
        await driver.press("f6", "enter", "a")
        await driver.press(*"Dizzy", "enter", *"mild", "enter", "enter", *["shift+tab"] * 5)
        assert driver.sees("Participant"), "it scrolls to the field"
        await driver.press(*"P09", *["enter"] * 6)
        driver.see("P09 did not take part in this session.")
        assert records.listing(driver.app.database, kinds=("adverse-event",)) == []


async def test_the_questions_are_in_the_sessions_language(
    open_session: OpenSession,
) -> None:
    async with open_session(ask_wellbeing=True, language="es") as driver:
        driver.see("¿Cuánto dolor tiene ahora?", "ningún dolor")
        await driver.press("left", "enter", "8", "enter", "tab")
        driver.see("No entrene ahora, por favor")
        assert answers(driver)[0] == ("before", "pain", 10, "head", "shown"), "stored in English"


async def test_a_session_within_the_therapists_limits_shows_what_was_said_and_takes_an_adverse_event(
    opened: OpenApp, open_session: OpenSession
) -> None:
    settings = {"ask_wellbeing": True, "pain_limit": 8, "pain_rise": 3}
    async with open_session(attempts=1, **settings) as driver:
        await driver.press(*given("6", "5", "1"))
        await driver.do_session()
        await driver.press("enter", *given("8", "5", "8"))
        assert driver.app.return_code == 0, "without the advice to stop"
        session = driver.session_id
    async with opened() as driver:
        assert not any("shown" in each for each in answers(driver))
        rated = wellbeing.history(driver.app.database, "P01")
        assert [each.is_reason_to_stop for each in rated] == [False]
        await driver.press("f6", "enter")
        driver.see("Pain: 6 before (left shoulder), 8 after (left shoulder).")
        driver.see("Tiredness: 1 before, 8 after.")
        await driver.press("a", *"Drowsy", "escape")
        assert driver.screen_name == "PastSessionScreen"
        await driver.press("a", *"Dizzy", "enter", *"awful", "enter", "enter", "enter")
        driver.see("Severity is mild, moderate or severe, not 'awful'.")
        await driver.press("shift+tab", "shift+tab", *["backspace"] * 5)
        await driver.press(*"mild", "enter", *"Rested", "enter", "enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("mild: Dizzy. Action: Rested.")
        (entered,) = records.listing(driver.app.database, kinds=("adverse-event",))
        assert (entered.participant, entered.session) == ("P01", session)
        assert entered.content == {"what": "Dizzy", "severity": "mild", "action": "Rested"}
