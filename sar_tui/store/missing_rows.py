"""Rows that a database lacks, by session: those that other rows know of."""

import sqlite3
from collections import Counter
from typing import NamedTuple

from sar_tui.store import log_hashes, messages

_KNOWN_BY = (
    "log_hashes",
    "seats",
    "runs",
    "attempts",
    "trials",
    "actions",
    "imu_streams",
    "imu_chunks",
)
"""Tables that may know a session whose own row is lost."""
_TABLES = {"run": "runs", "stream": "imu_streams", "chunk": "imu_chunks"}


class Missing(NamedTuple):
    """Rows of a table that are missing from a session, and their number."""

    session: str
    table: str
    rows: int


def missing_rows(database: sqlite3.Connection) -> list[Missing]:
    """Return the rows that are missing, as far as others tell: a session of which nothing is left
    is not among them.
    """
    found: list[Missing] = []
    for session in _sessions(database):
        counts = Counter[str]()
        if not _one(database, "SELECT count(*) FROM sessions WHERE id=?", session):
            counts["sessions"] = 1
        if not _one(database, "SELECT count(*) FROM seats WHERE session=?", session):
            counts["seats"] = 1
        _count_log(database, session, counts)
        counts["trials"] = _one(
            database,
            "SELECT coalesce(sum(max(0, trials - (SELECT count(*) FROM trials WHERE "
            "session=attempts.session"
            " AND attempt=attempts.attempt AND seat=attempts.seat))), 0) FROM attempts WHERE "
            "session=?",
            session,
        )
        counts["attempts"] = _one(
            database,
            "WITH given (session) AS (VALUES (?)) SELECT count(*) FROM (SELECT DISTINCT attempt, "
            "seat FROM trials"
            " JOIN given USING (session) WHERE attempt<(SELECT max(attempt) FROM trials JOIN "
            "given USING (session))"
            " EXCEPT SELECT attempt, seat FROM attempts JOIN given USING (session))",
            session,
        )
        found += [Missing(session, table, count) for table, count in counts.items() if count]
    return found


def _sessions(database: sqlite3.Connection) -> list[str]:
    queries = ["SELECT id FROM sessions", "SELECT id FROM session_numbers"]
    queries += [f"SELECT session FROM {table}" for table in _KNOWN_BY]
    return [str(name) for (name,) in database.execute(" UNION ".join(queries)) if name is not None]


def _count_log(database: sqlite3.Connection, session: str, counts: Counter[str]) -> None:
    """Count what the hashes of a session's log know of, and is not there."""
    groups = database.execute(
        "SELECT number, seq, beside FROM log_hashes WHERE session=? AND typeof(number)='integer' "
        "AND"
        " typeof(seq)='integer' ORDER BY number",
        (session,),
    ).fetchall()
    if not groups:
        return
    last, until, _ = groups[-1]
    counts["log_hashes"] = last - len(groups)
    counts["messages"] = max(0, until - messages.count(database, session, until))
    stored = {tuple(entry) for entry in log_hashes.entries_there(database, session)}
    for _, _, beside in groups:
        for kind, *key in log_hashes.entries(beside):
            if kind in _TABLES and (kind, *key) not in stored:
                counts[_TABLES[kind]] += 1


def _one(database: sqlite3.Connection, query: str, session: str) -> int:
    return int(database.execute(query, (session,)).fetchone()[0])
