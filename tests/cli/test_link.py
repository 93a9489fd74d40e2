"""Tests of ``sar-tui link``."""

import shlex
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


def invited(call: Call, more: str = "", name: str = "anna", role: str = "operator") -> Called:
    return call(f"link invite {role} --name {name} --host lab-pc.local {more}")


def test_invite_creates_one_private_file(call: Call, here: Path) -> None:
    called = invited(call, "--host 192.168.1.20:7000")
    called.shows("Anyone who has this file can join as anna", "--listen tls/0.0.0.0:7447")
    assert "PRIVATE" not in called.out
    path = here / "operator-anna.sar-link"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    invitation = read(path)
    assert invitation.guest == Guest("anna", "operator")
    assert invitation.where == (Endpoint("lab-pc.local", 7447), Endpoint("192.168.1.20", 7000))
    again = invited(call, f"--to {here}/second.sar-link")
    again.refused("link revoke anna")
    (here / "operator-ben.sar-link").write_text("mine")
    assert invited(call, name="ben").code == 2
    assert (here / "operator-ben.sar-link").read_text() == "mine"
    assert invited(call, f"--to {here}/no/folder.sar-link", name="ben").code == 2
    more = f"--to {here}/x.sar-link --days 3 --json"
    printed = invited(call, more, name="ben", role="observer").json
    assert sorted(printed) == ["endpoints", "expires", "file", "name", "role"]
    assert printed["endpoints"] == ["lab-pc.local:7447"]
    expires = read(here / "x.sar-link").expires.isoformat()
    assert expires.replace("+00:00", "Z") == printed["expires"]


def test_invitations_are_listed_and_revoked(call: Call, data: Path) -> None:
    call("link list").shows("Nobody is invited")
    assert call("link list --json").json == {"invitations": []}
    invited(call)
    invited(call, role="observer", name="eve")
    call("link revoke eve").shows("Revoked")
    assert [guest.name for guest in Authority.open(data).guests()] == ["anna"]
    call("link revoke eve").refused("no valid invitation for eve")
    columns = "anna operator good eve observer revoked lab-pc.local:7447"
    call("link list").shows(*columns.split())
    rows = call("link list --json").json["invitations"]
    assert [(row["name"], row["state"]) for row in rows] == [("anna", "good"), ("eve", "revoked")]
    assert len(rows[0]["fingerprint"]) == 64


def test_what_is_no_invitation_is_refused(
    call: Call, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "x.sar-link").write_text("hello")
    for words, said in (
        ("revoke anna", "Nobody has been invited"),
        ("invite king --name anna --host a", "Choose one of: operator, observer"),
        ("invite operator --name anna --host 'lab pc'", "not a network address"),
        ("invite operator --name anna --host lab-pc:0", "no valid port"),
        ("invite operator --name anna --host a --days 1000", "1 to 366 days"),
        ("check x.sar-link", "is not an invitation"),
    ):
        call("link", *shlex.split(words)).refused(said)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    invited(call).refused(errors.no_packages())
    assert [path.name for path in here.glob("*.sar-link")] == ["x.sar-link"]


def test_check_against_a_running_session(call: Call, data: Path) -> None:
    where = Endpoint("127.0.0.1", free_port())
    call("link invite operator --name anna --host", where)
    call("link check operator-anna.sar-link").shows("Nothing listens there", code=1)
    authority = Authority.open(data)
    files = authority.host_files([where])
    settings = host_settings(authority.link, listen=[where], files=files, guests=authority.guests())
    with (
        zenoh.open(config(settings)) as session,
        session.liveliness().declare_token(LinkKeys(authority.link).broadcast),
    ):
        call("link check operator-anna.sar-link").shows("✓")
        checked = call("link check operator-anna.sar-link --json")
    assert checked.code == 0
    assert checked.json["endpoints"] == [{"endpoint": str(where), "error": ""}]


def test_a_home_is_invited_and_keeps_its_invitation(call: Call, here: Path) -> None:
    invited(call, name="p01", role="home").shows(
        "sar-tui link home home-p01.sar-link", "sar-tui link router --listen tls/0.0.0.0:7447"
    )
    home = f"--data {here}/home"
    call(f"link home {home}").shows("No session of this data folder dials out")
    call(f"link home home-p01.sar-link {home}").shows(
        "lab-pc.local:7447", "Delete home-p01.sar-link"
    )
    printed = call(f"link home --json {home}").json
    assert (printed["dials_out"], printed["name"]) == (True, "p01")
    call(f"link home home-p01.sar-link --remove {home}").refused("not both")
    call(f"link home --remove {home}").shows("No session of this data folder dials out")
    assert call(f"link home --json {home}").json["dials_out"] is False


def test_an_invitation_of_the_wrong_kind_is_refused(call: Call) -> None:
    invited(call, "--router")
    invited(call, name="p01", role="home")
    call("link home operator-anna.sar-link").refused("invites an operator")
    call("wizard --link home-p01.sar-link").refused("is for a home")
    call("agent --link operator-anna.sar-link").refused("Name the home to visit")
    call("wizard p/1 --link operator-anna.sar-link").refused("cannot be a guest's name")
    invited(call, name="ben")
    call("wizard p01 --link operator-ben.sar-link").refused("leave out SESSION and --wait")


def test_a_router_needs_somebody_who_is_invited(call: Call) -> None:
    call("link router --listen tls/127.0.0.1").refused("Nobody has been invited")
