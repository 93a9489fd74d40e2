"""Rescue of a database whose pages are damaged, or whose file was cut short: all rows that SQLite
still reads go into a new file; and what is missing from it, as far as other rows know.
"""

import contextlib
import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from sar_tui.store import log_hashes, messages, schema
from sar_tui.store.database import damaged, explain, unreleased, version_of

_MOST_FAILURES = 20_000
"""Largest number of ranges of a table, or of a session's messages, that fail before the rest of it
is given up.
"""
_MOST_IN_ALL = 1_000_000
"""The same for all messages: their root is damaged."""
_AFTER = 2**16
"""Row numbers that are tried beyond the last one that can be seen."""


def open_wary(path: Path, timeout: float = 0) -> sqlite3.Connection:
    """Open a damaged database so that SQLite reads what it can, and runs nothing that is in its
    schema.
    """
    database = sqlite3.connect(path, timeout=timeout, isolation_level=None)
    # tolerates pages that are missing, and a schema that is read in part
    database.execute("PRAGMA writable_schema=ON")
    database.execute("PRAGMA trusted_schema=OFF")
    return database


class Unread(NamedTuple):
    """A range of rows that could not be read: the table, the first and the last row number.

    ``session``: for messages, the session that they are of; the numbers are those of its events.
    Both numbers are 0 if nothing of the table could be read.
    """

    table: str
    first: int
    last: int
    session: str = ""


def salvage(database: sqlite3.Connection, file: Path, new: Path) -> list[Unread]:
    """Copy all rows that can be read into an empty file, and return the ranges that could not.

    The new file has the tables of this program. What else is in the schema of the damaged one is
    not copied.

    Args:
        database: the damaged database, opened by `open_wary`. Nothing is written to it.
        file: its path, for messages.
        new: the file to fill.

    Raises:
        StoreError: not even the table of sessions is known, a newer or an unreleased program wrote
            the file, or the new file cannot be written.
    """
    there = _tables(database)
    if "sessions" not in there:
        raise damaged(file)
    _check_version(database, file, there)
    with closing(sqlite3.connect(new, isolation_level=None)) as opened:
        try:
            schema.create(opened)
            ours = [name for (name,) in opened.execute(_OURS)]
        except sqlite3.Error as error:
            raise explain(error, new) from error
    try:
        database.execute("ATTACH ? AS salvaged", (str(new),))
        database.execute("PRAGMA salvaged.synchronous=OFF")  # synced as a whole, by the caller
        found = [Unread(name, 0, 0) for name in ours if name not in there]
        # Numbers of sessions come before the events that are read by them.
        for name in sorted(ours, key=lambda name: name == "messages"):
            if name in there:
                found += _copy(database, name)
        database.execute("DETACH salvaged")
    except sqlite3.Error as error:
        raise explain(error, new) from error
    return found


_OURS = (
    "SELECT name FROM sqlite_master WHERE type='table' AND name NOT GLOB 'sqlite_*' AND name "
    "NOT GLOB '_*'"
)


def _tables(database: sqlite3.Connection) -> set[str]:
    """Return the names of the tables, as far as the schema can be read."""
    found: set[str] = set()
    for order in ("ASC", "DESC"):
        with contextlib.suppress(sqlite3.Error, UnicodeDecodeError):
            for (name,) in database.execute(
                "SELECT name FROM main.sqlite_master WHERE type='table' AND rootpage>0 ORDER BY "
                f"rowid {order}"
            ):
                found.add(str(name))
    return found


def _check_version(database: sqlite3.Connection, file: Path, tables: set[str]) -> None:
    """Raise StoreError if another version of the program wrote the database, also if its header,
    with the number, is damaged.
    """
    if "_sqlite_migrations" in tables:
        raise unreleased(file)
    with contextlib.suppress(sqlite3.Error):
        version_of(database, file)


def _copy(database: sqlite3.Connection, table: str) -> list[Unread]:
    there = {name for _, name, *_ in database.execute(f'PRAGMA main.table_info("{table}")')}
    ours = [name for _, name, *_ in database.execute(f'PRAGMA salvaged.table_info("{table}")')]
    columns = ", ".join(f'"{name}"' for name in ours if name in there)
    if table == "messages":  # has no row numbers
        return _copy_messages(database, columns)
    reader = _Reader(database, table, f"rowid, {columns}", "rowid")
    if reader.copy("", (), -(2**63), 2**63 - 1, is_whole=True):
        return []
    first, last = _bounds(database, table)
    reader.split("", (), first, last)
    return reader.unread


def _copy_messages(database: sqlite3.Connection, columns: str) -> list[Unread]:
    reader = _Reader(database, "messages", columns, "seq")
    if reader.copy("", (), -(2**63), 2**63 - 1, is_whole=True):
        return []
    for number, session in database.execute(
        "SELECT number, id FROM salvaged.session_numbers ORDER BY number"
    ).fetchall():
        reader.begin(session)
        if not reader.copy("session_number=? AND ", (number,), 0, 2**31):
            reader.split("session_number=? AND ", (number,), 0, _last_seq(database, number))
    return reader.unread


class _Reader:
    """Copies ranges of a table, halved again and again where they cannot be read."""

    def __init__(self, database: sqlite3.Connection, table: str, columns: str, key: str) -> None:
        self._database = database
        self._table = table
        self._columns = columns
        self._key = key
        self._session = ""
        self._failures = self._in_all = 0
        self.unread: list[Unread] = []

    def begin(self, session: str) -> None:
        """Begin with the messages of a session."""
        self._session, self._failures = session, 0

    def copy(
        self, of: str, values: tuple[int, ...], first: int, last: int, *, is_whole: bool = False
    ) -> bool:
        """Copy a range of rows; return False, and copy none, if one of them cannot be read."""
        condition = "" if is_whole else f"WHERE {of}{self._key} BETWEEN ? AND ?"
        try:
            self._database.execute(
                f'INSERT OR IGNORE INTO salvaged."{self._table}" ({self._columns})'
                f' SELECT {self._columns} FROM main."{self._table}" NOT INDEXED {condition}',
                () if is_whole else (*values, first, last),
            )
        except sqlite3.DatabaseError as error:
            if not _is_damage(error):
                raise
            return False
        return True

    def split(self, of: str, values: tuple[int, ...], first: int, last: int) -> None:
        """Copy the readable rows of a range."""
        if first > last:
            return
        is_given_up = self._failures >= _MOST_FAILURES or self._in_all >= _MOST_IN_ALL
        if not is_given_up and self.copy(of, values, first, last):
            return
        self._failures += 1
        self._in_all += 1
        if first == last or is_given_up:
            self._note(first, last)
            return
        middle = (first + last) // 2
        self.split(of, values, first, middle)
        self.split(of, values, middle + 1, last)

    def _note(self, first: int, last: int) -> None:
        if (
            self.unread
            and self.unread[-1].session == self._session
            and self.unread[-1].last + 1 == first
        ):
            first = self.unread.pop().first
        self.unread.append(Unread(self._table, first, last, self._session))


def _bounds(database: sqlite3.Connection, table: str) -> tuple[int, int]:
    """Return a first and a last row number between which all rows of a table are, as far as that
    can be known.
    """
    backwards = _seen(database, f'SELECT rowid FROM main."{table}" NOT INDEXED ORDER BY rowid DESC')
    seen = backwards | _seen(
        database, f'SELECT rowid FROM main."{table}" NOT INDEXED ORDER BY rowid'
    )
    for _, index, *_ in database.execute(f'PRAGMA main.index_list("{table}")').fetchall():
        seen |= _seen(database, f'SELECT rowid FROM main."{table}" INDEXED BY "{index}"')
    return min(1, *seen, 1), max(seen, default=0) + (0 if backwards else _AFTER)


def _last_seq(database: sqlite3.Connection, number: int) -> int:
    query = f"SELECT seq FROM main.messages WHERE session_number={number} ORDER BY seq"
    backwards = _seen(database, f"{query} DESC")
    return max(backwards | _seen(database, query), default=0) + (0 if backwards else _AFTER)


def _seen(database: sqlite3.Connection, query: str) -> set[int]:
    """Return the smallest and the largest number that a query yields before it fails."""
    low = high = None
    with contextlib.suppress(sqlite3.DatabaseError):
        for (number,) in database.execute(query):
            low, high = (
                min(number, number if low is None else low),
                max(number, number if high is None else high),
            )
    return {number for number in (low, high) if number is not None}


def _is_damage(error: sqlite3.DatabaseError) -> bool:
    return getattr(error, "sqlite_errorcode", 0) & 0xFF in (
        sqlite3.SQLITE_CORRUPT,
        sqlite3.SQLITE_NOTADB,
    )


# --- what is missing

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
