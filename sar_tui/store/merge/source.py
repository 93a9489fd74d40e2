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

from sar_tui.drivers.private_folder import make_private
from sar_tui.store.database import FILE, StoreError, create_file, explain, sidecars
from sar_tui.store.integrity import flaws
from sar_tui.store.locks import is_held
from sar_tui.store.merge.foreign_rules import check_foreign
from sar_tui.store.merge.tables_only import copy_tables
from sar_tui.store.rescue import rescue_files

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
