"""A session that was started by mistake counts nowhere, until it is restored; no query has a rule
of its own.
"""

import re
from datetime import datetime, timedelta
from pathlib import Path
from sqlite3 import Connection

import pytest
from msgspec.structs import replace

import sar_tui
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.task import Task
from sar_tui.model.units import SECOND
from sar_tui.reports.dose import days_of
from sar_tui.runs.patient_plan import unfinished
from sar_tui.runs.plan import make_plan, set_up
from sar_tui.runs.run import start
from sar_tui.store import programmes, results, sessions, training_days
from sar_tui.store.database import StoreError
from sar_tui.store.record_changes import BY_MISTAKE, change_status
from sar_tui.store.selection import Request, select
from sar_tui.store.tables import SESSIONS
from sar_tui.store.training_days import done_on_day
from tests.played import catalogue, play, somebody
from tests.store.by_hand import insert, sql

SETTINGS = {"attempts": 2, "prompts_per_attempt": 3}
PACKAGE = Path(sar_tui.__file__).parent


@pytest.fixture
def played(data: Path) -> str:
    """The id of a live session of P01 with two attempts."""
    plan = make_plan(catalogue(), "keyboard", ["P01"], SETTINGS, seed=3)
    clock = VirtualClock(10 * SECOND)
    return play(start(plan, data, catalogue(), clock, somebody), clock)


def counted(database: Connection, data: Path) -> dict[str, bool]:
    """Return where the session counts."""
    kind = catalogue().task("keyboard")
    task: Task = set_up(kind, make_plan(catalogue(), "keyboard", ["P01"], SETTINGS).parameters)
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


def statuses(database: Connection, data: Path) -> list[str]:
    return [row["status"] for row in sessions.listing(database, data)]


def discard(database: Connection, data: Path, session: str) -> None:
    who = {"actor": "participant", "reason": BY_MISTAKE}
    assert change_status(database, data, session, "discarded", **who)


def test_a_discarded_session_counts_nowhere_and_a_restored_one_everywhere(
    played: str, database: Connection, data: Path
) -> None:
    kept = programmes.newest(database, "P01", "keyboard")
    planned = replace(kept, parameters={**SETTINGS, "days_between_visits": 2})
    programmes.save(database, "P01", "keyboard", planned, after=kept.version)
    earlier = (datetime.now().astimezone() - timedelta(days=3)).isoformat()
    sql(database, "UPDATE programmes SET created_at=?", earlier)
    before = counted(database, data)
    assert [name for name, does in before.items() if not does] == []
    discard(database, data, played)
    assert [name for name, does in counted(database, data).items() if does] == []
    assert statuses(database, data) == ["discarded"], "it is listed"
    assert change_status(database, data, played, "restored", actor="ana")
    assert counted(database, data) == before
    assert statuses(database, data) == ["completed"]


def store_later(database: Connection, status: str) -> None:
    """Store another session of P01 like the one that there is."""
    others = ", ".join(name for name in SESSIONS.names if name not in ("id", "status"))
    query = f"SELECT 'later', '{status}', {others} FROM sessions"
    sql(database, f"INSERT INTO sessions (id, status, {others}) {query}")
    insert(database, "seats", session="later")


def test_a_report_without_a_session_that_does_not_count_is_whole(
    played: str, database: Connection, data: Path
) -> None:
    store_later(database, "refused")
    with pytest.raises(StoreError, match="Session later was refused: it does not count"):
        select(database, data, Request(names=("later",)), only_counted=True)
    assert select(database, data, Request(names=("later",))).ids == ["later"], "an export has it"
    found = select(database, data, Request(everything=True), only_counted=True)
    assert (found.ids, found.refused) == ([played], ())
    assert found.set_aside == ("Session later was refused: it does not count, and is left out.",)


def test_an_older_interrupted_session_goes_on_after_one_started_by_mistake(
    played: str, database: Connection, data: Path
) -> None:
    store_later(database, "discarded")
    sql(database, "UPDATE sessions SET status='interrupted' WHERE id=?", played)
    assert unfinished(database, data, "P01", "keyboard") == played


def test_every_query_for_live_sessions_takes_its_condition_from_one_place() -> None:
    """Use COUNTS, or LIVE if it is true of a session that does not count as well."""
    own = re.compile(r"""\bmode\s*(=+\s*'live'|IN\b)""")
    found = [path for path in PACKAGE.rglob("*.py") if own.search(path.read_text("utf-8"))]
    assert found == [PACKAGE / "store" / "counted.py"]
