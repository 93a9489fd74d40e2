"""Choice of a session, and its panel."""

import re
from pathlib import Path
from typing import Any

import pytest

from sar_tui.app.screens import home
from sar_tui.link import discovery as link_folder
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import NAME
from sar_tui.link.peer import PeerListener
from sar_tui.operator import session_picker
from sar_tui.operator.app import WizardApp
from sar_tui.operator.screen import PanelScreen
from sar_tui.operator.session_picker import HOW_TO_START, ChooseScreen, own_name
from sar_tui.plugins import Catalogue
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

    monkeypatch.setattr(session_picker, "connect", connect)
    return found


def wizard(catalogue: Catalogue, folder: Path, look: Any, *, waits: bool = False) -> WizardApp:
    return WizardApp(catalogue.theme("calm"), folder, "anna", waits=waits, look=look)


async def test_the_panel_of_the_chosen_session_opens(catalogue: Catalogue, tmp_path: Path, joined: list[Any]) -> None:
    app = wizard(catalogue, tmp_path, lambda: [ONE, OTHER])
    async with app.run_test() as pilot:
        await pilot.press("down", "enter")
        await pilot.pause()
        assert isinstance(app.screen, PanelScreen)
    assert joined == [(OTHER, "anna", "operator")]


async def test_without_a_session_it_says_how_to_start_one_and_joins_the_first(
    catalogue: Catalogue, tmp_path: Path, joined: list[Any]
) -> None:
    there: list[JoinableSession] = []
    app = wizard(catalogue, tmp_path, lambda: there, waits=True)
    async with app.run_test() as pilot:
        await pilot.pause()
        assert isinstance(app.screen, ChooseScreen)
        assert HOW_TO_START.split(":")[0] in str(app.screen.query_one("#hint").render())
        there.append(ONE)
        app.screen.look_again()
        await pilot.pause()
        assert isinstance(app.screen, PanelScreen)
    assert joined == [(ONE, "anna", "operator")]


async def test_leaving_the_choice_leaves_the_app(catalogue: Catalogue, tmp_path: Path) -> None:
    app = wizard(catalogue, tmp_path, lambda: [ONE, OTHER])
    async with app.run_test() as pilot:
        await pilot.press("escape")
    assert app.return_code == 0


async def test_a_failed_link_ends_the_app_with_a_message(
    catalogue: Catalogue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise LinkError("The link needs Python packages that are not installed here.")

    monkeypatch.setattr(session_picker, "connect", refuse)
    app = WizardApp(catalogue.theme("calm"), tmp_path, "anna", where=ONE)
    async with app.run_test() as pilot:
        await pilot.pause()
    assert (app.return_code, app.failure) == (1, "The link needs Python packages that are not installed here.")


async def test_home_offers_the_panel_while_a_session_can_be_joined(
    data: Path, catalogue: Catalogue, joined: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    there: list[JoinableSession] = []
    monkeypatch.setattr(link_folder, "live_sessions", lambda: there)
    async with open_app(data, catalogue) as driver:
        assert not driver.sees("Operator's panel")
        await driver.press("f3")
        there.append(ONE)
        assert isinstance(driver.app.screen, home.HomeScreen)
        driver.app.screen.look_for_sessions()
        await driver.settle()
        assert driver.sees("Operator's panel")
        await driver.press("f3")
        assert driver.screen_name == "PanelScreen"
        await driver.press("q", "q")
        assert driver.screen_name == "HomeScreen"
    assert [(where, role) for where, _, role in joined] == [(ONE, "operator")]


@pytest.mark.parametrize("login", ["anna", "Ünal.K", "-x-", "", "a" * 80])
def test_a_login_name_becomes_a_valid_name(login: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", login)
    for name in ("USER", "LNAME", "USERNAME"):
        monkeypatch.delenv(name, raising=False)
    assert re.fullmatch(NAME, own_name())


async def test_the_choice_survives_any_size_of_the_window(catalogue: Catalogue, tmp_path: Path) -> None:
    app = wizard(catalogue, tmp_path, lambda: [ONE, OTHER])
    async with app.run_test() as pilot:
        for size in [(60, 20), (30, 5), (5, 3), (1, 1), (20, 200), (200, 1), (80, 24)]:
            await pilot.resize_terminal(*size)
        assert isinstance(app.screen, ChooseScreen)
