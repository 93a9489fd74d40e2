"""Tests of ``sar-tui link``."""

import stat
from pathlib import Path

import pytest
import zenoh

from sar_tui.link import errors
from sar_tui.link.authority import Authority
from sar_tui.link.invitation import read
from sar_tui.link.zenoh_settings import Endpoint, Guest, LinkKeys, config, host_settings
from tests.link.tls_fixtures import free_port
from tests.program import Call, Called


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def invited(
    call: Call,
    *more: object,
    name: str = "anna",
    role: str = "operator",
    host: str = "lab-pc.local",
) -> Called:
    return call("link invite", role, "--name", name, "--host", host, *more)


def test_invite_creates_one_private_file(call: Call, here: Path) -> None:
    called = invited(call, "--host", "192.168.1.20:7000")
    assert called.code == 0
    path = here / "operator-anna.sar-link"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    invitation = read(path)
    assert invitation.guest == Guest("anna", "operator")
    assert invitation.where == (Endpoint("lab-pc.local", 7447), Endpoint("192.168.1.20", 7000))
    assert "Anyone who has this file can join as anna" in called.out
    assert "--listen tls/0.0.0.0:7447" in called.out
    assert "PRIVATE" not in called.out


def test_json_of_an_invitation_contains_no_key(call: Call, here: Path) -> None:
    called = invited(call, "--to", here / "x.sar-link", "--days", 3, "--json", role="observer")
    assert sorted(called.json) == ["endpoints", "expires", "file", "name", "role"]
    assert called.json["endpoints"] == ["lab-pc.local:7447"]
    assert (
        read(here / "x.sar-link").expires.isoformat().replace("+00:00", "Z")
        == called.json["expires"]
    )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"role": "king"}, "Choose one of: operator, observer"),
        ({"name": "anna b"}, "cannot be a guest's name"),
        ({"host": "lab pc"}, "not a network address"),
        ({"host": "lab-pc:0"}, "no valid port"),
    ],
)
def test_invalid_invitation_is_refused(
    call: Call, here: Path, wrong: dict[str, str], message: str
) -> None:
    called = invited(call, **wrong)
    assert called.code == 2
    assert message in called.err
    assert not list(here.glob("*.sar-link"))


def test_an_invitation_for_too_many_days_is_refused(call: Call) -> None:
    called = invited(call, "--days", 1000)
    assert (called.code, "1 to 366 days" in called.err) == (2, True)


def test_existing_file_is_not_overwritten(call: Call, here: Path) -> None:
    (here / "operator-anna.sar-link").write_text("mine")
    assert invited(call).code == 2
    assert (here / "operator-anna.sar-link").read_text() == "mine"
    assert invited(call, "--to", here / "no" / "folder.sar-link").code == 2
    assert invited(call, "--to", here / "other.sar-link").code == 0


def test_name_is_unique(call: Call, here: Path) -> None:
    invited(call)
    called = invited(call, "--to", here / "second.sar-link")
    assert called.code == 2
    assert "link revoke anna" in called.err


def test_list(call: Call) -> None:
    assert "Nobody is invited" in call("link list").out
    assert call("link list --json").json == {"invitations": []}
    invited(call)
    invited(call, role="observer", name="eve")
    call("link revoke eve")
    listed = call("link list").out
    for part in ("anna", "operator", "good", "eve", "observer", "revoked", "lab-pc.local:7447"):
        assert part in listed
    rows = call("link list --json").json["invitations"]
    assert [(row["name"], row["state"]) for row in rows] == [("anna", "good"), ("eve", "revoked")]
    assert len(rows[0]["fingerprint"]) == 64


def test_revoke(call: Call, tmp_path: Path) -> None:
    invited(call)
    called = call("link revoke anna")
    assert called.code == 0
    assert "Revoked" in called.out
    assert Authority.open(tmp_path / "data").guests() == ()
    again = call("link revoke anna")
    assert (again.code, "no valid invitation for anna" in again.err) == (2, True)


def test_revoke_without_invitations_is_refused(call: Call) -> None:
    called = call("link revoke anna")
    assert (called.code, "Nobody has been invited" in called.err) == (2, True)


def test_check_against_a_running_session(call: Call, here: Path) -> None:
    where = Endpoint("127.0.0.1", free_port())
    invited(call, host=str(where))
    alone = call("link check operator-anna.sar-link")
    assert alone.code == 1
    assert "Nothing listens there" in alone.out
    authority = Authority.open(here / "data")
    files = authority.host_files([where])
    settings = host_settings(authority.link, listen=[where], files=files, guests=authority.guests())
    with (
        zenoh.open(config(settings)) as session,
        session.liveliness().declare_token(LinkKeys(authority.link).broadcast),
    ):
        assert "✓" in call("link check operator-anna.sar-link").out
        checked = call("link check operator-anna.sar-link --json")
    assert checked.code == 0
    assert checked.json["endpoints"] == [{"endpoint": str(where), "error": ""}]


def test_check_of_another_file_is_refused(call: Call, here: Path) -> None:
    (here / "x.sar-link").write_text("hello")
    called = call("link check x.sar-link")
    assert (called.code, "is not an invitation" in called.err) == (2, True)


def test_missing_packages_are_reported(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    called = invited(call)
    assert called.code == 2
    assert called.err.strip() == errors.no_packages()
