"""The other database: a private copy of it, of the present version, that was found to be whole."""

import contextlib
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from sar_tui.drivers.files import make_private
from sar_tui.store import schema
from sar_tui.store.database import (
    FILE,
    StoreError,
    create_file,
    explain,
    sidecars,
    version_of,
)
from sar_tui.store.integrity import damaged_pages, flaws
from sar_tui.store.locks import is_held
from sar_tui.store.merge.foreign_values import check_foreign
from sar_tui.store.rescue import rescue_files
from sar_tui.store.tables import TABLES, Table

_PAGES = 2000
"""Pages that are copied at once."""


class Source(NamedTuple):
    """A copy of another database.

    ``running``: sessions that a program writes to now. ``rescue_files``: hold what the database
    lacks.
    """

    copy: Path
    running: tuple[str, ...]
    rescue_files: tuple[Path, ...]


@contextmanager
def copied(other: Path, folder: Path, progress: Callable[[int, int], None]) -> Iterator[Source]:
    """Copy a database into a folder of its own in a data folder, and remove the copy afterwards.

    The other database is only read.

    Args:
        other: its file, or its data folder.
        folder: the data folder, as large as need be.
        progress: called with what is copied and what there is, in pages.

    Raises:
        StoreError: it cannot be read, is damaged, or is no database of sar-tui.
    """
    path = other / FILE if other.is_dir() else other
    if not path.is_file():
        raise StoreError(f"There is no database {path}.", bad_input=True)
    if (folder / FILE).exists() and path.samefile(folder / FILE):
        raise StoreError(f"{path} is this database itself.", bad_input=True)
    make_private(folder)
    beside = path.parent if path.name == FILE else None
    with tempfile.TemporaryDirectory(prefix=PREFIX, dir=folder) as place:
        original, copy = Path(place) / _ORIGINAL, Path(place) / FILE
        try:
            _copy(path, original, progress)
            running = _prepare(path, original, copy, beside)
        except sqlite3.Error as error:
            raise _unusable(error, path, folder) from error
        except UnicodeDecodeError as error:
            raise _damaged(path) from error
        yield Source(copy, running, tuple(rescue_files(beside)) if beside else ())


_ORIGINAL = "original.db"
PREFIX = ".merge-"
"""Beginning of the name of the folder with the copy. One that is there without a merge is of a
program that ended.
"""


def _copy(path: Path, copy: Path, progress: Callable[[int, int], None]) -> None:
    create_file(copy)
    log, memory = sidecars(path)
    # nobody has it open; SQLite would make files beside it
    if log.exists() and not memory.exists():
        shutil.copyfile(path, copy)
        shutil.copyfile(log, sidecars(copy)[0])
        return
    option = "mode=ro" if log.exists() else "immutable=1"
    with (
        closing(
            sqlite3.connect(f"file:{quote(str(path.absolute()))}?{option}", uri=True)
        ) as source,
        closing(sqlite3.connect(copy)) as target,
    ):
        source.backup(
            target,
            pages=_PAGES,
            progress=lambda _, remaining, total: progress(total - remaining, total),
        )


def _prepare(path: Path, original: Path, copy: Path, beside: Path | None) -> tuple[str, ...]:
    """Copy the tables into a database of the present version, and return its sessions that run
    now.
    """
    create_file(copy)
    with closing(sqlite3.connect(original, isolation_level=None)) as database:
        database.execute("PRAGMA trusted_schema=OFF")
        # what a log beside it holds is in the file then
        database.execute("PRAGMA journal_mode=DELETE")
    copy_tables(original, copy, path)
    original.unlink()
    with closing(sqlite3.connect(copy, isolation_level=None)) as database:
        for flaw in flaws(database, gaps=False):  # what is missing there is missing here, too
            where = f" ({flaw.where})" if flaw.where else ""
            raise StoreError(
                f"{path} is damaged{where}, and nothing was merged: {flaw.what}", bad_input=True
            )
        check_foreign(database, path)
        stored = database.execute("SELECT id FROM sessions WHERE status='running'").fetchall()
    has_locks = beside is not None and (beside / "locks").is_dir()
    return tuple(id for (id,) in stored if has_locks and beside and is_held(beside, "session", id))


def _unusable(error: sqlite3.Error, path: Path, folder: Path) -> StoreError:
    code = (getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF
    if code == sqlite3.SQLITE_NOTADB:
        return StoreError(f"{path} is no database of sar-tui.", bad_input=True)
    if code == sqlite3.SQLITE_CORRUPT:
        return _damaged(path)
    return explain(error, folder if code == sqlite3.SQLITE_FULL else path)


def _damaged(path: Path) -> StoreError:
    return StoreError(f"{path} is damaged, and nothing was merged.", bad_input=True)


def remove_leftovers(folder: Path) -> None:
    """Remove copies that a merge left which was killed. Only while no other merge goes on."""
    for left in folder.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            shutil.rmtree(left)


# --- the rows of its tables, and nothing else of it


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
        schema.create(database)
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
