"""Tables and columns of the database, as SQLite tells them."""

import sqlite3

_APART = ("records",)
"""Tables with a session that are not part of its record: rows that people add later."""


def columns(db: sqlite3.Connection, table: str) -> list[str]:
    """Return the columns of a table."""
    return [name for _, name, *_ in db.execute(f'PRAGMA main.table_info("{table}")')]


def keys(db: sqlite3.Connection, table: str) -> list[str]:
    """Return the columns of a table's primary key; none if it has no key of its own."""
    found = db.execute(f'PRAGMA main.table_info("{table}")').fetchall()
    return [name for _, name, *_, part in sorted(found, key=lambda column: column[-1]) if part]


def session_tables(db: sqlite3.Connection) -> list[str]:
    """Return the tables whose rows belong to the record of a session, beside ``sessions`` and
    ``messages``.
    """
    tables = db.execute(
        "SELECT name FROM main.sqlite_master WHERE type='table' ORDER BY rowid"
    ).fetchall()
    return [name for (name,) in tables if name not in _APART and "session" in columns(db, name)]
