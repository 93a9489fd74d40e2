"""Copies a session from one database to another, with all its rows."""

import sqlite3

from sar_tui.store import messages
from sar_tui.store.database import transaction

_APPENDED = ("records",)
"""Tables whose rows people add to later: what the target has is never replaced."""


def copy_session(
    source: sqlite3.Connection, target: sqlite3.Connection, session: str, *, adds: bool = False
) -> list[int]:
    """Copy a session with its participants and their programmes.

    What the target has of the session is replaced; if ``adds``, it is kept, as the source has only
    what followed.

    Both databases must have the present version.

    Returns:
        The numbers of messages that are damaged, which were not copied.

    Raises:
        StoreError: the target cannot be written to, or the source cannot be read; nothing was
            copied.
    """
    with transaction(target) as connection:
        for table in _tables(target, "session"):
            keeps = adds or table in _APPENDED
            if not keeps:
                connection.execute(f'DELETE FROM "{table}" WHERE session=?', (session,))
            copy_rows(source, connection, table, "session=?", session, or_ignore=keeps)
        damaged = messages.copy(source, connection, session, adds=adds)
        connection.execute("DELETE FROM sessions WHERE id=?", (session,))
        copy_rows(source, connection, "sessions", "id=?", session)
        seated = "(SELECT participant FROM seats WHERE session=?)"
        copy_rows(source, connection, "participants", f"code IN {seated}", session, or_ignore=True)
        copy_rows(
            source, connection, "programmes", f"participant IN {seated}", session, or_ignore=True
        )
    return damaged


def _tables(database: sqlite3.Connection, column: str) -> list[str]:
    """Return the tables that have a column, in order of their creation."""
    tables = database.execute(
        "SELECT name FROM sqlite_master WHERE type='table' ORDER BY rowid"
    ).fetchall()
    return [name for (name,) in tables if column in _columns(database, name)]


def _columns(database: sqlite3.Connection, table: str) -> list[str]:
    return [name for _, name, *_ in database.execute(f'PRAGMA table_info("{table}")')]


def copy_rows(
    source: sqlite3.Connection,
    target: sqlite3.Connection,
    table: str,
    condition: str = "?",
    value: object = True,
    *,
    or_ignore: bool = False,
) -> None:
    """Copy the rows of a table that fulfil a condition with one value; by default all."""
    names = ", ".join(f'"{name}"' for name in _columns(source, table))
    slots = ", ".join("?" for _ in _columns(source, table))
    rows = source.execute(
        f'SELECT {names} FROM "{table}" WHERE {condition} ORDER BY rowid', (value,)
    )
    how = "INSERT OR IGNORE" if or_ignore else "INSERT"
    target.executemany(f'{how} INTO "{table}" ({names}) VALUES ({slots})', rows)
