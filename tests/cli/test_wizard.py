"""``sar-tui wizard``: the session it joins, and what it refuses before the screen changes."""

import os
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from sar_tui.cli import wizard
from sar_tui.cli.errors import Refused
from sar_tui.cli.wizard import name_at_session, session_to_show
from sar_tui.link import discovery, invitation
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import NAME, Invitation
from sar_tui.link.zenoh_settings import Credentials
from tests.link.tls_fixtures import invite_guests
from tests.program import Call

HERE = Path("data")
ONE, OTHER = (
    JoinableSession("abc1", "keyboard", "l1", 1),
    JoinableSession("abd2", "reaching", "l2", 2),
)


def live(monkeypatch: pytest.MonkeyPatch, *sessions: JoinableSession) -> None:
    monkeypatch.setattr(discovery, "joinable_sessions", lambda data: list(sessions))
    monkeypatch.setattr(discovery, "other_folders", lambda data: [])


@pytest.mark.parametrize(
    ("arguments", "sessions", "said"),
    [
        ([], [], "`sar-tui run keyboard -p P01 --operator`"),
        (["x"], [ONE], "begins with x"),
        (["--link", "gone.sar-link"], [], "There is no file gone.sar-link."),
        (["abc1", "--link", "file"], [ONE], "leave out SESSION and --wait"),
        (["--name", "two words"], [ONE], "'two words' is not a valid name"),
        ([], [ONE], "needs a real terminal"),
        (["--wait"], [], "needs a real terminal"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    call: Call,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    sessions: list[JoinableSession],
    said: str,
) -> None:
    live(monkeypatch, *sessions)
    called = call("wizard", *arguments)
    assert (called.code, called.out) == (2, "")
    assert said in called.err


def test_the_only_session_is_joined_and_several_are_offered_on_the_screen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    live(monkeypatch, ONE)
    assert session_to_show(None, None, HERE, wait=False, observe=False) == ONE
    live(monkeypatch, ONE, OTHER)
    assert session_to_show(None, None, HERE, wait=False, observe=False) is None
    assert session_to_show("abd", None, HERE, wait=False, observe=False) == OTHER


def test_an_expired_invitation_is_refused(call: Call, data: Path, tmp_path: Path) -> None:
    path = tmp_path / "late.sar-link"
    invitation.write(invite_guests(data).late, path)
    called = call("wizard --link", path)
    assert (called.code, called.out) == (2, "")
    assert called.err.startswith(f"The invitation {path} expired on ")


def test_an_operators_invitation_cannot_be_used_to_observe(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(session: Any, link: Path, data: Path) -> Invitation:
        return Invitation(
            role="operator",
            name="anna",
            link="abcdef01",
            endpoints=("tls/127.0.0.1:7447",),
            expires=datetime.now(UTC),
            credentials=Credentials("", "", ""),
        )

    monkeypatch.setattr(wizard, "session_to_join", read)
    with pytest.raises(Refused, match="ask for an observer's invitation"):
        session_to_show(None, Path("anna.sar-link"), HERE, wait=False, observe=True)
    with pytest.raises(Refused, match="leave out --name"):
        name_at_session("ben", Path("anna.sar-link"), observe=False)


def test_observers_of_one_user_have_different_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", "ben" * 20)
    here = name_at_session(None, None, observe=True)
    monkeypatch.setattr(os, "getpid", lambda: 4_194_304)
    there = name_at_session(None, None, observe=True)
    assert here != there
    assert re.fullmatch(NAME, there)
    assert name_at_session(None, None, observe=False) == ("ben" * 20)[:32]


def test_a_session_of_another_data_folder_is_not_joined_but_named(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    elsewhere = JoinableSession(
        "abc1", "keyboard", "l1", 1, discovery.folder_name(tmp_path / "elsewhere"), ("P07",)
    )
    monkeypatch.setattr(discovery, "live_sessions", lambda: [elsewhere])
    for arguments in ([], ["abc1"]):
        called = call("wizard", *arguments)
        assert (called.code, called.out) == (2, "")
        assert called.err.endswith(f"to join it, add --data {tmp_path / 'elsewhere'}.\n")
    here = JoinableSession(
        "abd2", "reaching", "l2", 2, discovery.folder_name(tmp_path / "data"), ("P08",)
    )
    monkeypatch.setattr(discovery, "live_sessions", lambda: [elsewhere, here])
    assert session_to_show(None, None, tmp_path / "data", wait=True, observe=False) == here
    assert (
        session_to_show(None, None, tmp_path / "elsewhere", wait=True, observe=False) == elsewhere
    )
