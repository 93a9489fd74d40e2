"""Patient mode: the exercises follow each other, and only the passphrase leads anywhere else."""

import signal
from collections.abc import AsyncIterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.app.app import SarTui
from sar_tui.plugins import Catalogue
from sar_tui.reports import session_facts
from sar_tui.store import passphrase
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.passphrase import Passphrase
from tests.app.app_driver import AppDriver, OpenApp, given, known, stored

RIGHT = "quiet river"
REACHING = {"imu": "simulated", "attempts": 1, "reaches_per_attempt": 1}


@pytest.fixture(autouse=True)
def prepared(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set a passphrase, which is cheap to check, and two participants; P01 has two exercises."""
    monkeypatch.setattr(passphrase, "_COST", 16)
    Passphrase(data).set(RIGHT)
    known(data, "P01")
    known(data, "P01", task="reaching", **REACHING)
    known(data, "P77")


@pytest.fixture
async def alone(opened: OpenApp, prepared: None) -> AsyncIterator[AppDriver]:
    """Patient mode of P01."""
    async with opened(patient="P01") as driver:
        yield driver


async def end_mode(driver: AppDriver, text: str = RIGHT) -> None:
    await driver.press("f12")
    await driver.enter(text)
    await driver.settle()


async def test_enter_starts_one_exercise_after_the_other(alone: AppDriver) -> None:
    alone.see("Exercise 1 of 2", "▸ Keyboard reaction 2 attempts Reaching")
    await alone.press("enter")
    await alone.do_session()
    alone.see("Next: exercise 2 of 2")
    await alone.press("enter")
    alone.see("Exercise 2 of 2", "✓ Keyboard reaction done ▸ Reaching 1 attempt")
    await alone.press("down", "enter")
    alone.see("E V E R Y T H I N G", "You can rest now.")
    await alone.press("enter")
    alone.see("Exercise 1 of 2")
    assert alone.stored("SELECT status FROM sessions") == [("completed",)]


@pytest.mark.parametrize("shown", ["first time", "always"])
async def test_a_returning_participant_begins_with_one_enter_unless_instructions_are_always_shown(
    opened: OpenApp, data: Path, shown: str
) -> None:
    known(data, "P77", instructions=shown)
    async with opened(patient="P77") as driver:
        await driver.press("enter")
        driver.see("Press that key as fast as you can")
        await driver.do_session()
        await driver.press("enter")
        driver.see("E V E R Y T H I N G")
    async with opened(patient="P77") as driver:
        driver.see("E V E R Y T H I N G")  # it is done today
        await driver.press("enter")
        driver.see("Keyboard reaction", "About 1 minute")
        await driver.press("enter")
        is_shown = driver.sees("Press that key as fast as you can")
        assert is_shown == (shown == "always")
        if not is_shown:
            driver.see("Attempt 1 of 2", "It begins by itself.")
            await driver.wait(1000)
            assert driver.waiting.stage == "trial"
            await driver.to_prompt()


async def test_a_pause_before_the_first_attempt_of_a_returning_participant_waits_for_enter(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P77", instructions="never")
    async with opened(patient="P77") as driver:
        await driver.press("enter", "escape")
        await driver.wait(5000)
        await driver.press("enter")
        driver.see("Press Enter to begin attempt 1 of 2.")


async def test_a_days_limit_ends_the_exercises(opened: OpenApp, data: Path) -> None:
    known(data, "P77", attempts_a_day=1)
    async with opened(patient="P77") as driver:
        driver.app.hour = lambda: 13
        driver.app.screen.show_exercise()  # type: ignore[attr-defined]
        await driver.settle()
        driver.see("Good afternoon", "Keyboard reaction 2 attempts")
        driver.lacks("Skip this exercise")
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter", "enter", "enter")
        driver.see("That is enough for today. Well done!")
        await driver.press("enter")
        driver.see("Keyboard reaction")
        assert driver.app.patient_mode.troubles[0].startswith("That is enough for P77 today")


async def test_in_severe_pain_one_enter_never_begins_and_later_nothing_invites_to_more(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("enter", *given("9", "3", "2"))
        driver.see("Please do not train now")
        await driver.press("enter")
        driver.see("You can rest now.", "Rest, and tell your therapist about the pain now.")
        driver.see("Nobody is watching this screen")
        await driver.press("enter")
        driver.see("Exercise 1 of 2")
        await driver.press("enter")
        assert driver.sees("How much pain do you have now?"), "it is asked again"
        advised = "P01: The participant was advised not to train, and stopped."
        assert advised in driver.app.patient_mode.troubles
        assert driver.stored("SELECT count(*) FROM sessions") == [(0,)]

        await driver.press(*given("3", "5", "1"))
        await driver.do_session()
        await driver.press("enter", *given("6", "5", "4"))
        driver.see("Please rest now")
        await driver.press("enter")
        driver.see("You can rest now. Rest, and tell your therapist about the pain now.")
        driver.lacks("Press Enter to start.")
        await driver.press("enter")
        driver.see("Exercise 2 of 2")


async def test_the_next_exercise_follows_an_ended_one_and_the_same_a_mistake(
    alone: AppDriver,
) -> None:
    for choice, following in (
        (["down", "down", "enter"], "Exercise 1 of 2"),
        (["down", "enter"], "Exercise 2 of 2"),
    ):
        await alone.press("enter", "enter", "escape", *["down"] * 4, "enter", *choice)
        await alone.wait(300)
        await alone.press("enter")
        alone.see(following)
        alone.lacks("Please call your therapist")
    assert alone.stored("SELECT status FROM sessions ORDER BY rowid") == [
        ("discarded",),
        ("aborted",),
    ]


async def test_an_attempt_can_be_left_out_in_ones_own_language(opened: OpenApp, data: Path) -> None:
    known(data, "P01", language="es")
    async with opened(patient="P01") as driver:
        driver.see("Ejercicio 1 de 2")
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
        await driver.press("escape")
        await driver.press("down", "down", "down", "enter")
        await driver.finish(await driver.begin())
        session = driver.session_id
    assert stored(data, "SELECT attempt FROM attempts") == [(2,)]
    assert stored(data, "SELECT attempt, trial FROM trials") == [(1, 1), (2, 1), (2, 2)]
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    with closing(connect(data)) as database:
        assert session_facts.skipped_attempts(database, session) == [
            "Attempt 1 was skipped by the participant, after 1 of 2 trials."
        ]
        assert not list(flaws(database)), "nothing of the record is missing"


@pytest.mark.slow
async def test_neither_screens_nor_help_name_a_way_out(opened: OpenApp, data: Path) -> None:
    known(data, "P88", task="reaching", **REACHING, ask_wellbeing=True)
    others = ("Quit", "Ctrl-Q", "Settings", "F12", "F2 on the first screen", "F7")
    async with opened(patient="P88") as driver:
        for keys in ((), ("enter",), given("0", "1"), ("enter",)):
            await driver.press(*keys)
            driver.lacks(*others)
            await driver.press("f1")
            assert driver.screen_name == "HelpScreen"
            driver.lacks(*others)
            await driver.press("enter")
        assert driver.screen_name == "SessionScreen"


async def test_it_begins_from_the_first_screen_and_the_passphrase_ends_it_there(
    first_run: AppDriver, data: Path
) -> None:
    numbers = (signal.SIGTSTP, signal.SIGQUIT)
    before = [signal.getsignal(number) for number in numbers]
    await first_run.press("f12")
    assert first_run.screen_name == "PatientScreen"
    assert {signal.getsignal(number) for number in numbers} == {signal.SIG_IGN}
    await first_run.press("ctrl+q", "ctrl+p")
    first_run.app.signalled(signal.SIGINT)
    await first_run.settle()
    assert first_run.screen_name == "PatientScreen"
    await end_mode(first_run, "wrong one")
    first_run.see("That is not the passphrase.")
    await first_run.press("escape")
    assert first_run.screen_name == "PatientScreen"
    await end_mode(first_run)
    assert first_run.screen_name == "HomeScreen"
    assert [each.result for each in Passphrase(data).tries()] == ["wrong", "right"]
    assert [signal.getsignal(number) for number in numbers] == before
    await first_run.press("f2")
    assert first_run.screen_name == "SettingsScreen", "all keys work again"


@pytest.mark.slow
async def test_in_a_session_the_keys_that_leave_pause_it_and_a_removed_passphrase_still_guards(
    alone: AppDriver, data: Path
) -> None:
    Passphrase(data).remove()
    await alone.press("enter")
    await alone.to_first_prompt()
    for key in ("ctrl+q", "ctrl+c"):
        await alone.press(key)
        alone.see("Take your time.")
        alone.lacks("Ctrl-Q")
        await alone.press("enter")
        await alone.to_prompt()
    await alone.press("escape", "up", "enter")
    assert alone.sees("Please enter the passphrase."), "the changes in a pause as well"
    await alone.press("escape")
    await end_mode(alone)
    assert not alone.app.patient
    alone.see("Paused")
    await alone.press("enter")
    await alone.finish(await alone.to_prompt())
    await alone.press("enter")
    assert alone.screen_name == "HomeScreen"
    alone.see("2 of 2 reached")
    await alone.press("ctrl+q")
    assert not alone.app.is_running


async def test_without_a_passphrase_or_an_exercise_it_does_not_begin(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    app = SarTui(data, catalogue)
    with pytest.raises(StoreError, match="no exercise to do alone"):
        app.patient_mode.exercises_of("P99")
    Passphrase(data).remove()
    with pytest.raises(StoreError, match="There is no passphrase"):
        app.patient_mode.exercises_of("P01")
    app.database.close()
    async with opened() as driver:
        await driver.press("f12")
        assert driver.screen_name == "HomeScreen"
        driver.see("There is no passphrase. Set one: sar-tui passphrase.")


async def test_an_interrupted_session_goes_on_unless_it_is_of_days_ago(
    opened: OpenApp, data: Path
) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        assert driver.session_id == session
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET started_at='2026-01-01T10:00:00+00:00'")
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        assert driver.session_id != session


async def test_an_exercise_that_fails_is_told_to_the_therapist(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise StoreError("The disk is full.")

    async with opened(patient="P01") as driver:
        with monkeypatch.context() as patch:
            patch.setattr("sar_tui.app.live.LiveSession.open", fail)
            await driver.press("enter")
        driver.see("This does not work now. Please call your therapist.")
        driver.lacks("The disk is full.")
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen", "it can be tried again"
        await end_mode(driver)
        driver.see("The disk is full.")


THERAPISTS_KEYS = (
    *(f"f{number}" for number in range(3, 12)), "ctrl+p", "ctrl+s", "ctrl+l", "ctrl+d",
    "ctrl+backslash", "delete",
)  # fmt: skip
"""The palette, settings, progress, sessions, marks and the operator's panel; F1, F2 and
Ctrl-Z, which takes back, are a participant's, too.
"""


async def test_therapists_keys_do_nothing(opened: OpenApp, data: Path) -> None:
    known(data, "P05", task="reaching", ask_wellbeing=True, **REACHING)
    async with opened(patient="P05") as driver:
        screens = []

        async def try_keys() -> None:
            live = driver.app.live
            waiting = driver.waiting if live else None
            before = [type(screen) for screen in driver.app.screen_stack], driver.app.focused
            for key in THERAPISTS_KEYS:
                await driver.strike(key)
                now = [type(screen) for screen in driver.app.screen_stack], driver.app.focused
                assert now == before, key
            assert (driver.waiting if live else None) == waiting
            screens.append(f"{driver.screen_name} {waiting.stage if waiting else ''}".strip())

        await try_keys()
        for key in ("enter", *given("0", "3"), "enter", "enter", "enter", "space"):
            await driver.press(key)
            await driver.wait(800)
            await try_keys()
        assert driver.messages("event_handler/voided") == []
        await driver.press("f1")
        await try_keys()
        await driver.press("escape", "f12")
        await try_keys()
        assert {act["actor"] for act in driver.messages("operator/act")} <= {"participant"}
        assert driver.messages("event_handler/marked") == []
    assert set(screens) == {
        "PatientScreen", "QuestionScreen", "SensorCheckScreen", "SessionScreen instructions",
        "SessionScreen attempt", "SessionScreen trial", "HelpScreen paused",
        "PassphraseScreen paused",
    }  # fmt: skip
