"""Databases of all releases: each is brought up to date, its sessions replay, and the interrupted
one is resumed and completed.
"""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui import __version__
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import SECOND
from sar_tui.runs.run import resume
from sar_tui.store import sessions
from sar_tui.store.database import FILE, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.tables import TABLES
from tests.played import catalogue, play, somebody
from tests.program import Call
from tests.store.make_golden import RELEASES, unpack
from tests.store.test_database import schema_of

AGAIN = "run `python -m tests.store.make_golden` while this release is not out"


@pytest.fixture(params=RELEASES)
def release(request: pytest.FixtureRequest, data: Path) -> str:
    """A release whose golden database is in the data folder."""
    unpack(request.param, data)
    return str(request.param)


def rows(data: Path) -> dict[str, tuple[list[str], list[tuple[object, ...]]]]:
    """Return the columns and rows of each table of a database as it is."""
    found = {}
    with closing(sqlite3.connect(data / FILE)) as database:
        for (table,) in database.execute(
            "SELECT name FROM sqlite_master WHERE type='table' AND name NOT GLOB 'sqlite_*'"
        ).fetchall():
            columns = [name for _, name, *_ in database.execute(f"PRAGMA table_info({table})")]
            found[table] = columns, database.execute(f"SELECT * FROM {table}").fetchall()
    return found


def test_this_release_has_a_golden_database_with_rows_in_every_table(data: Path) -> None:
    assert __version__ in RELEASES, AGAIN
    stored = rows(unpack(__version__, data))
    assert {name: list(table.names) for name, table in TABLES.items()} == {
        name: columns for name, (columns, _) in stored.items()
    }, AGAIN
    assert [name for name, (_, there) in stored.items() if not there] == []


def test_it_gets_all_new_tables_and_keeps_its_rows(
    release: str, data: Path, tmp_path: Path
) -> None:
    before = rows(data)
    with closing(connect(data)) as database, closing(connect(tmp_path / "new")) as new:
        assert schema_of(database) == schema_of(new), AGAIN
        assert list(flaws(database)) == []
        for table, (columns, there) in before.items():
            listed = ", ".join(f'"{name}"' for name in columns)
            assert database.execute(f"SELECT {listed} FROM {table}").fetchall() == there


def test_its_interrupted_session_is_resumed(release: str, data: Path) -> None:
    with closing(connect(data)) as database:
        row = sessions.latest_interrupted(database, data)
    assert row
    clock = VirtualClock(1000 * SECOND)
    play(resume(row["id"], data, catalogue(), clock, somebody), clock)
    with closing(connect(data)) as database:
        assert sessions.find(database, data, row["id"])["status"] == "completed"
        trials = sessions.rows(database, "trials", row["id"])
    assert [(trial["attempt"], trial["trial"]) for trial in trials] == [
        (attempt, trial) for attempt in (1, 2, 3) for trial in (1, 2, 3, 4)
    ]
    assert {trial["run"] for trial in trials} == {1, 2}


def test_it_is_merged_into_another_and_shown(
    release: str, data: Path, call: Call, tmp_path: Path
) -> None:
    other = tmp_path / "other"
    sessions = len(rows(data)["sessions"][1])
    assert call("site", "BERN", "--data", other).code == 0
    called = call("merge", data / FILE, "--data", other)
    assert called.out.startswith(f"From ZURICH: {sessions} new sessions"), called
    assert call("check", "--data", other).code == 0
    listed = call("sessions --json --data", other).json["sessions"]
    assert len(listed) == sessions
    for session in listed:
        shown = call("show", session["id"], "--data", other)
        assert (shown.code, shown.err) == (0, "")
