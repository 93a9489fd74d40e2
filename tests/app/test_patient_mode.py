"""Patient mode: the exercises follow each other, and only the passphrase leads anywhere else."""

import signal
from collections.abc import AsyncIterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.app.app import SarTui
from sar_tui.plugins import Catalogue
from sar_tui.reports import session_facts
from sar_tui.store import participants, passphrase, programmes
from sar_tui.store.database import StoreError, connect
from sar_tui.store.passphrase import Passphrase
from tests.app.app_driver import SHORT, AppDriver, OpenApp, stored
from tests.examples import first

RIGHT = "quiet river"
REACHING = {"imu": "simulated", "attempts": 1, "reaches_per_attempt": 1}


@pytest.fixture(autouse=True)
def prepared(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set a passphrase, which is cheap to check, and two participants; P01 has two exercises."""
    monkeypatch.setattr(passphrase, "_COST", 16)
    Passphrase(data).set(RIGHT)
    programme(data, "P01", "keyboard")
    programme(data, "P01", "reaching", **REACHING)
    programme(data, "P77", "keyboard")


def programme(data: Path, participant: str, task: str, **parameters: object) -> None:
    with closing(connect(data)) as database:
        participants.add(database, participant)
        values = {**(SHORT if task == "keyboard" else {}), **parameters}
        before = programmes.newest(database, participant, task).version
        programmes.save(database, participant, task, programmes.Programme(values), after=before)


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
    alone.see("Exercise 1 of 2", "Keyboard reaction 2 attempts")
    await alone.press("enter")
    await alone.do_session()
    await alone.press("enter")
    alone.see("Exercise 2 of 2", "Reaching 1 attempt")
    await alone.press("down", "enter")
    alone.see("That was everything. Well done!")
    await alone.press("enter")
    alone.see("Exercise 1 of 2")
    assert alone.stored("SELECT status FROM sessions") == [("completed",)]


@pytest.mark.slow
async def test_a_days_limit_ends_the_exercises(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", attempts_a_day=1)
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter")
        driver.see("Exercise 2 of 2")
        await driver.press("down", "enter", "enter", "enter")
        driver.see("Exercise 2 of 2")
        driver.lacks("Please call your therapist")
    programme(data, "P77", "keyboard", attempts_a_day=1)
    async with opened(patient="P77") as driver:
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter", "enter", "enter")
        driver.see("That is enough for today. Well done!", "You can rest now.")
        await driver.press("enter")
        driver.see("Keyboard reaction")
        assert driver.app.patient_mode.troubles[0].startswith("That is enough for P77 today")


async def test_one_enter_never_begins_in_severe_pain(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("enter", "9", "3", "2")
        driver.see("Please do not train now")
        await driver.press("enter")
        driver.see("You can rest now.", "Rest, and tell your therapist about the pain now.")
        driver.see("Nobody is watching this screen")
        await driver.press("enter")
        driver.see("Exercise 1 of 2")
        await driver.press("enter")
        assert driver.sees("How much pain do you have now?"), "it is asked again"
        assert (
            "P01: The participant was advised not to train, and stopped."
            in driver.app.patient_mode.troubles
        )
    assert stored(data, "SELECT count(*) FROM sessions") == [(0,)]


async def test_after_too_much_pain_nothing_invites_to_more(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("enter", "3", "5", "1")
        await driver.do_session()
        await driver.press("enter", "6", "5", "4")
        driver.see("Please rest now")
        await driver.press("enter")
        driver.see("You can rest now. Rest, and tell your therapist about the pain now.")
        driver.lacks("Press Enter to start.")
        await driver.press("enter")
        driver.see("Exercise 2 of 2")


async def test_who_ends_in_too_much_pain_is_asked_to_rest(opened: OpenApp, data: Path) -> None:
    programme(data, "P77", "keyboard", ask_wellbeing=True)
    async with opened(patient="P77") as driver:
        await driver.press(
            "enter", "0", "1", "enter", "escape", "down", "down", "enter", "8", "2", "enter"
        )
        await driver.wait(300)
        await driver.press("enter", "0", "1")
        driver.see("You can rest now. Rest, and tell your therapist about the pain now.")
        driver.lacks("Well done")


async def test_after_an_ended_one_the_next_follows(alone: AppDriver) -> None:
    await alone.press(
        "enter", "enter", "escape", "down", "down", "down", "down", "enter", "down", "enter"
    )
    await alone.wait(300)
    await alone.press("enter")
    alone.see("Exercise 2 of 2")
    assert alone.stored("SELECT status FROM sessions") == [("aborted",)]


async def test_one_started_by_mistake_is_offered_again(alone: AppDriver) -> None:
    await alone.press(
        "enter", "enter", "escape", "down", "down", "down", "down", "enter", "down", "down", "enter"
    )
    await alone.wait(300)
    await alone.press("enter")
    alone.see("Exercise 1 of 2")
    alone.lacks("Please call your therapist")
    assert alone.stored("SELECT status FROM sessions") == [("discarded",)]


async def test_an_attempt_can_be_left_out(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", language="es")
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
        await driver.press("escape")
        driver.see("Saltar este intento", "Para el terapeuta")
        await driver.press("down", "down", "down", "enter")
        driver.see("Pulse Enter para el intento 2 de 2.", "Teclas 0 de 2")
        await driver.finish(await driver.begin())
        driver.see("Ha hecho 1 intento")
        session = driver.session_id
    assert stored(data, "SELECT attempt FROM attempts") == [(2,)]
    assert stored(data, "SELECT attempt, trial FROM trials") == [(1, 1), (2, 1), (2, 2)]
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    with closing(connect(data)) as database:
        assert session_facts.skipped_attempts(database, session) == [
            "Attempt 1 was skipped by the participant, after 1 of 2 trials."
        ]


KEYS = [
    "ctrl+q", "ctrl+c", "ctrl+z", "ctrl+backslash", "ctrl+p", "f2", "f3", "f4", "f10", "delete",
    "escape", "ctrl+s",
]  # fmt: skip


@pytest.mark.parametrize("key", first(2, KEYS))
async def test_no_key_leads_out_of_it(alone: AppDriver, key: str) -> None:
    await alone.press(key)
    assert alone.screen_name == "PatientScreen"
    await alone.press("enter")
    prompt = await alone.to_first_prompt()
    await alone.press(key)
    assert alone.screen_name == "SessionScreen"
    await alone.wait(3000)
    assert alone.app.is_running
    assert prompt.attempt == 1
    assert "P77" not in alone.text


@pytest.mark.parametrize("key", first(1, ["ctrl+q", "ctrl+c"]))
async def test_the_keys_that_leave_pause_instead(alone: AppDriver, key: str) -> None:
    await alone.press("enter")
    await alone.to_first_prompt()
    await alone.press(key)
    alone.see("Take your time.")
    alone.lacks("Ctrl-Q")
    await alone.press("enter")
    assert alone.waiting.stage == "trial"


async def test_no_screen_names_a_key_that_leaves(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "reaching", **REACHING, ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("down", "enter", "enter")
        assert driver.screen_name == "WellbeingScreen"
        driver.lacks("Quit")
        await driver.press("0", "1")
        assert driver.screen_name == "SensorCheckScreen"
        driver.lacks("Quit")
        await driver.press("f1")
        driver.see("without a sensor it waits for one.")
        driver.lacks("F2 on the first screen")


async def test_the_help_names_no_way_out(alone: AppDriver) -> None:
    for _ in range(2):
        await alone.press("f1")
        assert alone.screen_name == "HelpScreen"
        for word in ("Quit", "Ctrl-Q", "Settings", "F12"):
            assert word not in alone.text
        await alone.press("enter", "enter")
    assert alone.screen_name == "SessionScreen"


async def test_nobody_alone_can_mark_a_trial(opened: OpenApp, data: Path) -> None:
    programme(data, "P88", "reaching", **REACHING)
    async with opened(patient="P88") as driver:
        await driver.press("enter", "enter")
        await driver.wait(300)
        await driver.press("enter", "f1")
        driver.lacks("F7")
        await driver.press("enter", "enter", "space")
        await driver.wait(500)
        await driver.press("f7")
        driver.lacks("Marked")
        assert driver.messages("event_handler/marked") == []


async def test_the_passphrase_ends_it_at_the_first_screen(alone: AppDriver, data: Path) -> None:
    await end_mode(alone, "wrong one")
    alone.see("That is not the passphrase.")
    await alone.press("escape")
    assert alone.screen_name == "PatientScreen"
    await end_mode(alone)
    assert alone.screen_name == "HomeScreen"
    alone.see("P77")
    await alone.press("ctrl+q")
    assert not alone.app.is_running
    assert [each.result for each in Passphrase(data).tries()] == ["wrong", "right"]


async def test_it_begins_from_the_first_screen_and_ends_there_again(first_run: AppDriver) -> None:
    await first_run.press("f12")
    assert first_run.screen_name == "PatientScreen"
    await first_run.press("ctrl+q", "ctrl+p")
    assert first_run.screen_name == "PatientScreen"
    await end_mode(first_run)
    assert first_run.screen_name == "HomeScreen"
    await first_run.press("f2")
    assert first_run.screen_name == "SettingsScreen", "all keys work again"


async def test_ended_in_a_session_home_follows_that(alone: AppDriver) -> None:
    await alone.press("enter")
    await alone.to_first_prompt()
    await end_mode(alone)
    alone.see("Paused")
    await alone.press("enter")
    await alone.finish(await alone.to_prompt())
    await alone.press("enter")
    assert alone.screen_name == "HomeScreen"
    alone.see("2 of 2 reached")


async def test_a_removed_passphrase_still_guards(alone: AppDriver, data: Path) -> None:
    Passphrase(data).remove()
    await alone.press("enter", "enter", "escape", "up", "enter")
    assert alone.sees("Please enter the passphrase."), "the changes in a pause as well"
    await alone.press("escape")
    await end_mode(alone)
    assert not alone.app.patient


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


async def test_an_interrupted_session_goes_on(opened: OpenApp) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        driver.see("Welcome back")
    assert driver.stored("SELECT count(*) FROM sessions") == [(1,)]


async def test_one_of_days_ago_stays_for_the_therapist(opened: OpenApp, data: Path) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET started_at='2026-01-01T10:00:00+00:00'")
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        driver.see("Press Enter to go on.")
    assert stored(data, "SELECT count(*) FROM sessions") == [(2,)]


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


async def test_it_speaks_the_participants_language(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", language="es")
    async with opened(patient="P01") as driver:
        driver.see("Ejercicio 1 de 2", "Empezar", "Saltar este ejercicio")
        driver.see("Pulse Enter para empezar.")
        await driver.press("f12")
        driver.see("Escriba la contraseña.")


@pytest.mark.parametrize("size", first(1, [(80, 24), (100, 30), (160, 50)]))
async def test_all_of_it_fits(opened: OpenApp, size: tuple[int, int]) -> None:
    async with opened(patient="P01", size=size) as driver:
        driver.see("Exercise 1 of 2", "Keyboard reaction", "Skip this exercise", "Press Enter")
    async with opened(patient="P77", size=size) as driver:
        driver.see("Hello!")
        driver.lacks("Skip")


async def test_the_signals_of_a_terminals_keys_do_nothing_until_it_ends(opened: OpenApp) -> None:
    before = signal.getsignal(signal.SIGTSTP), signal.getsignal(signal.SIGQUIT)
    async with opened() as driver:
        await driver.press("f12")
        assert (
            signal.getsignal(signal.SIGTSTP) is signal.getsignal(signal.SIGQUIT) is signal.SIG_IGN
        )
        driver.app.signalled(signal.SIGINT)
        await driver.settle()
        assert driver.app.is_running
        await end_mode(driver)
        assert (signal.getsignal(signal.SIGTSTP), signal.getsignal(signal.SIGQUIT)) == before


async def test_without_the_focus_the_keys_still_work(alone: AppDriver) -> None:
    alone.app.screen.set_focus(None)
    await alone.press("enter")
    assert alone.screen_name == "SessionScreen"
    await alone.press("enter", "escape")
    alone.app.screen.set_focus(None)
    await alone.press("down", "down", "enter")
    alone.see("Have a rest")


async def test_enter_and_escape_in_one_burst_close_the_question_once(alone: AppDriver) -> None:
    await alone.write("f12", "enter", "escape", "escape")
    assert alone.screen_name == "PatientScreen"
    await alone.press("f12")
    await alone.write("enter", "escape", "escape")
    assert alone.app.is_running
    assert alone.screen_name == "PatientScreen"


THERAPISTS_KEYS = (
    *(f"f{number}" for number in range(3, 12)), "ctrl+p", "ctrl+s", "ctrl+l", "ctrl+d", "delete",
)  # fmt: skip


@pytest.mark.parametrize("task", ["keyboard", "reaching"])
async def test_therapists_keys_do_nothing(opened: OpenApp, data: Path, task: str) -> None:
    """The palette, settings, progress, sessions, marks, the operator's panel; F1 and F2 are a
    participant's, too.
    """
    settings = REACHING if task == "reaching" else {"attempts": 1}
    programme(data, "P05", task, ask_wellbeing=True, **settings)
    async with opened(patient="P05") as driver:
        screens = []

        async def try_keys() -> None:
            voids = len(driver.messages("event_handler/voided")) if driver.app.live else 0
            before = [type(screen) for screen in driver.app.screen_stack], driver.app.focused
            waiting = driver.waiting if driver.app.live else None
            for key in THERAPISTS_KEYS:
                await driver.strike(key)
                now = [type(screen) for screen in driver.app.screen_stack], driver.app.focused
                assert now == before, key
                driver.lacks("palette")
            if waiting and waiting.stage != "trial":
                assert driver.waiting == waiting
            if driver.app.live:
                assert len(driver.messages("event_handler/voided")) == voids
                assert {act["actor"] for act in driver.messages("operator/act")} <= {"participant"}
                assert driver.messages("event_handler/marked") == []
            screens.append(f"{driver.screen_name} {waiting.stage if waiting else ''}".strip())

        await try_keys()
        for key in ("enter", "0", "3", *["enter"] * (4 if task == "reaching" else 2)):
            await driver.press(key)
            await driver.wait(800)
            await try_keys()
        await driver.press("f1")
        await try_keys()
        await driver.press("escape", "f12")
        await try_keys()
    expected = {"PatientScreen", "WellbeingScreen", "SessionScreen instructions", "SessionScreen attempt",
                "SessionScreen trial", "HelpScreen paused", "PassphraseScreen paused"}  # fmt: skip
    assert expected | ({"SensorCheckScreen"} if task == "reaching" else set()) <= set(screens)
