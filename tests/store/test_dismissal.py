"""A dismissed session is listed and kept, and cannot be resumed until it is taken back."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.runs.run import find_resumable
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.dismissal import dismiss, take_back
from sar_tui.store.locks import Held, hold
from tests.program import Call
from tests.store.test_sessions import enter


def status(database: sqlite3.Connection, session: str) -> str | None:
    return sessions.stored_status(database, session)


@pytest.mark.parametrize("stored", ["running", "interrupted"])
def test_an_interrupted_session_is_dismissed_and_taken_back(
    stored: str, database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    database.execute("UPDATE sessions SET status=?", (stored,))
    dismiss(database, data, session)
    assert [row["status"] for row in sessions.listing(database, data)] == ["dismissed"]
    with pytest.raises(StoreError, match="is dismissed; only a live one that was interrupted can be resumed"):
        find_resumable(database, data, session)
    take_back(database, session)
    assert find_resumable(database, data, session)["id"] == session


@pytest.mark.parametrize("stored", ["completed", "aborted"])
def test_a_session_that_has_ended_stays_as_it_is(stored: str, database: sqlite3.Connection, data: Path) -> None:
    session = enter(database)
    database.execute("UPDATE sessions SET status=?", (stored,))
    dismiss(database, data, session)
    take_back(database, session)
    assert status(database, session) == stored


def test_a_session_that_is_open_in_a_program_is_not_dismissed(database: sqlite3.Connection, data: Path) -> None:
    session = enter(database)
    lock = hold(data, "session", session)
    with pytest.raises(Held):
        dismiss(database, data, session)
    lock.release()
    assert status(database, session) == "running"


def test_a_dismissed_session_is_listed_by_the_program_and_not_resumed(call: Call, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "data")) as database:
        session = enter(database)
        dismiss(database, tmp_path / "data", session)
    assert "dismissed" in call("sessions").out
    assert call("sessions", "--json").json["sessions"][0]["id"] == session
    assert call("resume").code == 2
