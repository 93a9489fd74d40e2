"""A database of this program's own making that holds the rows of another's tables, and nothing else
of that one.

Views, triggers, indexes and constraints of a database from elsewhere are programs: a view in place
of a table can make a query endless, and a trigger can change what is read. None of them is in the
copy.
"""

import sqlite3
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from sar_tui.store.database import StoreError, create_tables, version_of
from sar_tui.store.integrity import damaged_pages
from sar_tui.store.tables import TABLES, Table

_ORDINARY = 0
"""A column that is stored; others are computed when they are read."""


def copy_tables(source: Path, copy: Path, path: Path) -> None:
    """Copy the rows of a database into an empty file, of the present version.

    Args:
        source: a private copy of the file, which is only read.
        path: the file of which it is a copy, for messages.

    Raises:
        StoreError: it is no database of this program, is damaged, or something else stands in place
            of a table.
        sqlite3.Error: it cannot be read.
    """
    with closing(
        sqlite3.connect(f"file:{quote(str(copy))}", uri=True, isolation_level=None)
    ) as database:
        for setting in ("journal_mode=OFF", "synchronous=OFF"):
            database.execute(f"PRAGMA {setting}")
        database.execute("ATTACH ? AS source", (f"file:{quote(str(source))}?mode=ro&immutable=1",))
        version = version_of(database, path, "source")
        if not version or not _kind(database, "sessions"):
            raise StoreError(f"{path} is no database of sar-tui.", bad_input=True)
        create_tables(database)
        for setting in _WARY:
            database.execute(f"PRAGMA {setting}")
        columns = {
            table.name: _columns(database, table, version, path)
            for table in TABLES.values()
            if table.since <= version
        }
        for flaw in damaged_pages(database, "source"):
            raise StoreError(
                f"{path} is damaged, and nothing was merged: {flaw.what}", bad_input=True
            )
        database.execute("BEGIN")
        for table, names in columns.items():
            listed = ", ".join(f'"{name}"' for name in names)
            database.execute(f'DELETE FROM main."{table}"')  # a new database has a topic
            database.execute(
                f'INSERT INTO main."{table}" ({listed}) SELECT {listed} FROM source."{table}"'
            )
        database.execute("COMMIT")
        database.execute("DETACH source")


_WARY = ("trusted_schema=OFF", "ignore_check_constraints=ON")
"""Settings of SQLite while the other file is read: its schema calls no function, and its tables
have no conditions.
"""


def _kind(database: sqlite3.Connection, name: str) -> str:
    """Return the kind of the other database's object of a name: table, view, virtual; empty if
    there is none.
    """
    row = database.execute(
        "SELECT type, rootpage FROM source.sqlite_master WHERE lower(name)=? AND type IN "
        "('table', 'view')",
        (name,),
    ).fetchone()
    if row is None:
        return ""
    return "virtual table" if row == ("table", 0) else str(row[0])


def _columns(database: sqlite3.Connection, declared: Table, version: int, path: Path) -> list[str]:
    """Return the columns to copy, with the number of the row if the table has one. Raises
    StoreError.
    """
    table = declared.name
    kind = _kind(database, table)
    if kind != "table":
        what = f"a {kind} stands in place of the table" if kind else "it lacks the table"
        raise StoreError(f"{path} cannot be merged: {what} {table}.", bad_input=True)
    names = [column.name for column in declared.columns if column.since <= version]
    there = {
        name: hidden
        for _, name, *_, hidden in database.execute(
            f'PRAGMA source.table_xinfo("{table}")'
        ).fetchall()
    }
    for name in names:
        if there.get(name) != _ORDINARY:
            what = "is computed" if name in there else "is missing"
            raise StoreError(
                f"{path} cannot be merged: in the table {table}, {name} {what}.", bad_input=True
            )
    return [*(["rowid"] if _has_numbers(database, table) else []), *names]


def _has_numbers(database: sqlite3.Connection, table: str) -> bool:
    try:
        database.execute(f'SELECT rowid FROM main."{table}" LIMIT 0')
    except sqlite3.OperationalError:
        return False
    return True
