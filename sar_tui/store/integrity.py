"""The whole database examined: damaged pages, rows without their session, gaps, damaged samples and texts."""

import sqlite3
import zlib
from collections.abc import Iterator
from typing import Literal, NamedTuple

import msgspec

from sar_tui.store.database import damaged, explain

Kind = Literal["file", "orphan", "gap", "samples", "text"]
"""``file``: its pages are damaged. ``orphan``: rows that belong to nothing. ``gap``: numbers that are missing in a row
of events, attempts or trials. ``samples``: a block of a sensor's samples. ``text``: a column that is no JSON."""

_MOST_FAULTS = 20
"""Largest number of damaged pages that are named."""
_SESSION_TABLES = (
    "seats", "runs", "attempts", "trials", "actions", "notes", "imu_streams", "imu_chunks", "checkpoints",
    "earlier_events", "wellbeing", "adverse_events",
)  # fmt: skip
_ORPHANS = {
    "sessions without a seat": "SELECT id FROM sessions WHERE id NOT IN (SELECT session FROM seats)",
    "seats without a participant": (  # simulated people are no participants
        "SELECT session FROM seats JOIN sessions ON id=session WHERE mode='live'"
        " AND participant NOT IN (SELECT code FROM participants)"
    ),
    "events without a session": "SELECT id FROM session_numbers WHERE id NOT IN (SELECT id FROM sessions)",
    "events without a number of their session": (
        "SELECT DISTINCT session_number FROM messages WHERE session_number NOT IN (SELECT number FROM session_numbers)"
    ),
    "events without a topic": (
        "SELECT DISTINCT id FROM messages JOIN session_numbers ON number=session_number"
        " WHERE topic NOT IN (SELECT id FROM topics)"
    ),
    "samples without their stream": (
        "SELECT DISTINCT session FROM imu_chunks AS chunks WHERE NOT EXISTS"
        " (SELECT 1 FROM imu_streams WHERE session=chunks.session AND stream=chunks.stream)"
    ),
} | {
    f"{table} without a session": (
        f"SELECT DISTINCT session FROM {table} WHERE session IS NOT NULL AND session NOT IN (SELECT id FROM sessions)"
    )
    for table in _SESSION_TABLES
}
_GAPS = {
    "events": (
        "SELECT session, '', min(seq), max(seq), count(*) FROM (SELECT session, seq FROM earlier_events UNION ALL"
        " SELECT id, seq FROM messages JOIN session_numbers ON number=session_number) GROUP BY session"
    ),
    "attempts": (
        "SELECT session, '', min(attempt), max(attempt), count(DISTINCT attempt) FROM attempts GROUP BY session"
    ),
    "trials": (
        "SELECT session, ' of attempt ' || attempt, min(trial), max(trial), count(DISTINCT trial) FROM trials"
        " GROUP BY session, attempt"
    ),
    "blocks of samples": (
        "SELECT session, ' of stream ' || stream, min(seq), max(seq), count(*) FROM imu_chunks GROUP BY session, stream"
    ),
}
_JSON = {
    "sessions": ("id", ("parameters", "software", "machine")),
    "runs": ("session", ("clock_anchor", "software", "machine")),
    "attempts": ("session", ("qualities", "choice")),
    "trials": ("session", ("timing", "details")),
    "actions": ("session", ("proposed", "final")),
    "programmes": ("participant", ("parameters",)),
    "earlier_events": ("session", ("message",)),
    "messages": ("(SELECT id FROM session_numbers WHERE number=session_number)", ("message",)),
}


class Flaw(NamedTuple):
    """A flaw of the database. ``where``: a session or a participant; empty for the file. ``what``: in words."""

    kind: Kind
    where: str
    what: str


def flaws(database: sqlite3.Connection, *, gaps: bool = True) -> Iterator[Flaw]:
    """Yield the flaws of a database, as it was when the first of them was looked for.

    Nothing is written, and a session may go on meanwhile. Gaps are looked for unless they do not matter.

    Raises:
        StoreError: the database cannot be read at all.
    """
    try:
        database.execute("BEGIN")
        try:
            found = list(_damaged_pages(database))
            yield from found
            if not found:  # the rest is read from these pages
                yield from _orphans(database)
                yield from _gaps(database) if gaps else ()
                yield from _damaged_samples(database)
                yield from _damaged_texts(database)
        finally:
            if database.in_transaction:
                database.execute("ROLLBACK")
    except sqlite3.Error as error:
        raise explain(error) from error
    except UnicodeDecodeError as error:
        raise damaged() from error


def _damaged_pages(database: sqlite3.Connection) -> Iterator[Flaw]:
    try:
        for (text,) in database.execute(f"PRAGMA integrity_check({_MOST_FAULTS})"):
            if text != "ok":
                yield Flaw("file", "", f"The file is damaged: {text}.")
    except sqlite3.DatabaseError as error:
        if getattr(error, "sqlite_errorcode", 0) & 0xFF != sqlite3.SQLITE_CORRUPT:
            raise
        yield Flaw("file", "", f"The file is damaged: {error}.")


def _orphans(database: sqlite3.Connection) -> Iterator[Flaw]:
    for what, query in _ORPHANS.items():
        for (where,) in database.execute(query):
            yield Flaw("orphan", str(where), f"There are {what}.")


def _gaps(database: sqlite3.Connection) -> Iterator[Flaw]:
    for what, query in _GAPS.items():
        for session, of, first, last, count in database.execute(query):
            if missing := last - count:
                yield Flaw("gap", session, f"Of {last} {what}{of}, {missing} are missing.")
            elif first != 1:
                yield Flaw("gap", session, f"The {what}{of} do not begin at 1.")


def _damaged_samples(database: sqlite3.Connection) -> Iterator[Flaw]:
    sizes: dict[str, int] = {}
    for session, stream, seq, count, crc, data, layout in database.execute(
        "SELECT session, stream, seq, n, crc32, data, layout FROM imu_chunks JOIN imu_streams USING (session, stream)"
    ):
        if layout not in sizes:
            sizes[layout] = _size(layout)
        if zlib.crc32(data) != crc or len(data) != count * sizes[layout]:
            yield Flaw("samples", session, f"Block {seq} of sensor stream {stream} is damaged.")


def _size(layout: str) -> int:
    """Return the bytes of a sample; 0 if its layout cannot be read, so that its blocks count as damaged."""
    import numpy as np

    try:
        return np.dtype([tuple(_tuples(field)) for field in msgspec.json.decode(layout)]).itemsize
    except (TypeError, ValueError, msgspec.DecodeError):
        return 0


def _tuples(field: list[object]) -> Iterator[object]:
    return (tuple(part) if isinstance(part, list) else part for part in field)


def _damaged_texts(database: sqlite3.Connection) -> Iterator[Flaw]:
    for table, (where, columns) in _JSON.items():
        for column in columns:
            wrong = f"{column} IS NOT NULL AND NOT json_valid({column})"
            for whose, count in database.execute(f"SELECT {where}, count(*) FROM {table} WHERE {wrong} GROUP BY 1"):
                yield Flaw("text", str(whose), f"{count} of the texts {table}.{column} cannot be read.")


def counts(database: sqlite3.Connection) -> dict[str, int]:
    """Return the number of rows of each table."""
    tables = database.execute(
        "SELECT name FROM sqlite_master WHERE type='table' AND name NOT LIKE 'sqlite%' ORDER BY name"
    ).fetchall()
    return {name: int(database.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0]) for (name,) in tables}
