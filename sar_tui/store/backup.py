"""Backups of the database: a copy that is whole, on the disk, and proved to open."""

import contextlib
import os
import shutil
import sqlite3
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.files import make_private, sync_file, sync_folder, unused
from sar_tui.store.database import FILE, StoreError, connect, connect_to_read, explain
from sar_tui.store.integrity import Flaw, Progress, counts, flaws
from sar_tui.store.locks import Held, hold

_KEPT = (
    "participants",
    "sessions",
    "seats",
    "runs",
    "attempts",
    "trials",
    "messages",
    "imu_chunks",
    "programmes",
    "studies",
)
"""Tables whose rows are never deleted: a copy has at least those that there were before."""
_TOLD_EVERY = 10_000
"""Steps of SQLite from one report of the progress to the next: some milliseconds."""
FOLDER = "backups"
"""Folder of the backups, in the data folder, unless another is named."""


class Backup(NamedTuple):
    """A backup: its file, the number of its sessions, and the size of the file in bytes."""

    path: Path
    sessions: int
    bytes: int


def back_up(
    folder: Path, to: Path | None = None, progress: Progress = lambda done, of: None
) -> Backup:
    """Copy the database of a data folder, also while sessions are written to it.

    The copy has its final name only when it is complete, on the disk, and was found to be whole.

    Args:
        folder: the data folder.
        to: a folder, or the file to make.
        progress: called with the bytes that are copied, and all.

    Raises:
        StoreError: there is no database; it or the copy is damaged; the copy cannot be written, or
            its file exists.
    """
    if not (folder / FILE).exists():
        raise StoreError(f"There is no data in {folder} yet.", bad_input=True)
    path = _path(to or folder / FOLDER)
    with closing(connect_to_read(folder)) as database:
        return copy_database(database, folder, path, progress)


def copy_database(
    database: sqlite3.Connection,
    folder: Path,
    path: Path,
    progress: Progress = lambda done, of: None,
) -> Backup:
    """Copy an open database of a data folder into a file, as `back_up` does.

    Raises:
        StoreError: as `back_up`.
    """
    with _one_at_a_time(folder), _unfinished(path, folder) as copy:
        version, before = _version(database), counts(database)
        try:
            with _told(database, copy, progress):
                database.execute("VACUUM INTO ?", (str(copy),))
        except sqlite3.Error as error:
            raise explain(error, copy) from error
        sessions = _examine(copy, before, is_all=version == _version(database))
        sync_file(copy)
        _give_name(copy, path)
    return Backup(path, sessions, path.stat().st_size)


@contextmanager
def _told(database: sqlite3.Connection, copy: Path, progress: Progress) -> Iterator[None]:
    """Tell the progress of a copy while SQLite makes it. A Ctrl-C meanwhile stops it, and is raised
    as such.
    """
    (pages,), (bytes_each,) = (
        database.execute(f"PRAGMA {name}").fetchone() for name in ("page_count", "page_size")
    )
    stopped = False

    def tell() -> int:
        nonlocal stopped
        try:
            progress(copy.stat().st_size, pages * bytes_each)
        except KeyboardInterrupt:
            stopped = True
        return int(stopped)

    database.set_progress_handler(tell, _TOLD_EVERY)
    try:
        yield
    except sqlite3.Error:
        if stopped:
            raise KeyboardInterrupt from None
        raise
    finally:
        database.set_progress_handler(None, 0)


def _version(database: sqlite3.Connection) -> int:
    """Return a number that changes when another program writes to the database."""
    (version,) = database.execute("PRAGMA data_version").fetchone()
    return int(version)


@contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Hold the lock under which a data folder is copied, so that a copy's leftovers can be told
    from another copy.
    """
    try:
        lock = hold(folder, "backup", "all")
    except Held:
        raise StoreError(
            f"Another backup of {folder} is being made. Wait until it is done."
        ) from None
    except StoreError:  # the folder cannot be written to
        yield
        return
    with lock:
        yield


def _path(to: Path) -> Path:
    if to.is_dir() or not to.suffix:
        return unused(to / f"sar-tui-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.db")
    if to.exists():
        raise StoreError(
            f"{to} exists, and a backup replaces nothing. Name another file.", bad_input=True
        )
    return to


@contextmanager
def _unfinished(path: Path, folder: Path) -> Iterator[Path]:
    """Give an empty file beside a path, which only this user can read; it is removed if it is there
    afterwards.

    Those that killed backups of the data folder left there are removed, too.
    """
    prefix = f".sar-tui-{zlib.crc32(bytes(folder.resolve())):08x}-"
    try:
        make_private(path.parent)
        for left in (
            *path.parent.glob(f"{prefix}*.part"),
            *path.parent.glob(f"{prefix}*.part-journal"),
        ):
            left.unlink()
        number, name = tempfile.mkstemp(prefix=prefix, suffix=".part", dir=path.parent)
    except OSError as error:
        raise StoreError(
            f"{path.parent} cannot be written to: {error.strerror}.", bad_input=True
        ) from error
    os.close(number)
    try:
        yield Path(name)
    finally:
        for each in (Path(name), Path(f"{name}-journal")):
            with contextlib.suppress(OSError):
                each.unlink()


def _examine(copy: Path, before: dict[str, int], *, is_all: bool) -> int:
    """Return the number of sessions of a copy.

    Args:
        copy: the copy.
        before: the number of rows of each table before the copy.
        is_all: True if nothing was written meanwhile, so that the copy has neither more rows nor
            fewer.

    Raises:
        StoreError: the copy is not whole.
    """
    with closing(sqlite3.connect(f"file:{copy}?mode=ro", uri=True)) as opened:
        for (text,) in opened.execute("PRAGMA integrity_check(1)"):
            if text != "ok":
                raise StoreError(
                    f"The copy is damaged ({text}), so it was not kept. `sar-tui check` says more."
                )
        copied = counts(opened)
    for table in before if is_all else _KEPT:
        there, wanted = copied.get(table, 0), before.get(table, 0)
        if there < wanted or (is_all and there != wanted):
            raise StoreError(f"The copy lacks rows of {table}, so it was not kept. Try again.")
    return copied["sessions"]


def _give_name(copy: Path, path: Path) -> None:
    """Give a copy its final name, on the disk, unless another program has made that file
    meanwhile.
    """
    try:
        os.link(copy, path)
    except FileExistsError:
        raise StoreError(
            f"{path} exists, and a backup replaces nothing. Name another file.", bad_input=True
        ) from None
    except OSError:  # a file system without links
        copy.rename(path)
    sync_folder(path.parent)


def rehearse(backup: Path, progress: Progress = lambda done, of: None) -> list[Flaw]:
    """Restore a backup into an empty data folder, open it there as the program does, and return its
    flaws.

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
            found = list(flaws(database, progress=progress))
            listed = len(listing(database, folder))
            (stored,) = database.execute("SELECT count(*) FROM sessions").fetchone()
            if listed != stored:
                raise StoreError(
                    f"Of the {stored} sessions in {backup} only {listed} can be listed."
                )
    return found
