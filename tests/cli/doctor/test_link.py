"""Doctor's checks of the socket folder, invitations and browser."""

import importlib.util
import shutil
import tempfile
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.link import browser, invitations, operator_here
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.link.authority import FOLDER, Authority
from sar_tui.link.discovery import JoinableSession, announce
from sar_tui.link.zenoh_settings import Guest, parse_endpoint

NOW = datetime(2026, 5, 1, tzinfo=UTC)


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Runtime folder with a short path."""
    folder = Path(tempfile.mkdtemp(prefix="sar-"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    yield folder
    shutil.rmtree(folder)


def without(monkeypatch: pytest.MonkeyPatch, *packages: str) -> None:
    """Pretend that packages are not installed."""
    really = importlib.util.find_spec

    def find(name: str) -> object:
        return None if name in packages else really(name)

    monkeypatch.setattr("importlib.util.find_spec", find)
    monkeypatch.setattr("sar_tui.cli.doctor.link.find_spec", find)


def test_usable_socket_folder(runtime: Path) -> None:
    found = operator_here()
    assert (found.name, found.state, found.advice) == ("Operator here", "ok", "")
    assert found.found == f"through {runtime}/sar-tui, private to you; no session can be joined now"
    assert list((runtime / "sar-tui").iterdir()) == []


def test_joinable_sessions_are_counted() -> None:
    with announce(JoinableSession(session="a1", task="keyboard", link="a1", pid=1)):
        assert operator_here().found.endswith("; 1 session can be joined now")


def test_folder_accessible_to_others(runtime: Path) -> None:
    (runtime / "sar-tui").mkdir(mode=0o700)
    (runtime / "sar-tui").chmod(0o755)
    found = operator_here()
    assert found.state == "care"
    assert "is accessible to others" in found.found


def test_folder_without_sockets(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_missing_packages_are_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "zenoh", "aiohttp")
    assert operator_here() == Finding(
        "Operator here",
        "ok",
        "not installed. Only sessions with an operator need it.",
        f"To install it: {pip_install_extra('link')}",
    )
    assert browser() == Finding(
        "Browser",
        "ok",
        "not installed. Only `sar-tui serve` needs it.",
        f"To install it: {pip_install_extra('serve')}",
    )


def test_browser_needs_the_link(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "zenoh")
    assert browser() == Finding(
        "Browser",
        "ok",
        "not installed. `sar-tui serve` needs the link.",
        f"To install it: {pip_install_extra('link')}",
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
def test_expiry_of_invitations(tmp_path: Path, days: int, state: str, says: str) -> None:
    authority = Authority.open_or_create(tmp_path)
    authority.invite(Guest("anna", "operator"), [parse_endpoint("lab")], 30, NOW)
    authority.invite(Guest("eva", "observer"), [parse_endpoint("lab")], 60, NOW)
    found = invitations(tmp_path, NOW + timedelta(days=days))
    assert (found.state, found.found) == (state, says)


def test_revoked_invitation_is_not_listed(tmp_path: Path) -> None:
    authority = Authority.open_or_create(tmp_path)
    authority.invite(Guest("anna", "operator"), [parse_endpoint("lab")], 30, NOW)
    authority.revoke("anna", NOW)
    assert invitations(tmp_path, NOW).found.startswith("none is valid")


def test_keys_readable_by_others(tmp_path: Path) -> None:
    Authority.open_or_create(tmp_path)
    (tmp_path / FOLDER).chmod(0o755)
    found = invitations(tmp_path, NOW)
    assert (found.state, f"chmod 700 {tmp_path / FOLDER}" in found.advice) == ("care", True)


def test_damaged_register(tmp_path: Path) -> None:
    Authority.open_or_create(tmp_path)
    (tmp_path / FOLDER / "invitations.json").write_text("{")
    found = invitations(tmp_path, NOW)
    assert (found.state, "is damaged" in found.found) == ("bad", True)
    assert "no session can listen" in found.advice
