"""Adverse events belong to the session under way when they began."""

import sqlite3
from datetime import UTC, datetime

import pytest

from sar_tui.store.adverse_events import session_at
from tests.store.test_wellbeing import new_session


@pytest.mark.parametrize(
    ("onset", "session"),
    [
        ("2026-03-01 10:00", "abc"),
        ("2026-03-01 10:20", "abc"),
        ("2026-03-01 10:21", None),
        ("2026-03-01 09:59", None),
        ("2026-03-01", None),
    ],
)
def test_an_event_with_a_time_belongs_to_the_session_under_way(
    database: sqlite3.Connection, onset: str, session: str | None
) -> None:
    new_session(database, "abc")
    began, ended = (
        datetime.fromisoformat(f"2026-03-01 {at}").astimezone() for at in ("10:00:30", "10:20:30")
    )
    database.execute("UPDATE sessions SET started_at=?, ended_at=?", (utc(began), utc(ended)))
    assert session_at(database, "P01", onset) == session
    assert session_at(database, "P02", onset) is None


def utc(at: datetime) -> str:
    return at.astimezone(UTC).isoformat()
