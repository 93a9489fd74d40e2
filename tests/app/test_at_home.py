"""A person trains at home: messages of the clinic, what it has seen, forms, and the exchange of letters
with the data folder of a real clinic.
"""

import shutil
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import pytest

from sar_tui.app.at_home import _next, _seen
from sar_tui.app.letters import Letters
from sar_tui.letterbox import correspondents, letterbox, post, status
from sar_tui.letterbox.exchange import Exchanged
from sar_tui.letterbox.status import LastMessage
from sar_tui.model.language import Language
from sar_tui.plugins import Catalogue
from sar_tui.store import records
from sar_tui.store.database import StoreError, connect, transaction
from tests.app.app_driver import AppDriver, given, open_app, stored
from tests.app.test_patient_mode import end_mode
from tests.app.test_read_aloud import Listener, Transcript, transcript
from tests.app.test_settings import fill
from tests.app.test_switch import OneSwitch
from tests.home_and_clinic import Pair, _joined, exchanged, pair
from tests.program import Call, call

__all__ = ["_joined", "call", "pair", "transcript"]

AtHome = Callable[..., AbstractAsyncContextManager[AppDriver]]
"""Opens the app at home, with all letters of the box taken."""
SESSION_IDS = "SELECT id FROM sessions ORDER BY id"


async def letters(driver: AppDriver) -> None:
    """Wait for the exchanges that are under way, and show what came."""
    assert driver.app.letters.wait(60)
    await driver.settle()


@pytest.fixture
def at_home(pair: Pair, catalogue: Catalogue) -> AtHome:
    @asynccontextmanager
    async def opened(**how: Any) -> AsyncIterator[AppDriver]:
        async with open_app(pair.home, catalogue, patient="P01", **how) as driver:
            await letters(driver)
            yield driver

    return opened


async def test_a_message_is_shown_before_the_exercises_and_the_clinic_hears_that_it_was_read(
    pair: Pair, at_home: AtHome
) -> None:
    pair.write("Please train with the left hand today.")
    async with at_home() as driver:
        driver.see("Klinik Bern", "A message from your therapist")
        driver.see("Please train with the left hand today.", "Press Enter when you have read it.")
        driver.lacks("Start", "Ctrl-Q", "Esc")
        await driver.press("escape", "x")
        driver.see("Please train with the left hand today.")
        assert _last_message(pair).read_at == ""
        await driver.press("enter")
        driver.see("Start", "Press Enter to start.")
        await letters(driver)
    exchanged(pair.clinic)
    assert _last_message(pair).read_at
    async with at_home() as driver:
        driver.see("Press Enter to start.")


async def test_several_messages_come_one_after_the_other_and_a_held_key_skips_none(
    pair: Pair, at_home: AtHome
) -> None:
    pair.write("The first.", "The second.", "The third.")
    async with at_home() as driver:
        driver.see("The first.", "1 of 3")
        await driver.press("enter")
        await driver.strike("enter", "enter", "enter")
        driver.see("The second.", "2 of 3")
        await driver.press("enter")
        driver.see("The third.", "3 of 3")
        await end_mode(driver)
        driver.see("The third.")
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen", "the therapist has closed it"
        await letters(driver)
    exchanged(pair.clinic)
    assert _last_message(pair).read_at == "", "the participant has not read all"


async def test_a_message_that_comes_while_another_is_read_is_shown_too(
    pair: Pair, at_home: AtHome
) -> None:
    pair.write("The first.")
    async with at_home() as driver:
        pair.write("The second.")
        driver.app.exchange_letters()
        await letters(driver)
        driver.see("The first.")
        await driver.press("enter")
        driver.see("The second.")
        read = "SELECT count(*)>0 FROM letters WHERE seen_at<>'' AND direction='in'"
        assert driver.stored(read) == [(0,)]
        await driver.press("enter")
        driver.see("Press Enter to start.")
        assert driver.stored(read) == [(1,)]


@pytest.mark.parametrize("size", [(80, 24), (160, 48)])
async def test_the_longest_message_is_on_the_screen_in_ones_own_language(
    pair: Pair, at_home: AtHome, size: tuple[int, int]
) -> None:
    pair.set_programme(language="de")
    text = " ".join(["Bitte"] * 50)[: post.LONGEST_MESSAGE]
    assert len(text) > post.LONGEST_MESSAGE - 6
    pair.write(text)
    async with at_home(size=size) as driver:
        driver.see("Eine Nachricht von Ihrer Betreuungsperson", text)
        driver.see("Gelesen? Dann drücken Sie")


async def test_with_one_switch_messages_are_read_and_a_form_is_put_off(
    pair: Pair, at_home: AtHome
) -> None:
    pair.set_programme("gonogo", switch="one")
    pair.write("Well done!")
    pair.ask("SUS")
    async with at_home() as driver:
        switch = OneSwitch(driver)
        driver.see("Well done!")
        await switch.choose("I have read it")
        driver.see("Your therapist would like to know how you are.")
        driver.lacks("Press Esc")
        await switch.choose("Later")
        await switch.wait_for("Start")


async def test_messages_and_what_was_seen_are_read_aloud(
    pair: Pair, at_home: AtHome, transcript: Transcript
) -> None:
    pair.set_programme(read_aloud=True, outputs=["screen", "speech"])
    pair.write("Well done! See you on Monday.")
    pair.at_clinic(lambda db: post.plan_days(db, "P01", [_day_after_tomorrow()], author="Ana"))
    async with at_home() as driver:
        driver.see("Well done! See you on Monday.")
        await Listener(driver, transcript).press("enter")
        assert any(text.startswith("Next training: ") for text in transcript.read)


def _day_after_tomorrow() -> str:
    return status.DAYS[(date.today() + timedelta(days=2)).weekday()]


def _last_message(pair: Pair) -> LastMessage:
    with closing(connect(pair.clinic)) as database:
        found = status.last_message(database, "P01")
    assert found
    return found


# --- what was seen, and what is next


async def test_training_that_was_seen_and_the_next_one_are_told(
    pair: Pair, at_home: AtHome
) -> None:
    async with at_home() as driver:
        await driver.press("enter")
        await driver.do_session()
        driver.lacks("Your therapist has seen")
        await driver.press("enter")
        await letters(driver)
        session = driver.session_id
        exchanged(pair.clinic)
        assert stored(pair.clinic, SESSION_IDS) == [(session,)], "it was sent at once"
        pair.at_clinic(_look)
        driver.app.exchange_letters()
        await letters(driver)
        driver.see("Your therapist has seen today's training.")
    pair.at_clinic(lambda db: post.plan_days(db, "P01", [_day_after_tomorrow()], author="Ana"))
    async with at_home() as driver:
        driver.see("Your therapist has seen today's training. Next training: ")
        driver.app.today = lambda: date.today() + timedelta(days=2)
        driver.app.screen.show_exercise()  # type: ignore[attr-defined]
        await driver.settle()
        driver.see(f"Your therapist has seen {date.today():%A}'s training.")
        driver.lacks("Next training")


def _look(database: Any) -> None:
    with transaction(database) as inside:
        assert correspondents.mark_seen(inside, "P01")


def test_the_day_that_was_seen_is_named_for_a_week() -> None:
    tuesday, tr = date(2026, 11, 24), Language()
    assert _seen(tuesday, tuesday, tr) == "Your therapist has seen today's training."
    for days in (1, 6):
        later = tuesday + timedelta(days)
        assert _seen(tuesday, later, tr) == "Your therapist has seen Tuesday's training."
    for day in (None, tuesday - timedelta(7), tuesday + timedelta(1)):
        assert _seen(day, tuesday, tr) == ""


@pytest.mark.parametrize(
    ("days", "said"),
    [
        ("", ""),
        ("tue", ""),
        ("mon tue", ""),
        ("wed fri", "Next training: tomorrow."),
        ("mon fri", "Next training: Friday."),
        ("mon", "Next training: Monday."),
    ],
)
def test_the_next_day_of_training_is_named_unless_it_is_today(days: str, said: str) -> None:
    assert _next(days.split(), date(2026, 11, 24), Language()) == said


async def test_a_home_whose_letters_are_refused_is_told_to_call(
    pair: Pair, at_home: AtHome
) -> None:
    letterbox.revoke(pair.clinic, "P01")
    exchanged(pair.clinic)
    async with at_home() as driver:
        driver.see("Your results do not reach your therapist. Please call them.")
        assert driver.app.patient_mode.troubles == [
            "The clinic takes no letters from this computer. Ask it for a new invitation."
        ]
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen", "to train is possible"


# --- a form


async def test_a_form_is_filled_in_before_the_exercises_and_reaches_the_clinic(
    pair: Pair, at_home: AtHome
) -> None:
    pair.ask("SUS")
    async with at_home() as driver:
        driver.see("Your therapist would like to know how you are.", "Press Enter to answer.")
        driver.see("Press Esc to answer later.")
        await driver.press("enter")
        driver.see("Item 1 of 10")
        await driver.press(*given(*"1234512345"), "enter")
        driver.see("Press Enter to start.")
        await letters(driver)
    exchanged(pair.clinic)
    with closing(connect(pair.clinic)) as database:
        (record,) = records.listing(database, participant="P01", kinds=["SUS"])
    assert record.content["status"] == "complete"
    async with at_home() as driver:
        driver.see("Press Enter to start.")


async def test_a_form_is_put_off_or_left_and_offered_the_next_time(
    pair: Pair, at_home: AtHome
) -> None:
    pair.ask("SUS")
    async with at_home() as driver:
        await driver.press("escape")
        driver.see("Press Enter to start.")
        driver.app.screen.show_exercise()  # type: ignore[attr-defined]
        await driver.settle()
        driver.see("Press Enter to start.")
    async with at_home() as driver:
        await driver.press("enter", "2", "enter", "escape", "escape")
        driver.see("Press Enter to start.")
    async with at_home() as driver:
        driver.see("Your therapist would like to know how you are.")


# --- the exchange


async def test_a_new_programme_takes_effect_at_the_next_start(pair: Pair, at_home: AtHome) -> None:
    async with at_home() as driver:
        driver.see("Keyboard reaction", "2 attempts")
        pair.set_programme(attempts=3)
        driver.app.exchange_letters()
        await letters(driver)
        driver.see("3 attempts")
        pair.set_programme("reaching", imu="simulated", attempts=1, reaches_per_attempt=1)
        driver.app.exchange_letters()
        await letters(driver)
        driver.see("Exercise 1 of 2")


async def test_nothing_is_exchanged_during_a_session_and_what_is_due_is_sent_at_the_end(
    pair: Pair, at_home: AtHome
) -> None:
    async with at_home() as driver:
        await driver.press("enter")
        pair.write("Not now.")
        await driver.answer(await driver.to_first_prompt())
        before = stored(pair.home, "SELECT count(*) FROM letters")
        driver.app.exchange_letters()
        await letters(driver)
        assert stored(pair.home, "SELECT count(*) FROM letters") == before
        session = driver.session_id
    driver.app.letters.finish()
    exchanged(pair.clinic)
    assert stored(pair.clinic, SESSION_IDS) == [(session,)]


async def test_a_letterbox_that_is_gone_is_told_to_the_therapist_alone(
    pair: Pair, at_home: AtHome
) -> None:
    shutil.rmtree(pair.box)
    async with at_home() as driver:
        driver.see("Press Enter to start.")
        driver.lacks("letterbox")
        driver.app.exchange_letters()
        await letters(driver)
        (told,) = driver.app.patient_mode.troubles
        assert told.startswith("The letterbox ")


def test_one_exchange_follows_another_and_errors_are_handed_on(pair: Pair) -> None:
    found: list[Exchanged | StoreError] = []
    both = Letters(pair.home, found.append)
    assert (both.role, both.clinic) == ("home", "Klinik Bern")
    pair.write("One.")
    both.begin()
    both.begin()
    both.finish()
    assert both.wait(60)
    assert [each.taken for each in found if isinstance(each, Exchanged) and each.taken] == [
        [("P01", 1)]
    ]
    (pair.home / "letterbox.json").write_text("{")
    damaged = Letters(pair.home, found.append)
    assert damaged.role == ""
    damaged.finish()
    assert damaged.wait(60)
    assert isinstance(found[-1], StoreError)


def test_without_a_letterbox_nothing_of_it_is_loaded(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from sar_tui.app.app import SarTui; "
        "from sar_tui.plugins import Catalogue; app = SarTui(Path(sys.argv[1]), Catalogue()); "
        "app.exchange_letters(); app.letters.finish(); "
        "assert not [name for name in sys.modules if 'letterbox.' in name]"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "data")], check=True)


# --- programmes are the clinic's


async def test_at_home_a_therapist_is_told_where_programmes_are_changed(
    pair: Pair, catalogue: Catalogue
) -> None:
    where = "The programme comes from the clinic: change it there."
    async with open_app(pair.home, catalogue) as driver:
        await driver.press("f2")
        driver.see(where)
        driver.app.clear_notifications()
        await fill(driver, "threshold", "0.9")
        await driver.press("ctrl+s")
        assert driver.screen_name == "SettingsScreen", "no reason is asked for"
        driver.see(where)
        await driver.press("escape")
        driver.app.clear_notifications()
        saved = driver.stored("SELECT count(*) FROM programmes")
        await driver.press("right", "right", "down", "enter", "enter")
        driver.see(where)
        assert driver.stored("SELECT count(*) FROM programmes") == saved


def test_at_home_no_programme_is_imported(pair: Pair, call: Call) -> None:
    what = ("programme import P01 keyboard --preset mild --reason Better --data",)
    call(*what, pair.home).refused("The programme comes from the clinic: change it there.")
    assert call(*what, pair.clinic).code == 0
