"""A visit is due so many days after the last live session of the task, or after its programme was
saved.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.store import participants, programmes, training_days
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme

SAVED = datetime(2026, 11, 10, 12, tzinfo=UTC)


@pytest.fixture
def database(data: Path) -> Iterator[sqlite3.Connection]:
    """P01 comes every three days, P02 whenever they like; both were planned on 10 November."""
    with closing(connect(data)) as opened:
        for code, plan in (("P01", {"days_between_visits": 3}), ("P02", {})):
            participants.add(opened, code)
            programmes.save(opened, code, "keyboard", Programme(plan), after=0)
        opened.execute("UPDATE programmes SET created_at=?", (SAVED.isoformat(),))
        yield opened


def trained(
    database: sqlite3.Connection, days_later: int, mode: str = "live", task: str = "keyboard"
) -> None:
    """Store a session of P01."""
    began = SAVED + timedelta(days=days_later)
    row = (f"{mode}{task}{days_later}", task, began.isoformat(), mode)
    database.execute(
        "INSERT INTO sessions (id, task, started_at, mode, status) VALUES (?,?,?,?,'completed')",
        row,
    )
    database.execute("INSERT INTO seats VALUES (?, 'A', 'P01')", (row[0],))


def due(database: sqlite3.Connection, day: int) -> set[str]:
    return training_days.visits_due(database, date(2026, 11, day))


def test_the_first_visit_is_due_after_the_programme_was_saved(database: sqlite3.Connection) -> None:
    assert (due(database, 12), due(database, 13), due(database, 30)) == (set(), {"P01"}, {"P01"})


def test_the_next_visit_is_due_after_the_last_session(database: sqlite3.Connection) -> None:
    trained(database, 4)
    trained(database, 1)
    assert (due(database, 16), due(database, 17)) == (set(), {"P01"})


def test_simulated_sessions_and_other_tasks_are_no_visits(database: sqlite3.Connection) -> None:
    trained(database, 2, "simulated")
    trained(database, 2, task="reaching")
    assert due(database, 13) == {"P01"}


def test_the_newest_programme_counts(database: sqlite3.Connection) -> None:
    programmes.save(database, "P01", "keyboard", Programme({}), after=1)
    assert due(database, 30) == set()
