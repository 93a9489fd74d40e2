"""A session that was started by mistake counts nowhere, until it is restored; no query has a rule
of its own.
"""

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from msgspec.structs import replace

import sar_tui
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.task import Task
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.reports.dose import days_of
from sar_tui.runs.patient_plan import unfinished
from sar_tui.runs.plan import make_plan, set_up
from sar_tui.runs.run import start
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import programmes, results, sessions, training_days
from sar_tui.store.database import StoreError, connect
from sar_tui.store.record_changes import BY_MISTAKE, change_status
from sar_tui.store.selection import Request, select
from sar_tui.store.training_days import done_on_day

SETTINGS = {"attempts": 2, "prompts_per_attempt": 3}
PACKAGE = Path(sar_tui.__file__).parent


@pytest.fixture
def played(data: Path, catalogue: Catalogue) -> str:
    """The id of a live session of P01 with two attempts."""
    plan = make_plan(catalogue, "keyboard", ["P01"], SETTINGS, seed=3)
    clock = VirtualClock(10 * SECOND)
    run = start(
        plan,
        data,
        catalogue,
        clock,
        lambda task, *_: [SimulatedParticipant(PEOPLE["average"], task, 7)],
    )
    run.begin()
    while not run.session.ended:
        assert clock.step()
    run.recorder.write()
    run.close()
    return run.id


@pytest.fixture
def open_database(data: Path, played: str) -> Iterator[sqlite3.Connection]:
    with closing(connect(data)) as database:
        yield database


def counted(database: sqlite3.Connection, data: Path, catalogue: Catalogue) -> dict[str, bool]:
    """Return where the session counts."""
    kind = catalogue.task("keyboard")
    task: Task = set_up(kind, make_plan(catalogue, "keyboard", ["P01"], SETTINGS).parameters)
    now = datetime.now().astimezone()
    try:
        reported = bool(select(database, data, Request(everything=True), only_counted=True).ids)
    except StoreError:
        reported = False
    every = list(results.sessions_of(database, "P01", folder=data))
    return {
        "limit of a day": done_on_day(database, "P01", "keyboard", now).attempts > 0,
        "progress": bool(every),
        "dose": bool(days_of(every)),
        "start level": bool(results.newest_of(database, "P01", "keyboard", 5)),
        "best results": bool(sessions.best(database, "P01", task)),
        "visit": "P01" not in training_days.visits_due(database, now.date()),
        "report": reported,
    }


def test_a_discarded_session_counts_nowhere_and_a_restored_one_everywhere(
    played: str, open_database: sqlite3.Connection, data: Path, catalogue: Catalogue
) -> None:
    database = open_database
    kept = programmes.newest(database, "P01", "keyboard")
    planned = replace(kept, parameters={**SETTINGS, "days_between_visits": 2})
    programmes.save(database, "P01", "keyboard", planned, after=kept.version)
    earlier = (datetime.now().astimezone() - timedelta(days=3)).isoformat()
    database.execute("UPDATE programmes SET created_at=?", (earlier,))
    before = counted(database, data, catalogue)
    assert [name for name, does in before.items() if not does] == []
    assert change_status(
        database, data, played, "discarded", actor="participant", reason=BY_MISTAKE
    )
    after = counted(database, data, catalogue)
    assert [name for name, does in after.items() if does] == []
    assert [row["status"] for row in sessions.listing(database, data)] == ["discarded"], (
        "it is listed"
    )
    assert change_status(database, data, played, "restored", actor="ana")
    assert counted(database, data, catalogue) == before
    assert [row["status"] for row in sessions.listing(database, data)] == ["completed"]


def test_a_report_names_sessions_that_do_not_count(
    played: str, open_database: sqlite3.Connection, data: Path
) -> None:
    change_status(open_database, data, played, "discarded", actor="participant", reason=BY_MISTAKE)
    with pytest.raises(
        StoreError, match=f"Session {played} was discarded: it does not count, and is left out"
    ):
        select(open_database, data, Request(names=(played,)), only_counted=True)
    assert select(open_database, data, Request(names=(played,))).ids == [played], "an export has it"


def test_a_report_without_a_session_that_does_not_count_is_whole(
    played: str, open_database: sqlite3.Connection, data: Path
) -> None:
    names = [
        name for (name,) in open_database.execute("SELECT name FROM pragma_table_info('sessions')")
    ]
    others = ", ".join(name for name in names if name not in ("id", "status"))
    open_database.execute(
        f"INSERT INTO sessions (id, status, {others}) SELECT 'later', 'refused', {others} FROM "
        "sessions"
    )
    open_database.execute(
        "INSERT INTO seats (session, seat, participant) VALUES ('later', 'A', 'P01')"
    )
    found = select(open_database, data, Request(everything=True), only_counted=True)
    assert (found.ids, found.refused) == ([played], ())
    assert found.set_aside == ("Session later was refused: it does not count, and is left out.",)


def test_an_older_interrupted_session_goes_on_after_one_started_by_mistake(
    played: str, open_database: sqlite3.Connection, data: Path
) -> None:
    database = open_database
    row = sessions.stored(database, played)
    assert row
    names = [name for (name,) in database.execute("SELECT name FROM pragma_table_info('sessions')")]
    others = ", ".join(name for name in names if name not in ("id", "status"))
    database.execute(
        f"INSERT INTO sessions (id, status, {others}) SELECT 'later', 'discarded', {others} FROM "
        "sessions"
    )
    database.execute("INSERT INTO seats (session, seat, participant) VALUES ('later', 'A', 'P01')")
    database.execute("UPDATE sessions SET status='interrupted' WHERE id=?", (played,))
    assert unfinished(database, data, "P01", "keyboard") == played


def test_every_query_for_live_sessions_takes_its_condition_from_one_place() -> None:
    own = re.compile(r"""\bmode\s*=+\s*'live'""")
    found = [
        str(path.relative_to(PACKAGE))
        for path in PACKAGE.rglob("*.py")
        if own.search(path.read_text("utf-8"))
    ]
    assert found == ["store/counted.py"], (
        "use COUNTS, or LIVE if it is true of a session that does not count as well"
    )
