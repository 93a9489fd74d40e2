"""``sar-tui wizard``: the session it joins, and what it refuses before the screen changes."""

import os
import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from sar_tui.cli.errors import Refused
from sar_tui.cli.wizard import name_at_session, session_to_join, session_to_show
from sar_tui.link import discovery, invitation
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import NAME
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
    ("command", "sessions", "said"),
    [
        ("wizard", [], "`sar-tui run keyboard -p P01 --operator`"),
        ("agent", [], "`sar-tui run keyboard -p P01 --operator`"),
        ("wizard x", [ONE], "begins with x"),
        ("wizard --link gone.sar-link", [], "There is no file gone.sar-link."),
        ("wizard --wait --link file", [ONE], "leave out SESSION and --wait"),
        ("wizard --name two,words", [ONE], "'two,words' is not a valid name"),
        ("wizard", [ONE], "needs a real terminal"),
        ("agent", [ONE], "needs a real terminal"),
        ("wizard --wait", [], "needs a real terminal"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    call: Call,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    sessions: list[JoinableSession],
    said: str,
) -> None:
    live(monkeypatch, *sessions)
    call(command).refused(said)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("wizard --protocol gone.toml", "gone.toml"),
        ("wizard --protocol {bad}", "bad.toml, line 2: version must be a whole number"),
        ("wizard --observe --protocol {good}", "an observer does nothing by it"),
        ("wizard --protocol {good}", "needs a real terminal"),
        ("serve operator --protocol {bad}", "bad.toml, line 2: version must be a whole number"),
        ("serve observer --protocol {good}", "Only an operator works by a protocol"),
        ("--protocol {bad}", "bad.toml, line 2: version must be a whole number"),
        ("--protocol {good}", "needs a real terminal"),
        ("--protocol {good} sessions", "--protocol goes after the command"),
        ("--patient P01 --protocol {good}", "A participant alone has no operator's panel"),
        ("wizard practise", "Practice needs a recorded session and a protocol"),
        ("wizard practise last", "Practice needs a recorded session and a protocol"),
        ("wizard practise last --wait --protocol {good}", "Practice joins no session"),
        ("wizard practise last --protocol {good} --to {good}", "is not overwritten"),
        ("wizard practise last --protocol {good}", "needs a real terminal"),
        ("wizard abc1 last", "are for practice"),
        ("wizard --speed 2", "are for practice"),
    ],
)
def test_a_protocol_is_read_before_the_screen_changes(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, command: str, said: str
) -> None:
    live(monkeypatch, ONE)
    good, bad = tmp_path / "good.toml", tmp_path / "bad.toml"
    good.write_text('name = "a"\nversion = 1\n[[steps]]\nat = "start"\ndo = "say greeting"\n')
    bad.write_text('name = "a"\nversion = 0\n[[steps]]\nat = "start"\ndo = "say nothing"\n')
    call(command.format(good=good, bad=bad)).refused(said)


def test_the_only_session_is_joined_and_several_are_offered_on_the_screen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def show(session: str | None = None) -> object:
        return session_to_show(session, None, HERE, wait=False, observe=False)

    live(monkeypatch, ONE)
    assert show() == session_to_join(None, None, HERE) == ONE
    live(monkeypatch, ONE, OTHER)
    assert show() is None
    assert show("abd") == session_to_join("abd", None, HERE) == OTHER
    for session, said in ((None, "Several"), ("ab", "Several"), ("x", "begins with x")):
        with pytest.raises(Refused, match=said) as refused:
            session_to_join(session, None, HERE)
        assert "abc1 (keyboard); abd2 (reaching)" in str(refused.value)


def test_an_expired_invitation_and_one_for_another_role_are_refused(
    call: Call, data: Path, tmp_path: Path
) -> None:
    link, late = tmp_path / "anna.sar-link", tmp_path / "late.sar-link"
    guests = invite_guests(data)
    invitation.write(guests.anna, link)
    invitation.write(guests.late, late)
    call("wizard --link", late).refused(f"The invitation {late} expired on ")
    call("serve observer --port 0 --link", link).refused("ask for an observer's invitation")
    with pytest.raises(Refused, match="ask for an observer's invitation"):
        session_to_show(None, link, HERE, wait=False, observe=True)
    with pytest.raises(Refused, match="leave out --name"):
        name_at_session("ben", link, observe=False)


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
    data, other = tmp_path / "data", tmp_path / "elsewhere"
    elsewhere = replace(ONE, data=discovery.folder_name(other))
    monkeypatch.setattr(discovery, "live_sessions", lambda: [elsewhere])
    for command in ("wizard", "wizard abc1"):
        call(command).refused(f"to join it, add --data {other}.")
    here = replace(OTHER, data=discovery.folder_name(data))
    monkeypatch.setattr(discovery, "live_sessions", lambda: [elsewhere, here])
    for folder, found in ((data, here), (other, elsewhere)):
        assert session_to_show(None, None, folder, wait=True, observe=False) == found
