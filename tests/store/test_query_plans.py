"""Lists of sessions and views of one look at their own rows only, however many other sessions there
are.
"""

import re
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.reports import logged_messages
from sar_tui.reports.output_summary import output_summaries
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import imu, participants, results, sessions, wellbeing
from sar_tui.store.database import connect

LARGE = {
    "messages",
    "events",
    "trials",
    "attempts",
    "actions",
    "imu_chunks",
    "notes",
    "records",
}
"""Tables that grow with each trial."""

Look = Callable[[sqlite3.Connection, Path, str], object]


def show(database: sqlite3.Connection, folder: Path, session: str) -> None:
    sessions.find(database, folder, session[:6])
    sessions.operators(database, session)
    for table in ("attempts", "trials", "actions", "runs", "imu_streams", "seats"):
        sessions.rows(database, table, session)  # type: ignore[arg-type]
    output_summaries(database, session)


def look_at_home(database: sqlite3.Connection, folder: Path) -> None:
    participants.newest_first(database, folder)
    participants.last_task(database, "SIM")
    shown = [row["id"] for row in sessions.listing(database, folder, limit=30)]
    sessions.listing(database, folder, participant="SIM", limit=30)
    results.attempts_of(database, shown)
    results.newest_of(database, "SIM", "keyboard", 50)
    wellbeing.by_session(database, shown)
    wellbeing.newest_ratings(database, "SIM")


LOOKS: dict[str, Look] = {
    "home": lambda database, folder, _: look_at_home(database, folder),
    "sessions": lambda database, folder, _: (
        sessions.operators(database),
        sessions.listing(database, folder),
    ),
    "sessions of one": lambda database, folder, _: sessions.listing(
        database, folder, participant="SIM"
    ),
    "progress": lambda database, *_: list(results.sessions_of(database, "SIM")),
    "show": show,
    "show last": lambda database, folder, _: sessions.find(database, folder, "last"),
    "resume last": lambda database, folder, _: sessions.latest_interrupted(database, folder),
    "history": lambda database, _, session: list(sessions.history(database, session)),
    "report": lambda database, _, session: logged_messages.read(database, session),
    "resume sensors": lambda database, _, session: imu.resume_streams(database, session, 2),
}


@pytest.mark.parametrize("name", LOOKS)
def test_no_large_table_is_scanned(
    name: str, database: sqlite3.Connection, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    plan = make_plan(
        catalogue,
        keyboard,
        ["SIM"],
        {"attempts": 1, "prompts_per_attempt": 2},
        seed=3,
        mode="simulated",
    )
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    asked: list[str] = []
    database.set_trace_callback(asked.append)
    LOOKS[name](database, data, session)
    database.set_trace_callback(None)
    assert asked
    assert [(query, scanned) for query in asked if (scanned := scans(database, query))] == []


def scans(database: sqlite3.Connection, query: str) -> set[str]:
    """Return the large tables that a query reads from beginning to end."""
    steps = [step for *_, step in database.execute(f"EXPLAIN QUERY PLAN {query}")]
    read = [
        found[1]
        for step in steps
        if (found := re.fullmatch(r"SCAN (\w+)(?! USING INDEX idx_).*", step))
    ]
    tables = {
        name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type='table'")
    }
    return LARGE & tables & set(read)


def steps(database: sqlite3.Connection, look: Callable[[], object]) -> list[str]:
    """Return the steps of what is asked of the database."""
    asked: list[str] = []
    database.set_trace_callback(asked.append)
    look()
    database.set_trace_callback(None)
    return [step for query in asked for *_, step in database.execute(f"EXPLAIN QUERY PLAN {query}")]


@pytest.mark.parametrize("session", [None, "5e55100001"])
def test_presence_is_looked_up_in_its_index(
    database: sqlite3.Connection, session: str | None
) -> None:
    planned = steps(database, lambda: sessions.operators(database, session))
    assert [step for step in planned if "idx_messages_presence" in step]


def test_the_newest_sessions_are_found_without_sorting_all(
    database: sqlite3.Connection, data: Path
) -> None:
    planned = steps(database, lambda: sessions.listing(database, data, limit=30))
    assert planned[0] == "SCAN sessions"
    assert [step for step in planned if "TEMP B-TREE" in step] == []


def test_the_newest_sessions_of_a_participant_are_found_without_sorting_all(
    database: sqlite3.Connection, data: Path
) -> None:
    planned = steps(database, lambda: sessions.listing(database, data, participant="P01", limit=30))
    assert [step for step in planned if step.startswith("SCAN") or "TEMP B-TREE" in step] == []


def test_the_view_of_messages_looks_at_a_sessions_own(data: Path) -> None:
    database = connect(data)
    query = (
        "SELECT message FROM events WHERE session='5e55100001' AND topic='input/key' ORDER BY seq"
    )
    assert scans(database, query) == set()
    database.close()
