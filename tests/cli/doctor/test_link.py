"""Given operators' ways in, open, shut or in disorder, when the doctor looks, then each is told in a line."""

import importlib.util
import shutil
import tempfile
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.link import browser, invitations, operator_here
from sar_tui.link.authority import FOLDER, Authority
from sar_tui.link.discovery import JoinableSession, announce
from sar_tui.link.settings import Guest, parse_endpoint

NOW = datetime(2026, 5, 1, tzinfo=UTC)


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for sockets whose name is short enough for one."""
    folder = Path(tempfile.mkdtemp(prefix="sar-"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    yield folder
    shutil.rmtree(folder)


def without(monkeypatch: pytest.MonkeyPatch, *packages: str) -> None:
    """Those are not installed."""
    really = importlib.util.find_spec

    def find(name: str) -> object:
        return None if name in packages else really(name)

    monkeypatch.setattr("importlib.util.find_spec", find)
    monkeypatch.setattr("sar_tui.cli.doctor.link.find_spec", find)


def test_where_a_socket_can_be_opened_it_is_told_and_nothing_is_left(runtime: Path) -> None:
    found = operator_here()
    assert (found.name, found.state, found.advice) == ("Operator here", "ok", "")
    assert found.found == f"through {runtime}/sar-tui, private to you; no session can be joined now"
    assert list((runtime / "sar-tui").iterdir()) == []


def test_sessions_that_can_be_joined_are_counted() -> None:
    with announce(JoinableSession(session="a1", task="keyboard", link="a1", pid=1)):
        assert operator_here().found.endswith("; 1 session can be joined now")


def test_a_folder_that_is_open_to_others_needs_care(runtime: Path) -> None:
    (runtime / "sar-tui").mkdir(mode=0o700)
    (runtime / "sar-tui").chmod(0o755)
    found = operator_here()
    assert found.state == "care"
    assert "is accessible to others" in found.found


def test_a_folder_in_which_no_socket_can_be_opened_needs_care(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Refused:
        def __init__(self, family: int) -> None: ...

        def __enter__(self) -> "Refused":
            return self

        def __exit__(self, *_: object) -> None: ...

        def bind(self, path: str) -> None:
            raise OSError(95, "Operation not supported")

    monkeypatch.setattr("socket.socket", Refused)
    found = operator_here()
    assert (found.state, found.found) == (
        "care",
        f"no socket can be opened in {runtime}/sar-tui: Operation not supported",
    )
    assert "XDG_RUNTIME_DIR" in found.advice


def test_what_is_not_installed_is_no_fault_and_its_cure_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "zenoh", "aiohttp")
    assert operator_here() == Finding(
        "Operator here",
        "ok",
        "not installed. Only sessions with an operator need it.",
        "To install it: pip install 'sar-tui[link]'",
    )
    assert browser() == Finding(
        "Browser", "ok", "not installed. Only `sar-tui serve` needs it.", "To install it: pip install 'sar-tui[serve]'"
    )


def test_a_browser_is_not_enough_without_the_link(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "zenoh")
    assert browser() == Finding(
        "Browser",
        "ok",
        "not installed. `sar-tui serve` needs the link.",
        "To install it: pip install 'sar-tui[link]'",
    )


def test_a_browser_can_be_served() -> None:
    assert (browser().state, browser().advice) == ("ok", "")


def test_without_an_invitation_nobody_can_join(tmp_path: Path) -> None:
    assert invitations(tmp_path) == Finding(
        "Invitations", "ok", "nobody is invited, so nobody can join over the network"
    )
    assert not (tmp_path / FOLDER).exists()


@pytest.mark.parametrize(
    ("days", "state", "says"),
    [
        (3, "ok", "2 valid: operator.anna, observer.eva"),
        (24, "care", "2 valid: operator.anna, observer.eva; expiring soon: anna on 2026-05-31"),
        (40, "ok", "1 valid: observer.eva"),
        (70, "ok", "none is valid now, so nobody can join over the network"),
    ],
)
def test_invitations_are_told_by_how_long_they_are_good(tmp_path: Path, days: int, state: str, says: str) -> None:
    authority = Authority.open_or_create(tmp_path)
    authority.invite(Guest("anna", "operator"), [parse_endpoint("lab")], 30, NOW)
    authority.invite(Guest("eva", "observer"), [parse_endpoint("lab")], 60, NOW)
    found = invitations(tmp_path, NOW + timedelta(days=days))
    assert (found.state, found.found) == (state, says)


def test_who_was_revoked_is_not_among_them(tmp_path: Path) -> None:
    authority = Authority.open_or_create(tmp_path)
    authority.invite(Guest("anna", "operator"), [parse_endpoint("lab")], 30, NOW)
    authority.revoke("anna", NOW)
    assert invitations(tmp_path, NOW).found.startswith("none is valid")


def test_keys_that_others_can_look_at_need_care(tmp_path: Path) -> None:
    Authority.open_or_create(tmp_path)
    (tmp_path / FOLDER).chmod(0o755)
    found = invitations(tmp_path, NOW)
    assert (found.state, f"chmod 700 {tmp_path / FOLDER}" in found.advice) == ("care", True)


def test_a_damaged_register_is_told_with_what_it_means(tmp_path: Path) -> None:
    Authority.open_or_create(tmp_path)
    (tmp_path / FOLDER / "invitations.json").write_text("{")
    found = invitations(tmp_path, NOW)
    assert (found.state, "is damaged" in found.found) == ("bad", True)
    assert "no session can listen" in found.advice
