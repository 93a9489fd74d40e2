"""Databases of several sites for tests of merges, and what a database holds in words that all of
them share.
"""

import json
import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store import sites
from sar_tui.store.database import FILE, connect, transaction
from sar_tui.store.merge import merge as merging
from sar_tui.store.merge.merge import Merged
from sar_tui.store.merge.people import People, in_full, stored_pairs
from sar_tui.store.sites import OF_SITES
from sar_tui.store.tables import TABLES
from tests.store.by_hand import insert, sql, value

_LOCAL = ("session_numbers", "topics", "site")
"""Tables with numbers of one database only."""
_TOPICS = (("input/key", '[["key"],["at"]]'), ("event_handler/trial", '[["trial"]]'))


def site(folder: Path, code: str) -> Path:
    """Make an empty database of a site, and return its folder."""
    with closing(connect(folder)) as db:
        sites.set_own(db, code)
    return folder


def play(
    folder: Path, session: str, participant: str = "P01", *, trials: int = 2,
    began: str = "2026-03-01T10:00:00+00:00", status: str = "completed", mode: str = "live",
) -> str:  # fmt: skip
    """Store a session with some trials, and return its id."""
    with closing(connect(folder)) as db, transaction(db):
        known = "INSERT OR IGNORE INTO participants (code, created_at) VALUES (?,?)"
        sql(db, known, participant, began)
        insert(db, "sessions", id=session, status=status, started_at=began, mode=mode)
        insert(db, "seats", session=session, participant=participant)
        sql(db, "INSERT INTO session_numbers (id) VALUES (?)", session)
    go_on(folder, session, trials=trials, status=status)
    return session


def go_on(
    folder: Path, session: str, *, trials: int = 1, status: str = "completed", response: str = "f"
) -> None:
    """Add trials to a session in another run of the program."""
    with closing(connect(folder)) as db, transaction(db):
        run = value(db, "SELECT coalesce(max(run), 0) + 1 FROM runs WHERE session=?", session)
        last = value(db, "SELECT coalesce(max(trial), 0) FROM trials WHERE session=?", session)
        number = value(db, "SELECT number FROM session_numbers WHERE id=?", session)
        anchor = json.dumps({"clock_ns": run, "utc": "2026-03-01T10:00:00+00:00"})
        insert(db, "runs", session=session, run=run, clock_anchor=anchor, pid=7)
        db.executemany("INSERT OR IGNORE INTO topics (name, fields) VALUES (?,?)", _TOPICS)
        for trial in range(last + 1, last + trials + 1):
            at, text = 1000 * trial, f'["{response}",{trial}]'
            for seq, topic in enumerate(_TOPICS, 2 * trial - 1):
                id = value(db, "SELECT id FROM topics WHERE (name, fields)=(?,?)", *topic)
                sql(db, "INSERT INTO messages VALUES (?,?,?,?,?,?)", number, seq, run, at, id, text)
            insert(
                db, "trials", session=session, trial=trial, run=run, stimulus="F", response=response,
                correct=1, onset_ns=at, response_ns=1500 * trial, reaction_time_ms=1 / trial,
                timing="{}", details="{}", data="{}",
            )  # fmt: skip
            insert(
                db, "notes", session=session, at_ns=trial % 2, author="op", text='"so"', label=""
            )
        count = last + trials
        sql(db, "DELETE FROM attempts WHERE session=?", session)
        insert(
            db, "attempts", session=session, run=run, metric=1 / (count + 1), trials=count,
            qualities="{}", correct=1, accuracy=1, outcome="success", started_ns=1, ended_ns=9,
        )  # fmt: skip
        ended = f"2026-03-02T{run:02}"
        sql(db, "UPDATE sessions SET status=?, ended_at=? WHERE id=?", status, ended, session)


def change(folder: Path, statement: str, *values: object) -> None:
    """Change a database behind the program's back."""
    sql(folder, statement, *values)


def save_programme(
    folder: Path, participant: str, version: int, parameters: str, at: str = "2026-03-01"
) -> None:
    row = {"participant": participant, "version": version, "created_at": at}
    insert(folder, "programmes", parameters=parameters, **row)


def copy(folder: Path, to: Path) -> Path:
    """Copy a data folder as it is now."""
    to.mkdir()
    with closing(connect(folder)) as db, closing(sqlite3.connect(to / FILE)) as target:
        db.backup(target)
    return to


def merge(
    folder: Path, *others: Path | None, same: tuple[str, ...] = (), one_site: bool = False
) -> Merged:
    """Merge other databases into one, in order, and return the last result."""
    for other in others:
        result = merging.merge(
            folder, other, same, one_site=one_site, start=lambda step: lambda done, total: None
        )
    return result


def holds(folder: Path) -> dict[str, Counter[Any]]:
    """Return all rows by table. Codes, sites and the numbers of sessions and topics are in full."""
    with closing(connect(folder)) as db:
        people = People(sites.own(db), stored_pairs(db))
        return {
            table: Counter(_in_words(db, table, people)) for table in TABLES if table not in _LOCAL
        }


def _in_words(db: sqlite3.Connection, table: str, people: People) -> list[Any]:
    query = f"SELECT * FROM {table}"
    if table == "messages":
        query = (
            "SELECT session_numbers.id AS session, seq, run, at_ns, name, fields, message FROM "
            "messages JOIN session_numbers ON number=session_number JOIN topics ON topics.id=topic"
        )
    found = db.execute(query)
    names = [name for name, *_ in found.description]

    def in_words(name: str, value: Any) -> Any:
        if name == "site" and table in OF_SITES:
            return None if table == "participants" else value or people.own
        if table == "exports" and name == "number":
            return None
        if (table, name) == ("records", "id"):
            return in_full(value, people.own)
        if name == "replaced_by":
            return value and in_full(value, people.own)
        if name == "participant" or (table, name) == ("participants", "code"):
            code = in_full(value, people.own)
            return code if table in ("programmes", "people_events") else people.name(code)
        return value

    return [
        tuple(in_words(name, value) for name, value in zip(names, row, strict=True))
        for row in found
    ]
