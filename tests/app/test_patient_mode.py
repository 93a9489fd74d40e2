"""Patient mode: the exercises follow each other, and only the passphrase leads anywhere else."""

import signal
from pathlib import Path

import pytest

from sar_tui.app.app import SarTui
from sar_tui.plugins import Catalogue
from sar_tui.reports import session_facts
from sar_tui.store import participants, passphrase, programmes
from sar_tui.store.database import StoreError, connect
from sar_tui.store.passphrase import Passphrase
from tests.app.app_driver import SHORT, AppDriver, OpenApp, open_app, stored
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
    database = connect(data)
    participants.add(database, participant)
    values = {**(SHORT if task == "keyboard" else {}), **parameters}
    before = programmes.newest(database, participant, task).version
    programmes.save(database, participant, task, programmes.Programme(values), after=before)
    database.close()


async def end_mode(driver: AppDriver, text: str = RIGHT) -> None:
    await driver.press("f12")
    await driver.write(*text)
    await driver.press("enter")
    await driver.settle()


async def test_enter_starts_the_first_exercise_and_the_next_one_follows_its_summary(
    opened: OpenApp, data: Path
) -> None:
    async with opened(patient="P01") as driver:
        assert driver.sees("Exercise 1 of 2")
        assert driver.sees("Keyboard reaction 2 attempts")
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter")
        assert driver.sees("Exercise 2 of 2")
        assert driver.sees("Reaching 1 attempt")
        await driver.press("down", "enter")
        assert driver.sees("That was everything. Well done!")
        await driver.press("enter")
        assert driver.sees("Exercise 1 of 2")
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]


@pytest.mark.slow
async def test_after_the_limit_of_a_day_the_next_exercise_follows_and_then_a_rest(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P01", "keyboard", attempts_a_day=1)
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter")
        assert driver.sees("Exercise 2 of 2")
        await driver.press("down", "enter", "enter", "enter")
        assert driver.sees("Exercise 2 of 2")
        assert not driver.sees("Please call your therapist")
    programme(data, "P77", "keyboard", attempts_a_day=1)
    async with opened(patient="P77") as driver:
        await driver.press("enter")
        await driver.do_session()
        await driver.press("enter", "enter", "enter")
        assert driver.sees("That is enough for today. Well done!")
        assert driver.sees("You can rest now.")
        await driver.press("enter")
        assert driver.sees("Keyboard reaction")
        assert driver.app.patient_mode.troubles[0].startswith("That is enough for P77 today")


async def test_one_enter_never_begins_an_exercise_in_severe_pain(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P01", "keyboard", ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("enter", "9", "3", "2")
        assert driver.sees("Please do not train now")
        await driver.press("enter")
        assert driver.sees("You can rest now.")
        assert driver.sees("Rest, and tell your therapist about the pain now.")
        assert driver.sees("Nobody is watching this screen")
        await driver.press("enter")
        assert driver.sees("Exercise 1 of 2")
        await driver.press("enter")
        assert driver.sees("How much pain do you have now?"), "it is asked again"
        assert (
            "P01: The participant was advised not to train, and stopped."
            in driver.app.patient_mode.troubles
        )
    assert stored(data, "SELECT count(*) FROM sessions") == [(0,)]


async def test_after_too_much_pain_in_an_exercise_nothing_invites_to_the_next(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P01", "keyboard", ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("enter", "3", "5", "1")
        await driver.do_session()
        await driver.press("enter", "6", "5", "4")
        assert driver.sees("Please rest now")
        await driver.press("enter")
        assert driver.sees("You can rest now. Rest, and tell your therapist about the pain now.")
        assert not driver.sees("Press Enter to start.")
        await driver.press("enter")
        assert driver.sees("Exercise 2 of 2")


async def test_who_ends_an_exercise_in_too_much_pain_is_asked_to_rest(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P77", "keyboard", ask_wellbeing=True)
    async with opened(patient="P77") as driver:
        await driver.press(
            "enter", "0", "1", "enter", "escape", "down", "down", "enter", "8", "2", "enter"
        )
        await driver.wait(300)
        await driver.press("enter", "0", "1")
        assert driver.sees("You can rest now. Rest, and tell your therapist about the pain now.")
        assert not driver.sees("Well done")


async def test_an_exercise_can_be_ended_and_the_next_one_follows(
    opened: OpenApp, data: Path
) -> None:
    async with opened(patient="P01") as driver:
        await driver.press(
            "enter", "enter", "escape", "down", "down", "down", "down", "enter", "down", "enter"
        )
        await driver.wait(300)
        await driver.press("enter")
        assert driver.sees("Exercise 2 of 2")
    assert stored(data, "SELECT status FROM sessions") == [("aborted",)]


async def test_an_exercise_that_was_started_by_mistake_is_offered_again(
    opened: OpenApp, data: Path
) -> None:
    async with opened(patient="P01") as driver:
        await driver.press(
            "enter",
            "enter",
            "escape",
            "down",
            "down",
            "down",
            "down",
            "enter",
            "down",
            "down",
            "enter",
        )
        await driver.wait(300)
        await driver.press("enter")
        assert driver.sees("Exercise 1 of 2")
        assert not driver.sees("Please call your therapist")
    assert stored(data, "SELECT status FROM sessions") == [("discarded",)]


async def test_an_attempt_can_be_left_out_and_the_next_one_follows(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P01", "keyboard", language="es")
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
        await driver.press("escape")
        for words in ("Saltar este intento", "Para el terapeuta"):
            assert driver.sees(words), words
        await driver.press("down", "down", "down", "enter")
        assert driver.sees("Pulse Enter para el intento 2 de 2.")
        assert driver.sees("Teclas 0 de 2")
        await driver.do_attempt(await driver.begin())
        await driver.see_the_summary()
        assert driver.sees("Ha hecho 1 intento")
        session = driver.session_id
    assert stored(data, "SELECT attempt FROM attempts") == [(2,)]
    assert stored(data, "SELECT attempt, trial FROM trials") == [(1, 1), (2, 1), (2, 2)]
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    database = connect(data)
    assert session_facts.skipped_attempts(database, session) == [
        "Attempt 1 was skipped by the participant, after 1 of 2 trials."
    ]
    database.close()


KEYS = [
    "ctrl+q",
    "ctrl+c",
    "ctrl+z",
    "ctrl+backslash",
    "ctrl+p",
    "f2",
    "f3",
    "f4",
    "f10",
    "delete",
    "escape",
    "ctrl+s",
]


@pytest.mark.parametrize("key", first(2, KEYS))
async def test_no_key_leads_out_of_it(opened: OpenApp, key: str) -> None:
    async with opened(patient="P01") as driver:
        await driver.press(key)
        assert driver.screen_name == "PatientScreen"
        await driver.press("enter")
        prompt = await driver.to_first_prompt()
        await driver.press(key)
        assert driver.screen_name == "SessionScreen"
        await driver.wait(3000)
        assert driver.app.is_running
        assert prompt.attempt == 1
        assert "P77" not in driver.text


@pytest.mark.parametrize("key", first(1, ["ctrl+q", "ctrl+c"]))
async def test_the_keys_that_leave_pause_instead(opened: OpenApp, key: str) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.to_first_prompt()
        await driver.press(key)
        assert driver.sees("Take your time.")
        assert not driver.sees("Ctrl-Q")
        await driver.press("enter")
        assert driver.waiting.stage == "trial"


async def test_screens_around_a_session_name_no_key_that_leaves(
    opened: OpenApp, data: Path
) -> None:
    programme(data, "P01", "reaching", **REACHING, ask_wellbeing=True)
    async with opened(patient="P01") as driver:
        await driver.press("down", "enter", "enter")
        assert driver.screen_name == "WellbeingScreen"
        assert not driver.sees("Quit")
        await driver.press("0", "1")
        assert driver.screen_name == "SensorCheckScreen"
        assert not driver.sees("Quit")
        await driver.press("f1")
        assert driver.sees("without a sensor it waits for one.")
        assert not driver.sees("F2 on the first screen")


async def test_the_help_names_no_way_out(opened: OpenApp) -> None:
    async with opened(patient="P01") as driver:
        for _ in range(2):
            await driver.press("f1")
            assert driver.screen_name == "HelpScreen"
            for word in ("Quit", "Ctrl-Q", "Settings", "F12"):
                assert word not in driver.text
            await driver.press("enter", "enter")
        assert driver.screen_name == "SessionScreen"


async def test_nobody_alone_can_mark_a_trial(opened: OpenApp, data: Path) -> None:
    programme(data, "P88", "reaching", **REACHING)
    async with opened(patient="P88") as driver:
        await driver.press("enter", "enter")
        await driver.wait(300)
        await driver.press("enter", "f1")
        assert not driver.sees("F7")
        await driver.press("enter", "enter", "space")
        await driver.wait(500)
        await driver.press("f7")
        assert not driver.sees("Marked")
        assert driver.messages("event_handler/marked") == []


async def test_the_passphrase_ends_it_at_the_first_screen(opened: OpenApp, data: Path) -> None:
    async with opened(patient="P01") as driver:
        await end_mode(driver, "wrong one")
        assert driver.sees("That is not the passphrase.")
        await driver.press("escape")
        assert driver.screen_name == "PatientScreen"
        await end_mode(driver)
        assert driver.screen_name == "HomeScreen"
        assert driver.sees("P77")
        await driver.press("ctrl+q")
        assert not driver.app.is_running
    assert [each.result for each in Passphrase(data).tries()] == ["wrong", "right"]


async def test_it_begins_from_the_first_screen_and_ends_there_again(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f12")
        assert driver.screen_name == "PatientScreen"
        await driver.press("ctrl+q", "ctrl+p")
        assert driver.screen_name == "PatientScreen"
        await end_mode(driver)
        assert driver.screen_name == "HomeScreen"
        await driver.press("f2")
        assert driver.screen_name == "SettingsScreen", "all keys work again"


async def test_ended_in_a_session_the_session_goes_on_and_the_first_screen_follows(
    opened: OpenApp,
) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.to_first_prompt()
        await end_mode(driver)
        assert driver.sees("Paused")
        await driver.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        await driver.do_attempt(await driver.begin())
        await driver.see_the_summary()
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        assert driver.sees("2 of 2 reached")


async def test_a_passphrase_that_is_removed_meanwhile_still_guards(
    opened: OpenApp, data: Path
) -> None:
    async with opened(patient="P01") as driver:
        Passphrase(data).remove()
        await driver.press("enter", "enter", "escape", "up", "enter")
        assert driver.sees("Please enter the passphrase."), "the changes in a pause as well"
        await driver.press("escape")
        await end_mode(driver)
        assert not driver.app.patient


async def test_without_a_passphrase_or_an_exercise_it_does_not_begin(
    data: Path, catalogue: Catalogue
) -> None:
    app = SarTui(data, catalogue)
    with pytest.raises(StoreError, match="no exercise to do alone"):
        app.patient_mode.exercises_of("P99")
    Passphrase(data).remove()
    with pytest.raises(StoreError, match="There is no passphrase"):
        app.patient_mode.exercises_of("P01")
    app.database.close()
    async with open_app(data, catalogue) as driver:
        await driver.press("f12")
        assert driver.screen_name == "HomeScreen"
        assert driver.sees("There is no passphrase. Set one: sar-tui passphrase.")


async def test_an_interrupted_session_goes_on(opened: OpenApp, data: Path) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        assert driver.sees("Welcome back")
    assert stored(data, "SELECT count(*) FROM sessions") == [(1,)]


async def test_one_of_days_ago_stays_for_the_therapist(opened: OpenApp, data: Path) -> None:
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        await driver.answer(await driver.to_first_prompt())
    database = connect(data)
    database.execute("UPDATE sessions SET started_at='2026-01-01T10:00:00+00:00'")
    database.close()
    async with opened(patient="P01") as driver:
        await driver.press("enter")
        assert driver.sees("Press Enter to go on.")
    assert stored(data, "SELECT count(*) FROM sessions") == [(2,)]


async def test_an_exercise_that_cannot_begin_says_to_call_the_therapist_who_then_reads_why(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise StoreError("The disk is full.")

    async with opened(patient="P01") as driver:
        with monkeypatch.context() as patch:
            patch.setattr("sar_tui.app.live.LiveSession.open", fail)
            await driver.press("enter")
        assert driver.sees("This does not work now. Please call your therapist.")
        assert not driver.sees("The disk is full.")
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen", "it can be tried again"
        await end_mode(driver)
        assert driver.sees("The disk is full.")


async def test_it_speaks_the_participants_language(opened: OpenApp, data: Path) -> None:
    programme(data, "P01", "keyboard", language="es")
    async with opened(patient="P01") as driver:
        for words in (
            "Ejercicio 1 de 2",
            "Empezar",
            "Saltar este ejercicio",
            "Pulse Enter para empezar.",
        ):
            assert driver.sees(words), words
        await driver.press("f12")
        assert driver.sees("Escriba la contraseña.")


@pytest.mark.parametrize("size", first(1, [(80, 24), (100, 30), (160, 50)]))
async def test_all_of_it_fits(opened: OpenApp, size: tuple[int, int]) -> None:
    async with opened(patient="P01", size=size) as driver:
        for words in (
            "Exercise 1 of 2",
            "Keyboard reaction",
            "Start",
            "Skip this exercise",
            "Press Enter to start.",
        ):
            assert driver.sees(words), words
    async with opened(patient="P77", size=size) as driver:
        assert driver.sees("Hello!")
        assert not driver.sees("Skip")


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


async def test_without_the_focus_the_keys_still_work(opened: OpenApp) -> None:
    async with opened(patient="P01") as driver:
        driver.app.screen.set_focus(None)
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen"
        await driver.press("enter", "escape")
        driver.app.screen.set_focus(None)
        await driver.press("down", "down", "enter")
        assert driver.sees("Have a rest")


async def test_enter_and_escape_in_one_burst_close_the_question_once(opened: OpenApp) -> None:
    async with opened(patient="P01") as driver:
        await driver.write("f12", "enter", "escape", "escape")
        assert driver.screen_name == "PatientScreen"
        await driver.press("f12")
        await driver.write("enter", "escape", "escape")
        assert driver.app.is_running
        assert driver.screen_name == "PatientScreen"


THERAPISTS_KEYS = (
    *(f"f{number}" for number in range(3, 12)),
    "ctrl+p",
    "ctrl+s",
    "ctrl+l",
    "ctrl+d",
    "delete",
)


@pytest.mark.parametrize("task", ["keyboard", "reaching"])
async def test_keys_of_therapists_do_nothing_on_any_screen(
    opened: OpenApp, data: Path, task: str
) -> None:
    """The palette, settings, progress, sessions, marks, the operator's panel; F1 and F2 are a
    participant's, too.
    """
    programme(
        data,
        "P05",
        task,
        ask_wellbeing=True,
        **(REACHING if task == "reaching" else {"attempts": 1}),
    )
    async with opened(patient="P05") as driver:
        screens = []

        async def try_keys() -> None:
            voids = len(driver.messages("event_handler/voided")) if driver.app.live else 0
            before = [type(screen) for screen in driver.app.screen_stack], driver.app.focused
            waiting = driver.waiting if driver.app.live else None
            for key in THERAPISTS_KEYS:
                await driver.strike(key)
                assert (
                    [type(screen) for screen in driver.app.screen_stack],
                    driver.app.focused,
                ) == before, key
                assert not driver.sees("palette")
            if waiting and waiting.stage != "trial":
                assert driver.waiting == waiting
            if driver.app.live:
                assert len(driver.messages("event_handler/voided")) == voids
                assert {act["actor"] for act in driver.messages("operator/act")} <= {"participant"}
                assert driver.messages("event_handler/marked") == []
            screens.append(f"{driver.screen_name} {waiting.stage if waiting else ''}".strip())

        for key in (
            "",
            "enter",
            "0",
            "3",
            *(["enter", "enter"] if task == "reaching" else []),
            "enter",
            "enter",
        ):
            await driver.press(*filter(None, [key]))
            await driver.wait(800)
            await try_keys()
        await driver.press("f1")
        await try_keys()
        await driver.press("escape", "f12")
        await try_keys()
    expected = {"PatientScreen", "WellbeingScreen", "SessionScreen instructions", "SessionScreen attempt",
                "SessionScreen trial", "HelpScreen paused", "PassphraseScreen paused"}  # fmt: skip
    assert expected | ({"SensorCheckScreen"} if task == "reaching" else set()) <= set(screens)
