"""A visit is due so many days after the last live session of the task, or after its programme was
saved.
"""

from datetime import UTC, date, datetime, timedelta
from sqlite3 import Connection

import pytest

from sar_tui.store import participants, programmes, training_days
from sar_tui.store.programmes import Programme
from tests.store.by_hand import insert, sql

SAVED = datetime(2026, 11, 10, 12, tzinfo=UTC)


@pytest.fixture
def database(database: Connection) -> Connection:
    """P01 comes every three days, P02 whenever they like; both were planned on 10 November."""
    for code, plan in (("P01", {"days_between_visits": 3}), ("P02", {})):
        participants.add(database, code)
        programmes.save(database, code, "keyboard", Programme(plan), after=0)
    sql(database, "UPDATE programmes SET created_at=?", SAVED.isoformat())
    return database


def trained(database: Connection, days_later: int, **other: str) -> None:
    """Store a session of P01."""
    began = (SAVED + timedelta(days=days_later)).isoformat()
    id = f"{days_later} {other}"
    insert(database, "sessions", id=id, started_at=began, status="completed", **other)
    insert(database, "seats", session=id)


def due(database: Connection, day: int) -> set[str]:
    return set(training_days.visits_due(database, date(2026, 11, day)))


def test_the_first_visit_is_due_after_the_programme_was_saved(database: Connection) -> None:
    assert (due(database, 12), due(database, 13), due(database, 30)) == (set(), {"P01"}, {"P01"})


def test_the_next_visit_is_due_after_the_last_session(database: Connection) -> None:
    trained(database, 4)
    trained(database, 1)
    assert (due(database, 16), due(database, 17)) == (set(), {"P01"})


def test_simulated_sessions_and_other_tasks_are_no_visits(database: Connection) -> None:
    trained(database, 2, mode="simulated")
    trained(database, 2, task="reaching")
    assert due(database, 13) == {"P01"}


def test_the_newest_programme_counts(database: Connection) -> None:
    programmes.save(database, "P01", "keyboard", Programme({}), after=1)
    assert due(database, 30) == set()
