"""Compares the records of sessions that both databases have, without reading them into memory.

A session's log only grows: rows that are never changed afterwards. A record whose log has all rows
of another's, and more, extends it. What else a session has (results, actions, notes) follows from
the log.
"""

import sqlite3
from collections import Counter
from collections.abc import Iterable
from typing import Literal

from sar_tui.store.tables import SESSION_TABLES, SESSIONS, TABLES

Relation = Literal["equal", "longer here", "longer there", "contradictory"]

LOG = {"seats": ("participant",), "runs": (), "log_hashes": (), "imu_streams": (), "imu_chunks": ("data",),
       "trials": ("correct", "details")}  # fmt: skip
"""Tables of the log beside ``messages``, and the columns that may change or, being checked by
another, are left out.
"""
CHANGED_LATER = ("status", "ended_at", "log_hash")
"""Columns of ``sessions`` that change after it began."""


def number_topics(db: sqlite3.Connection) -> None:
    """Store the topics that the main database lacks, and relate the numbers of both in
    ``topic_numbers``.
    """
    db.execute(
        "INSERT OR IGNORE INTO main.topics (name, fields) SELECT name, fields FROM other.topics "
        "ORDER BY id"
    )
    db.execute("CREATE TEMP TABLE topic_numbers (there INTEGER PRIMARY KEY, here INTEGER NOT NULL)")
    db.execute(
        "INSERT INTO topic_numbers SELECT there.id, here.id FROM other.topics AS there JOIN "
        "main.topics AS here"
        " USING (name, fields)"
    )


def compare(db: sqlite3.Connection, sessions: Iterable[str]) -> dict[str, Relation]:
    """Return how the records of sessions relate that are in the databases ``main`` and
    ``other``.
    """
    db.execute(
        "CREATE TEMP TABLE IF NOT EXISTS compared (id TEXT PRIMARY KEY, here INTEGER, there "
        "INTEGER)"
    )
    db.execute("DELETE FROM temp.compared")
    db.executemany(
        "INSERT INTO temp.compared SELECT id, (SELECT number FROM main.session_numbers WHERE "
        "id=given.id),"
        " (SELECT number FROM other.session_numbers WHERE id=given.id) FROM (SELECT ? AS id) AS "
        "given",
        [(session,) for session in sessions],
    )
    here, there, common = Counter[str](), Counter[str](), Counter[str]()
    for table, left_out in LOG.items():
        _count(db, table, left_out, here, there, common)
    _count_messages(db, here, there, common)
    differ = _facts_that_differ(db)
    follow = _what_follows_differs(db)
    relations: dict[str, Relation] = {}
    for (session,) in db.execute("SELECT id FROM temp.compared"):
        counts = here[session], there[session], common[session]
        relations[session] = "contradictory" if session in differ else _relation(*counts)
        if relations[session] == "equal" and session in follow:
            relations[session] = "contradictory"
    return relations


def _relation(here: int, there: int, common: int) -> Relation:
    if here == there == common:
        return "equal"
    if common == here:
        return "longer there"
    return "longer here" if common == there else "contradictory"


def _count(
    db: sqlite3.Connection,
    table: str,
    left_out: tuple[str, ...],
    here: Counter[str],
    there: Counter[str],
    common: Counter[str],
) -> None:
    """Add the numbers of a table's rows here, there and in common, by session."""
    for schema, counter in (("main", here), ("other", there)):
        counter.update(dict(db.execute(
            f"SELECT compared.id, count(*) FROM temp.compared CROSS JOIN {schema}.{table} ON session=compared.id"
            " GROUP BY compared.id"
        )))  # fmt: skip
    key = TABLES[table].key
    rest = [name for name in TABLES[table].names if name not in (*key, *left_out)]
    same_key = " AND ".join(f"here.{name}=there.{name}" for name in key if name != "session")
    same = "".join(f" AND here.{name} IS there.{name}" for name in rest)
    common.update(dict(db.execute(
        "SELECT compared.id, count(*) FROM temp.compared"
        f" CROSS JOIN other.{table} AS there ON there.session=compared.id"
        f" CROSS JOIN main.{table} AS here ON here.session=compared.id AND {same_key}{same} GROUP BY compared.id"
    )))  # fmt: skip


def _count_messages(
    db: sqlite3.Connection, here: Counter[str], there: Counter[str], common: Counter[str]
) -> None:
    for schema, column, counter in (("main", "here", here), ("other", "there", there)):
        counter.update(dict(db.execute(
            f"SELECT id, count(*) FROM temp.compared CROSS JOIN {schema}.messages ON session_number={column}"
            " GROUP BY id"
        )))  # fmt: skip
    common.update(dict(db.execute(
        "SELECT compared.id, count(*) FROM temp.compared"
        " CROSS JOIN other.messages AS there ON there.session_number=compared.there"
        " CROSS JOIN main.messages AS here ON here.session_number=compared.here AND here.seq=there.seq"
        " JOIN temp.topic_numbers ON topic_numbers.there=there.topic"
        " WHERE here.run=there.run AND here.at_ns=there.at_ns AND here.topic=topic_numbers.here"
        " AND here.message=there.message GROUP BY compared.id"
    )))  # fmt: skip


def _facts_that_differ(db: sqlite3.Connection) -> set[str]:
    same = " AND ".join(
        f"here.{name} IS there.{name}"
        for name in SESSIONS.names
        if name not in ("id", *CHANGED_LATER)
    )
    found = db.execute(
        "SELECT id FROM temp.compared JOIN main.sessions AS here USING (id) JOIN other.sessions "
        "AS there USING (id)"
        f" WHERE NOT ({same})"
    )
    return {session for (session,) in found}


def _what_follows_differs(db: sqlite3.Connection) -> set[str]:
    """Return the sessions whose rows beside the log are not the same."""
    found: set[str] = set()
    for table in SESSION_TABLES:
        if table in LOG and not set(LOG[table]) - {"data"}:
            continue
        if TABLES[table].key:
            here, there, common = Counter[str](), Counter[str](), Counter[str]()
            _count(db, table, (), here, there, common)
            found.update(id for id in here | there if not here[id] == there[id] == common[id])
        else:
            found.update(_without_key(db, table))
    return found


def _without_key(db: sqlite3.Connection, table: str) -> set[str]:
    """Return the sessions whose rows in a table without a key are not the same, or not as often the
    same.
    """
    listed = ", ".join(f'"{name}"' for name in TABLES[table].names)
    here, there = (
        f"SELECT {listed}, count(*) FROM temp.compared CROSS JOIN {schema}.{table} ON "
        "session=compared.id"
        f" GROUP BY {listed}"
        for schema in ("main", "other")
    )
    found = db.execute(
        f"SELECT session FROM (SELECT * FROM ({here}) EXCEPT SELECT * FROM ({there}))"
        f" UNION SELECT session FROM (SELECT * FROM ({there}) EXCEPT SELECT * FROM ({here}))"
    )
    return {session for (session,) in found}
