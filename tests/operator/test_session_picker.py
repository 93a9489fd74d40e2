"""Choice of a session, and its panel."""

import re
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.app.screens import home
from sar_tui.link import discovery as link_folder
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import NAME, Invitation
from sar_tui.link.peer import PeerListener
from sar_tui.link.visits import HomeVisit
from sar_tui.link.zenoh_settings import Credentials
from sar_tui.model.protocol import WizardProtocol
from sar_tui.operator import app as operator_app
from sar_tui.operator.app import HOW_TO_START, ChooseScreen, HomesScreen, WizardApp, own_name
from sar_tui.operator.screen import PanelScreen
from sar_tui.plugins import Catalogue
from sar_tui.widgets.lists import OptionList
from tests.app.app_driver import open_app
from tests.operator.panel_driver import FakePeer

ONE = JoinableSession("s1", "keyboard", "abcd", 1)
OTHER = JoinableSession("s2", "reaching", "abce", 2)


@pytest.fixture
def joined(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Sessions that were joined, with names and roles, over fake links."""
    found: list[Any] = []

    def connect(where: Any, name: str, role: Any, listener: PeerListener, loop: Any) -> FakePeer:
        found.append((where, name, role))
        return FakePeer(listener, role)

    monkeypatch.setattr(operator_app, "connect", connect)
    return found


def here(live: JoinableSession, folder: Path) -> JoinableSession:
    return msgspec.structs.replace(live, data=link_folder.folder_name(folder))


@pytest.fixture
def there(monkeypatch: pytest.MonkeyPatch) -> list[JoinableSession]:
    """The sessions on this machine."""
    found: list[JoinableSession] = []
    monkeypatch.setattr(link_folder, "live_sessions", lambda: found)
    return found


def wizard(catalogue: Catalogue, folder: Path, *, waits: bool = False) -> WizardApp:
    return WizardApp(catalogue.theme("calm"), folder, "anna", waits=waits)


async def test_sessions_are_listed_with_their_facts_and_the_panel_of_the_chosen_one_opens(
    catalogue: Catalogue, tmp_path: Path, joined: list[Any], there: list[JoinableSession]
) -> None:
    facts = {"participants": ("P01", "P02"), "started": "2026-01-02T03:04:05+00:00"}
    there += [msgspec.structs.replace(here(ONE, tmp_path), **facts), here(OTHER, tmp_path)]
    app = wizard(catalogue, tmp_path)
    async with app.run_test() as pilot:
        await pilot.pause()
        listed = app.screen.query_one("#box", OptionList)
        began = datetime.fromisoformat("2026-01-02T03:04:05+00:00").astimezone()
        first = str(listed.get_option_at_index(0).prompt)
        assert first == f"P01 and P02, keyboard, since {began:%Y-%m-%d %H:%M}   s1"
        await pilot.press("down", "enter")
        await pilot.pause()
        assert isinstance(app.screen, PanelScreen)
    assert joined == [(there[1], "anna", "operator")]


async def test_a_session_of_another_data_folder_is_named_but_never_joined(
    catalogue: Catalogue, tmp_path: Path, joined: list[Any], there: list[JoinableSession]
) -> None:
    there.append(here(ONE, tmp_path / "other"))
    app = wizard(catalogue, tmp_path, waits=True)
    async with app.run_test() as pilot:
        await pilot.pause()
        assert isinstance(app.screen, ChooseScreen)
        assert str(tmp_path / "other") in str(app.screen.query_one("#hint").render())
        there.append(here(OTHER, tmp_path))
        app.screen.look_again()
        await pilot.pause()
    assert joined == [(there[1], "anna", "operator")]


async def test_without_a_session_it_says_how_to_start_one_and_joins_the_first(
    catalogue: Catalogue, tmp_path: Path, joined: list[Any], there: list[JoinableSession]
) -> None:
    app = wizard(catalogue, tmp_path, waits=True)
    async with app.run_test() as pilot:
        await pilot.pause()
        assert isinstance(app.screen, ChooseScreen)
        assert HOW_TO_START.split(":")[0] in str(app.screen.query_one("#hint").render())
        there.append(here(ONE, tmp_path))
        app.screen.look_again()
        await pilot.pause()
        assert isinstance(app.screen, PanelScreen)
    assert joined == [(there[0], "anna", "operator")]


async def test_the_choice_survives_any_size_of_the_window_and_leaving_it_leaves_the_app(
    catalogue: Catalogue, tmp_path: Path, there: list[JoinableSession]
) -> None:
    there += [here(ONE, tmp_path), here(OTHER, tmp_path)]
    app = wizard(catalogue, tmp_path)
    async with app.run_test() as pilot:
        for size in [(30, 5), (1, 1), (20, 200), (200, 1), (80, 24)]:
            await pilot.resize_terminal(*size)
        assert isinstance(app.screen, ChooseScreen)
        await pilot.press("escape")
    assert app.return_code == 0


async def test_a_failed_link_ends_the_app_with_a_message(
    catalogue: Catalogue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise LinkError("The link needs Python packages.")

    monkeypatch.setattr(operator_app, "connect", refuse)
    app = WizardApp(catalogue.theme("calm"), tmp_path, "anna", where=ONE)
    async with app.run_test() as pilot:
        await pilot.pause()
    assert (app.return_code, app.failure) == (1, "The link needs Python packages.")


FOLLOWED = WizardProtocol(name="praise", version=2, hash="ab")


async def test_home_offers_the_panel_while_a_session_can_be_joined(
    data: Path, catalogue: Catalogue, joined: list[Any], there: list[JoinableSession]
) -> None:
    async with open_app(data, catalogue) as driver:
        assert not driver.sees("Operator's panel")
        await driver.press("f3")
        there += [here(OTHER, data / "other"), here(ONE, data)]
        assert isinstance(driver.app.screen, home.HomeScreen)
        driver.app.screen._look_again()
        await driver.settle()
        assert driver.sees("Operator's panel")
        driver.app.protocol = FOLLOWED
        await driver.press("f3")
        assert isinstance(driver.app.screen, PanelScreen)
        assert driver.app.screen.protocol.own is FOLLOWED
        await driver.press("q", "q")
        assert driver.screen_name == "HomeScreen"
    assert [(where, role) for where, _, role in joined] == [(there[1], "operator")]


@pytest.mark.parametrize("login", ["anna", "Ünal.K", "-x-", "", "a" * 80])
def test_a_login_name_becomes_a_valid_name(login: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", login)
    for name in ("USER", "LNAME", "USERNAME"):
        monkeypatch.delenv(name, raising=False)
    assert re.fullmatch(NAME, own_name())


# --- homes


INVITED = Invitation(
    role="operator",
    name="anna",
    link="0123456789ab",
    endpoints=("visits.clinic.example",),
    expires=datetime(2030, 1, 1, tzinfo=UTC),
    credentials=Credentials("", "", ""),
    router=True,
)


class FakeFinder:
    """Finds the homes that a test names."""

    made: list["FakeFinder"] = []

    def __init__(self, invitation: Invitation, on_change: Callable[[], object]) -> None:
        self.homes: tuple[str, ...] = ()
        self.why = ""
        self.is_open = False
        self._on_change = on_change
        self.made.append(self)

    def open(self) -> None:
        self.is_open = True

    def close(self) -> None:
        self.is_open = False

    def find(self, *homes: str, why: str = "") -> None:
        self.homes, self.why = homes, why
        self._on_change()


@pytest.fixture
def finders(monkeypatch: pytest.MonkeyPatch) -> list[FakeFinder]:
    monkeypatch.setattr(FakeFinder, "made", [])
    monkeypatch.setattr(operator_app, "HomeFinder", FakeFinder)
    return FakeFinder.made


async def test_an_invitation_to_a_router_leads_to_the_home_that_is_chosen(
    catalogue: Catalogue, tmp_path: Path, joined: list[Any], finders: list[FakeFinder]
) -> None:
    app = WizardApp(catalogue.theme("calm"), tmp_path, "me", where=INVITED)
    async with app.run_test() as pilot:
        await pilot.pause()
        (finder,) = finders
        assert isinstance(app.screen, HomesScreen)
        hint, box = app.screen.query_one("#hint"), app.screen.query_one("#box", OptionList)
        assert "Nobody is training at home now." in str(hint.render())
        finder.find(why="Nothing listens there. Is the router running?")
        await pilot.pause()
        assert "Is the router running?" in str(hint.render())
        finder.find("p01", "p03")
        await pilot.pause()
        await pilot.press("down")
        finder.find("p01", "p02", "p03")
        await pilot.pause()
        assert box.highlighted == 2, "the mark stays on the home"
        await pilot.press("enter")
        await pilot.pause()
        assert isinstance(app.screen, PanelScreen)
        assert not finder.is_open
    assert joined == [(HomeVisit(INVITED, "p03"), "me", "operator")]
