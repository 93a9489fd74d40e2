"""Backups of the database: a copy that is whole, on the disk, and proved to open."""

import contextlib
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.private_folder import make_private
from sar_tui.store.database import FILE, StoreError, connect, connect_to_read, explain
from sar_tui.store.integrity import Flaw, counts, flaws

_KEPT = ("participants", "sessions", "seats", "runs", "attempts", "trials", "messages", "imu_chunks", "programmes")
"""Tables whose rows are never deleted: a copy has at least those that there were before."""
FOLDER = "backups"
"""Folder of the backups, in the data folder, unless another is named."""


class Backup(NamedTuple):
    """A backup: its file, the number of its sessions, and the size of the file in bytes."""

    path: Path
    sessions: int
    bytes: int


def back_up(folder: Path, to: Path | None = None) -> Backup:
    """Copy the database of a data folder, also while sessions are written to it.

    The copy has its final name only when it is complete, on the disk, and was found to be whole.

    Args:
        folder: the data folder.
        to: a folder, or the file to make.

    Raises:
        StoreError: there is no database; it or the copy is damaged; the copy cannot be written, or its file exists.
    """
    if not (folder / FILE).exists():
        raise StoreError(f"There is no data in {folder} yet.", bad_input=True)
    path = _path(to or folder / FOLDER)
    with closing(connect_to_read(folder)) as database, _unfinished(path) as copy:
        before = counts(database)
        try:
            database.execute("VACUUM INTO ?", (str(copy),))
        except sqlite3.Error as error:
            raise explain(error, copy) from error
        sessions = _examine(copy, before)
        _sync(copy)
        _give_name(copy, path)
    return Backup(path, sessions, path.stat().st_size)


def _path(to: Path) -> Path:
    name = f"sar-tui-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.db"
    path = to / name if to.is_dir() or not to.suffix else to
    if path.exists():
        raise StoreError(f"{path} exists, and a backup replaces nothing. Name another file.", bad_input=True)
    return path


@contextmanager
def _unfinished(path: Path) -> Iterator[Path]:
    """Give an empty file beside a path, which only this user can read; it is removed if it is there afterwards."""
    try:
        make_private(path.parent)
        number, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=".part", dir=path.parent)
    except OSError as error:
        raise StoreError(f"{path.parent} cannot be written to: {error.strerror}.", bad_input=True) from error
    os.close(number)
    try:
        yield Path(name)
    finally:
        with contextlib.suppress(OSError):
            Path(name).unlink()


def _examine(copy: Path, before: dict[str, int]) -> int:
    """Return the number of sessions of a copy. Raises StoreError if it is not whole, or has fewer rows than before."""
    with closing(sqlite3.connect(f"file:{copy}?mode=ro", uri=True)) as opened:
        for (text,) in opened.execute("PRAGMA integrity_check(1)"):
            if text != "ok":
                raise StoreError(f"The copy is damaged ({text}), so it was not kept. `sar-tui check` says more.")
        copied = counts(opened)
    for table in _KEPT:
        if copied.get(table, 0) < before.get(table, 0):
            raise StoreError(f"The copy lacks rows of {table}, so it was not kept. Try again.")
    return copied["sessions"]


def _sync(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _give_name(copy: Path, path: Path) -> None:
    """Give a copy its final name, on the disk, unless another program has made that file meanwhile."""
    try:
        os.link(copy, path)
    except FileExistsError:
        raise StoreError(f"{path} exists, and a backup replaces nothing. Name another file.", bad_input=True) from None
    except OSError:  # a file system without links
        copy.rename(path)
    if os.name == "posix":
        number = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def rehearse(backup: Path) -> list[Flaw]:
    """Restore a backup into an empty data folder, open it there as the program does, and return its flaws.

    The folder is removed afterwards; the backup is only read.

    Raises:
        StoreError: it cannot be restored or opened, or its sessions cannot be listed.
    """
    from sar_tui.store.sessions import listing

    with tempfile.TemporaryDirectory(prefix="sar-tui-restore-") as place:
        folder = Path(place)
        try:
            shutil.copyfile(backup, folder / FILE)
        except OSError as error:
            raise StoreError(f"{backup} cannot be restored: {error.strerror}.") from error
        with closing(connect(folder)) as database:
            found = list(flaws(database))
            listed = len(listing(database, folder))
            (stored,) = database.execute("SELECT count(*) FROM sessions").fetchone()
            if listed != stored:
                raise StoreError(f"Of the {stored} sessions in {backup} only {listed} can be listed.")
    return found
