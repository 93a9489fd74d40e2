"""Tests of `sar-tui agent`: choice of the session."""

from pathlib import Path

import pytest

from sar_tui.cli.errors import Refused
from sar_tui.cli.wizard import session_to_join
from sar_tui.link import discovery
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from tests.program import Call

HERE = Path("data")
ONE, OTHER = (
    JoinableSession("abc1", "keyboard", "l1", 1),
    JoinableSession("abd2", "reaching", "l2", 2),
)


def live(monkeypatch: pytest.MonkeyPatch, *sessions: JoinableSession) -> None:
    monkeypatch.setattr(discovery, "joinable_sessions", lambda data: list(sessions))
    monkeypatch.setattr(discovery, "other_folders", lambda data: [])


def test_without_session_it_explains_how_to_start_one(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    live(monkeypatch)
    called = call("agent")
    assert (called.code, called.out) == (2, "")
    assert "`sar-tui run keyboard -p P01 --operator`" in called.err


def test_terminal_is_required(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    live(monkeypatch, ONE)
    called = call("agent")
    assert (called.code, called.out) == (2, "")
    assert "needs a real terminal" in called.err


def test_choice_of_the_session(monkeypatch: pytest.MonkeyPatch) -> None:
    live(monkeypatch, ONE)
    assert session_to_join(None, None, HERE) == ONE
    live(monkeypatch, ONE, OTHER)
    assert session_to_join("abd", None, HERE) == OTHER


@pytest.mark.parametrize(
    ("session", "said"), [(None, "Several"), ("ab", "Several"), ("x", "begins with x")]
)
def test_ambiguous_choice_lists_the_sessions(
    session: str | None, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    live(monkeypatch, ONE, OTHER)
    with pytest.raises(Refused, match=said) as refused:
        session_to_join(session, None, HERE)
    assert "abc1 (keyboard); abd2 (reaching)" in str(refused.value)


def test_invalid_invitation_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("Dear diary")
    with pytest.raises(LinkError, match="is not an invitation"):
        session_to_join(None, tmp_path / "file", tmp_path)
