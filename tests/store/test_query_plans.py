"""Lists of sessions and views of one look at their own rows only, however many other sessions there
are.
"""

import re
from collections.abc import Callable
from datetime import date
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.reports import logged_messages
from sar_tui.reports.output_summary import output_summaries
from sar_tui.store import courses, imu, participants, results, sessions, wellbeing
from tests.played import simulated
from tests.store.by_hand import sql

LARGE = {"messages", "events", "trials", "attempts", "actions", "imu_chunks", "notes", "records"}
"""Tables that grow with each trial."""

Look = Callable[[Connection, Path, str], object]


def show(database: Connection, folder: Path, session: str) -> None:
    sessions.find(database, folder, session[:6])
    sessions.operators(database, session)
    for table in ("attempts", "trials", "actions", "runs", "imu_streams", "seats"):
        sessions.rows(database, table, session)  # type: ignore[arg-type]
    output_summaries(database, session)


def look_at_home(database: Connection, folder: Path) -> None:
    courses.read_people(database, folder, date.today())
    participants.last_task(database, "SIM")
    shown = [row["id"] for row in sessions.listing(database, folder, limit=30)]
    sessions.listing(database, folder, participant="SIM", limit=30)
    results.attempts_of(database, shown)
    results.newest_of(database, "SIM", "keyboard", 50)
    wellbeing.by_session(database, shown)
    wellbeing.newest_ratings(database, "SIM")


LOOKS: dict[str, Look] = {
    "home": lambda db, folder, _: look_at_home(db, folder),
    "sessions": lambda db, folder, _: (sessions.operators(db), sessions.listing(db, folder)),
    "sessions of one": lambda db, folder, _: sessions.listing(db, folder, participant="SIM"),
    "progress": lambda db, *_: list(results.sessions_of(db, "SIM")),
    "show": show,
    "show last": lambda db, folder, _: sessions.find(db, folder, "last"),
    "resume last": lambda db, folder, _: sessions.latest_interrupted(db, folder),
    "history": lambda db, _, session: list(sessions.history(db, session)),
    "view of messages": lambda db, _, session: sql(
        db,
        f"SELECT message FROM events WHERE session='{session}' AND topic='input/key' ORDER BY seq",
    ),
    "report": lambda db, _, session: logged_messages.read(db, session),
    "resume sensors": lambda db, _, session: imu.resume_streams(db, session, 2),
}


@pytest.mark.parametrize("name", LOOKS)
def test_no_large_table_is_scanned(name: str, database: Connection, data: Path) -> None:
    session = simulated(data, "keyboard", "SIM", attempts=1, prompts_per_attempt=2)
    queries = asked(database, lambda: LOOKS[name](database, data, session))
    assert queries
    assert [(query, scanned) for query in queries if (scanned := scans(database, query))] == []


def scans(database: Connection, query: str) -> set[str]:
    """Return the large tables that a query reads from beginning to end."""
    scan = re.compile(r"SCAN (\w+)(?! USING INDEX idx_).*")
    read = {found[1] for step in steps(database, query) if (found := scan.fullmatch(step))}
    tables = sql(database, "SELECT name FROM sqlite_master WHERE type='table'")
    return LARGE & {name for (name,) in tables} & read


def asked(database: Connection, look: Callable[[], object]) -> list[str]:
    """Return the queries of what is looked at."""
    queries: list[str] = []
    database.set_trace_callback(queries.append)
    look()
    database.set_trace_callback(None)
    return queries


def planned(database: Connection, look: Callable[[], object]) -> list[str]:
    return [step for query in asked(database, look) for step in steps(database, query)]


def steps(database: Connection, query: str) -> list[str]:
    return [step for *_, step in sql(database, f"EXPLAIN QUERY PLAN {query}")]


@pytest.mark.parametrize("session", [None, "5e55100001"])
def test_presence_is_looked_up_in_its_index(database: Connection, session: str | None) -> None:
    plan = planned(database, lambda: sessions.operators(database, session))
    assert [step for step in plan if "idx_messages_presence" in step]
