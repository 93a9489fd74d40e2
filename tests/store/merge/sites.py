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
from sar_tui.store.database import FILE, connect
from sar_tui.store.merge import merge as merging
from sar_tui.store.merge.merge import Merged
from sar_tui.store.merge.people import People, in_full, stored_pairs
from sar_tui.store.sites import OF_SITES

_LOCAL = ("session_numbers", "topics", "checkpoints", "site")
"""Tables with numbers of one database only."""
_TOPICS = (("input/key", '[["key"],["at"]]'), ("event_handler/trial", '[["trial"]]'))


def site(folder: Path, code: str) -> Path:
    """Make an empty database of a site, and return its folder."""
    with closing(connect(folder)) as db:
        sites.set_own(db, code)
    return folder


def play(
    folder: Path,
    session: str,
    participant: str = "P01",
    *,
    trials: int = 2,
    began: str = "2026-03-01T10:00:00+00:00",
    status: str = "completed",
    mode: str = "live",
) -> str:
    """Store a session with some trials, and return its id."""
    with closing(connect(folder)) as db:
        db.execute("BEGIN")
        db.execute(
            "INSERT OR IGNORE INTO participants (code, created_at) VALUES (?,?)",
            (participant, began),
        )
        db.execute(
            "INSERT INTO sessions (id, task, theme, status, started_at, seed, parameters, "
            "software, machine, mode)"
            " VALUES (?,'keyboard','calm',?,?,1,'{}','{}','{}',?)",
            (session, status, began, mode),
        )
        db.execute("INSERT INTO seats VALUES (?,'A',?)", (session, participant))
        db.execute("INSERT INTO session_numbers (id) VALUES (?)", (session,))
        db.execute("COMMIT")
    go_on(folder, session, trials=trials, status=status)
    return session


def go_on(
    folder: Path, session: str, *, trials: int = 1, status: str = "completed", response: str = "f"
) -> None:
    """Add trials to a session in another run of the program."""
    with closing(connect(folder)) as db:
        db.execute("BEGIN")
        (run,) = db.execute(
            "SELECT coalesce(max(run), 0) + 1 FROM runs WHERE session=?", (session,)
        ).fetchone()
        anchor = json.dumps({"clock_ns": run, "utc": "2026-03-01T10:00:00+00:00"})
        db.execute(
            "INSERT INTO runs (session, run, clock_anchor, pid) VALUES (?,?,?,7)",
            (session, run, anchor),
        )
        db.executemany("INSERT OR IGNORE INTO topics (name, fields) VALUES (?,?)", _TOPICS)
        (number,) = db.execute(
            "SELECT number FROM session_numbers WHERE id=?", (session,)
        ).fetchone()
        query = "SELECT coalesce(max(trial), 0) FROM trials WHERE session=?"
        (last,) = db.execute(query, (session,)).fetchone()
        for trial in range(last + 1, last + trials + 1):
            for offset, topic in enumerate(_TOPICS):
                db.execute(
                    "INSERT INTO messages SELECT ?,?,?,?,id,? FROM topics WHERE (name, "
                    "fields)=(?,?)",
                    (
                        number,
                        2 * trial + offset - 1,
                        run,
                        1000 * trial,
                        f'["{response}",{trial}]',
                        *topic,
                    ),
                )
            db.execute(
                "INSERT INTO trials (session, attempt, trial, seat, run, stimulus, response, "
                "correct, onset_ns, response_ns, reaction_time_ms, timing, details, data)"
                " VALUES (?,1,?,'A',?,'F',?,1,?,?,?,'{}','{}','{}')",
                (session, trial, run, response, 1000 * trial, 1500 * trial, 1 / trial),
            )
            db.execute(
                "INSERT INTO notes (session, at_ns, author, text, label)"
                " VALUES (?,?,'op','\"so\"','')",
                (session, trial % 2),
            )
        db.execute(
            "INSERT OR REPLACE INTO attempts (session, attempt, seat, run, practice, level, "
            "metric, trials, qualities,"
            " correct, accuracy, outcome, started_ns, ended_ns) VALUES "
            "(?,1,'A',?,0,1,?,?,'{}',1,1,'success',1,9)",
            (session, run, 1 / (last + trials + 1), last + trials),
        )
        db.execute(
            "UPDATE sessions SET status=?, ended_at=? WHERE id=?",
            (status, f"2026-03-02T{run:02}", session),
        )
        db.execute("COMMIT")


def change(folder: Path, statement: str, *values: object) -> None:
    """Change a database behind the program's back."""
    with closing(connect(folder)) as db:
        db.execute(statement, values)


def save_programme(
    folder: Path, participant: str, version: int, parameters: str, at: str = "2026-03-01"
) -> None:
    row = (participant, version, at, parameters)
    change(
        folder,
        "INSERT INTO programmes (participant, task, version, created_at, author, reason, "
        "parameters, theme, site)"
        " VALUES (?,'keyboard',?,?,'','',?,'calm','')",
        *row,
    )


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
        tables = [
            name for (name,) in db.execute("SELECT name FROM sqlite_master WHERE type='table'")
        ]
        wanted = [
            name for name in tables if not name.startswith(("_", "sqlite")) and name not in _LOCAL
        ]
        return {table: Counter(_in_words(db, table, people)) for table in wanted}


def _in_words(db: sqlite3.Connection, table: str, people: People) -> list[Any]:
    query = f"SELECT * FROM {table}"
    if table == "messages":
        query = (
            "SELECT session_numbers.id AS session, seq, run, at_ns, name, fields, message FROM "
            "messages"
            " JOIN session_numbers ON number=session_number JOIN topics ON topics.id=topic"
        )
    found = db.execute(query)
    names = [name for name, *_ in found.description]

    def in_words(name: str, value: Any) -> Any:
        if name == "site" and table in OF_SITES:
            return None if table == "participants" else value or people.own
        if table == "exports" and name == "number":
            return None
        if name == "event":
            return in_full(value, people.own)
        if name == "participant" or (table, name) == ("participants", "code"):
            code = in_full(value, people.own)
            return code if table == "programmes" else people.name(code)
        return value

    return [
        tuple(in_words(name, value) for name, value in zip(names, row, strict=True))
        for row in found
    ]
