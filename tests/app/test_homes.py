"""The therapist's first screen tells of people who train at home, and a message is written to them."""

from collections.abc import AsyncIterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest

from sar_tui.app.home.homes import Homes
from sar_tui.letterbox import letterbox, status
from sar_tui.letterbox.status import Home
from sar_tui.model.language import Language
from sar_tui.plugins import Catalogue
from sar_tui.rules.attention import AtHome
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect
from tests.app.app_driver import AppDriver, open_app, plan
from tests.app.test_at_home import letters
from tests.home_and_clinic import Pair, _joined, exchanged, pair

__all__ = ["_joined", "pair"]

TODAY = date(2026, 11, 25)
AT = datetime(2026, 11, 25, 14, 2)


@pytest.fixture
async def clinic(pair: Pair, catalogue: Catalogue) -> AsyncIterator[AppDriver]:
    """The first screen of the clinic, with P01 chosen, who trains at home."""
    async with open_app(pair.clinic, catalogue) as driver:
        await letters(driver)
        await choose(driver, "p01")
        yield driver


async def choose(driver: AppDriver, code: str) -> None:
    await driver.press("escape", *code)


async def test_who_trains_at_home_is_told_in_the_list_and_on_the_card(
    clinic: AppDriver, pair: Pair
) -> None:
    clinic.see("At home: heard today ", "F8 Message")
    await choose(clinic, "p02")
    clinic.lacks("F8 Message")
    await clinic.press("f8")
    assert clinic.screen_name == "HomeScreen"
    letterbox.invite(pair.clinic, "P02")
    clinic.app.screen.refresh_contents()  # type: ignore[attr-defined]
    await clinic.settle()
    clinic.see("P02 Invited, not joined yet", "At home: invited, not joined yet", "F8 Message")


async def test_a_revoked_home_is_named_and_cannot_be_written_to(
    clinic: AppDriver, pair: Pair
) -> None:
    letterbox.revoke(pair.clinic, "P01")
    clinic.app.screen.refresh_contents()  # type: ignore[attr-defined]
    await clinic.settle()
    clinic.see("At home: revoked")
    clinic.lacks("F8 Message")


async def test_the_card_that_was_looked_at_is_told_to_the_home(
    clinic: AppDriver, pair: Pair, catalogue: Catalogue
) -> None:
    train(pair, catalogue)
    clinic.app.exchange_letters()
    await letters(clinic)
    seen = "SELECT count(*) FROM letters WHERE direction='in' AND seen_at='' AND contents<>'{}'"
    assert clinic.stored(seen) == [(1,)], "nobody may have been here"
    await choose(clinic, "p02")
    assert clinic.stored(seen) == [(0,)]
    await letters(clinic)
    exchanged(pair.home)
    with closing(connect(pair.home)) as database:
        found = status.clinic(database)
    assert found
    assert found.seen == date.today()


def train(pair: Pair, catalogue: Catalogue) -> None:
    """Do a session at home, and send it."""
    simulate(plan(catalogue, catalogue.task("keyboard")), PEOPLE["average"], pair.home, catalogue)
    exchanged(pair.home)


async def test_a_message_and_days_are_written_and_its_way_is_told(
    clinic: AppDriver, pair: Pair
) -> None:
    await clinic.press("f8")
    assert clinic.screen_name == "MessageScreen"
    clinic.see("Message to P01", "Days of training, such as Mon, Wed, Fri:")
    await clinic.press("enter")
    clinic.see("Write a message first.")
    await clinic.write(*"Well done!")
    await clinic.press("tab", *"mon xyz")
    await clinic.press("enter")
    clinic.see("Days are Mon, Tue, Wed, Thu, Fri, Sat, Sun, not 'xyz'.")
    assert clinic.stored("SELECT count(*) FROM records") == [(0,)]
    await clinic.press("backspace", "backspace", "backspace", *"fri", "enter")
    assert clinic.screen_name == "HomeScreen"
    await letters(clinic)
    await clinic.press("f8")
    clinic.see("The last one, today: “Well done!”", "It has not arrived yet.")
    assert clinic.app.screen.query_one("#days").value == "Mon Fri"  # type: ignore[attr-defined]
    await clinic.press("enter")
    clinic.see("Write a message first.")
    await clinic.press("escape")
    exchanged(pair.home)
    exchanged(pair.clinic)
    await clinic.press("f8")
    clinic.see("It has arrived, and is not read yet.")
    with closing(connect(pair.home)) as database:
        assert [each.content["text"] for each in status.unread(database, "P01")] == ["Well done!"]
        assert status.training_days(database, "P01") == ("mon", "fri")


async def test_days_are_named_in_the_therapists_language(clinic: AppDriver) -> None:
    clinic.app.use_language("de")
    await clinic.press("f8")
    await clinic.press("tab", *"mo, mi", "enter")
    assert clinic.screen_name == "HomeScreen"
    await clinic.press("f8")
    assert clinic.app.screen.query_one("#days").value == "Mo Mi"  # type: ignore[attr-defined]


def home(**given: Any) -> Home:
    values: dict[str, Any] = {
        "name": "P01", "participant": "P01", "state": "joined", "invited_at": "", "expires_at": "",
        "heard_at": AT.astimezone(UTC).isoformat(), "missing": (), "waiting": 0, "since": "",
        "refused": (), "refused_at": "", "clock": "", "device": {},
    }  # fmt: skip
    return Home(**values | given)


def days_ago(days: int) -> str:
    return (AT - timedelta(days=days)).astimezone(UTC).isoformat()


@pytest.mark.parametrize(
    ("computers", "said"),
    [
        ([home()], "At home: heard today 14:02"),
        ([home(heard_at=days_ago(1))], "At home: heard yesterday"),
        ([home(heard_at=days_ago(5))], "At home: not heard for 5 days"),
        ([home(heard_at=days_ago(5)), home()], "At home: heard today 14:02"),
        ([home(missing=(2, 3))], "At home: heard today 14:02 · 2 letters missing"),
        ([home(missing=(2,))], "At home: heard today 14:02 · 1 letter missing"),
        ([home(clock="ahead")], "At home: the clock there is wrong · heard today 14:02"),
        ([home(state="invited", heard_at="")], "At home: invited, not joined yet"),
        ([home(heard_at="")], "At home: not heard yet"),
    ],
)
def test_the_state_of_a_home_in_words(computers: list[Home], said: str) -> None:
    found = Homes(computers)
    assert found.in_full(TODAY, Language()) == said
    shortly = said.split(" · ", maxsplit=1)[0].replace("At home: invited", "invited")
    assert found.shortly(TODAY, Language()) == shortly


def test_the_facts_that_may_need_a_look_are_of_computers_that_have_joined() -> None:
    refused = home(missing=(4,), refused_at=days_ago(2), heard_at=days_ago(9))
    invited = home(state="invited", heard_at="")
    assert Homes([refused, invited]).facts == AtHome(
        heard=TODAY - timedelta(9), missing=1, refused=TODAY - timedelta(2)
    )
    assert Homes([invited]).facts == AtHome()
