"""Repair of a damaged database: what is damaged is moved aside, and nothing is deleted."""

import contextlib
import os
import shutil
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.files import sync_file, sync_folder, unused
from sar_tui.store.backup import FOLDER, copy_database
from sar_tui.store.damaged_rows import Damage, damages
from sar_tui.store.database import (
    FILE,
    StoreError,
    connect,
    create_file,
    explain,
    open_file,
    sidecars,
)
from sar_tui.store.integrity import Flaw, changed_schema, damaged_pages, flaws
from sar_tui.store.log_examination import DERIVED, Derivation, altered
from sar_tui.store.salvage import Missing, Unread, missing_rows, open_wary, salvage
from sar_tui.store.tables import VERSION

_WAIT_S = 0.5
"""Longest wait for another program that has the database open."""


class Moved(NamedTuple):
    """Rows that were moved aside: their table, their number, and why."""

    table: str
    rows: int
    reason: str


class Repair(NamedTuple):
    """A repair.

    ``backup``: copy of the database that was made before. ``kept``: the damaged file, under its new
    name. ``unread``: rows that could not be read from that. ``aside``: database of the rows that
    were moved. ``rebuilt``: sessions whose rows were made again from their log. ``missing``: rows
    that could not be read from a damaged file, as far as others know of them. ``flaws``: those that
    remain.
    """

    backup: Path | None
    kept: Path | None
    unread: list[Unread]
    aside: Path | None
    moved: list[Moved]
    rebuilt: list[str]
    missing: list[Missing]
    flaws: list[Flaw]


def repair(folder: Path) -> Repair:
    """Repair the database of a data folder.

    If pages of its file are damaged, or its views and triggers are not the program's, all rows that
    can be read go into a new file, and the damaged one is kept. Then damaged rows, and those that
    belong to nothing, move into a database beside it. A row is written there, and on the disk,
    before it is removed here. Rows that are not as they follow from a session's log are made again
    from it, if the log is as it was recorded; those that were there move aside, too.

    Raises:
        StoreError: there is no database, another program has it open, it cannot be read at all, or
            the disk is full.
    """
    path = folder / FILE
    if not path.exists():
        raise StoreError(f"There is no data in {folder} yet.", bad_input=True)
    stamp = f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    kept, unread = _renew(path, stamp)
    connect(folder).close()  # brought up to date
    with exclusive(path) as database:
        found = [each for each in damages(database) if _count(database, each)]
        lost = missing_rows(database) if kept else []
        backup = aside = None
        moved: list[Moved] = []
        rebuilt: list[str] = []
        if found or altered(database):
            if not kept:
                (folder / FOLDER).mkdir(mode=0o700, exist_ok=True)
                backup = copy_database(
                    database, folder, unused(folder / FOLDER / f"sar-tui-{stamp}.db")
                ).path
            aside = unused(folder / f"sar-tui-aside-{stamp}.db")
            moved = _move_aside(database, aside)
            rebuilt = altered(database)
            moved += _rebuild(database, aside, rebuilt)
        missing = [
            each for each in lost if each.session not in rebuilt or each.table not in DERIVED
        ]
        return Repair(backup, kept, unread, aside, moved, rebuilt, missing, list(flaws(database)))


@contextmanager
def readable(path: Path) -> Iterator[tuple[sqlite3.Connection, list[Missing]]]:
    """Open a database; or a copy of all that can be read of it if it is damaged, with what is
    missing.

    Raises:
        StoreError: nothing can be read, or the copy cannot be written.
    """
    try:
        with closing(open_file(path)) as database:
            if not any(damaged_pages(database)):
                yield database, []
                return
    except StoreError as error:
        if not error.unreadable:
            raise
    new = path.with_name(f".{path.stem}-salvaged.part")
    try:
        with _readable(path) as damaged:
            _remove(new)
            create_file(new)
            salvage(damaged, path, new)
        with closing(open_file(new)) as database:
            yield database, missing_rows(database)
    finally:
        _remove(new)


@contextmanager
def _readable(path: Path) -> Iterator[sqlite3.Connection]:
    """Open a database that may be damaged; of a file that was cut short a copy, as SQLite would
    write to it.
    """
    if not _is_cut_short(path):
        with exclusive(path, open_wary) as database:
            yield database
        return
    copy = path.with_name(f".{path.stem}-readable.part")
    try:
        _remove(copy)
        create_file(copy)
        shutil.copyfile(path, copy)
        with exclusive(copy, open_wary) as database:
            yield database
    finally:
        _remove(copy)


def _is_cut_short(path: Path) -> bool:
    """Return True if a file has less pages than its header says
    (https://www.sqlite.org/fileformat.html).
    """
    log, _ = sidecars(path)
    if log.exists() and log.stat().st_size:  # it may hold the pages that are missing
        return False
    with path.open("rb") as file:
        header = file.read(_HEADER)
    page_size = int.from_bytes(header[16:18], "big")
    page_size = 65536 if page_size == 1 else page_size
    return path.stat().st_size < page_size * int.from_bytes(header[28:32], "big")


_HEADER = 100
"""Bytes of the header."""


Open = Callable[[Path, float], sqlite3.Connection]


def _open(path: Path, timeout: float) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=timeout, isolation_level=None)


@contextmanager
def exclusive(path: Path, open_file: Open = _open) -> Iterator[sqlite3.Connection]:
    """Open a database that no other program has open, nor can open meanwhile."""
    with closing(open_file(path, _WAIT_S)) as database:
        try:
            database.execute("PRAGMA locking_mode=EXCLUSIVE")
            database.execute("BEGIN EXCLUSIVE")
            database.execute("COMMIT")
            database.execute("PRAGMA synchronous=FULL")
        except sqlite3.Error as error:
            if (found := explain(error, path)).locked:
                raise StoreError(
                    f"Another program has {path} open. End all sessions, close sar-tui "
                    "everywhere, and try again.",
                    temporary=True,
                    locked=True,
                ) from error
            raise found from error
        try:
            yield database
        except sqlite3.Error as error:
            raise explain(error, path) from error


# --- damaged pages


def _renew(path: Path, stamp: str) -> tuple[Path | None, list[Unread]]:
    """Put a new file in place of one whose pages are damaged; return the damaged one, and what it
    did not yield.
    """
    new = path.with_name(f".{path.stem}-salvaged.part")
    try:
        with _readable(path) as database:
            is_whole = not any(damaged_pages(database)) and not any(changed_schema(database))
            if is_whole and not _is_cut_short(path):
                return None, []
            _remove(new)
            create_file(new)
            unread = salvage(database, path, new)
            _check_new(new)
        sync_file(new)
        kept = _keep(path, unused(path.with_name(f"{path.stem}-damaged-{stamp}.db")))
        new.replace(path)
        sync_folder(path.parent)
    except OSError as error:
        raise StoreError(
            f"{path.parent} cannot be written to: {error.strerror}.", temporary=True
        ) from error
    finally:
        _remove(new)
    return kept, unread


def _check_new(new: Path) -> None:
    with closing(sqlite3.connect(new)) as opened:
        (state,) = opened.execute("PRAGMA integrity_check(1)").fetchone()
        (version,) = opened.execute("PRAGMA user_version").fetchone()
    if state != "ok" or version > VERSION:
        raise StoreError(
            f"What can be read makes no database ({state}). Nothing was changed: restore a backup."
        )


def _keep(path: Path, kept: Path) -> Path:
    """Give a closed database a second name, together with its log if that could not be written into
    it.
    """
    log, shared = sidecars(path)
    kept_log, _ = sidecars(kept)
    _link(path, kept)
    if log.exists():
        if log.stat().st_size:
            _link(log, kept_log)
        sync_folder(path.parent)
        log.unlink()  # would be written into the new file
    with contextlib.suppress(FileNotFoundError):
        shared.unlink()
    return kept


def _link(path: Path, other: Path) -> None:
    try:
        os.link(path, other)
    except OSError:  # a file system without links
        create_file(other)
        shutil.copyfile(path, other)
        sync_file(other)


def _remove(new: Path) -> None:
    for each in (new, new.with_name(f"{new.name}-journal"), *sidecars(new)):
        with contextlib.suppress(OSError):
            each.unlink()


# --- damaged rows


def _count(database: sqlite3.Connection, damage: Damage) -> int:
    (count,) = database.execute(
        f"SELECT count(*) FROM main.{damage.table} WHERE {damage.condition}"
    ).fetchone()
    return int(count)


def _move_aside(database: sqlite3.Connection, aside: Path) -> list[Moved]:
    """Move damaged rows into a new database, again until no row belongs to one that was moved."""
    create_file(aside)
    database.execute("ATTACH ? AS aside", (str(aside),))
    moved: list[Moved] = []
    try:
        while round_ := [each for damage in damages(database) if (each := _move(database, damage))]:
            moved += round_
    finally:
        if not database.in_transaction:
            database.execute("DETACH aside")
    return moved


def _move(database: sqlite3.Connection, damage: Damage) -> Moved | None:
    """Move rows. Killed in between, they are in both databases."""
    if not _count(database, damage):
        return None
    with _transaction(database):
        written = _copy_aside(database, damage.table, damage.condition, (), damage.reason)
    with _transaction(database):
        removed = database.execute(
            f"DELETE FROM main.{damage.table} WHERE {damage.condition}"
        ).rowcount
        if removed != written:
            raise StoreError(f"{damage.table} changed during the repair. Try again.")
    return Moved(damage.table, written, damage.reason)


def _rebuild(database: sqlite3.Connection, aside: Path, sessions: Sequence[str]) -> list[Moved]:
    """Make the rows of sessions again from their logs, and move those that were there aside."""
    moved = Counter[str]()
    database.execute("ATTACH ? AS aside", (str(aside),))
    try:
        with closing(Derivation(database)) as derivation:
            for session in sessions:
                derivation.derive(session)
                with _transaction(database):
                    for table in DERIVED:
                        moved[table] += _copy_aside(
                            database, table, "session=?", (session,), _NOT_OF_LOG
                        )
                with _transaction(database):
                    derivation.rebuild(session)
    finally:
        if not database.in_transaction:
            database.execute("DETACH aside")
    return [Moved(table, count, _NOT_OF_LOG) for table, count in moved.items() if count]


_NOT_OF_LOG = "rows of a session that did not follow from its log"


def _copy_aside(
    database: sqlite3.Connection, table: str, condition: str, values: tuple[object, ...], why: str
) -> int:
    """Copy rows into the database beside this one, in a transaction of the caller, and return their
    number.
    """
    database.execute(
        f"CREATE TABLE IF NOT EXISTS aside.{table} AS SELECT *, '' AS why FROM main.{table} WHERE 0"
    )
    return database.execute(
        f"INSERT INTO aside.{table} SELECT *, ? FROM main.{table} WHERE {condition}", (why, *values)
    ).rowcount


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[None]:
    database.execute("BEGIN")
    try:
        yield
        database.execute("COMMIT")
    except BaseException:
        if database.in_transaction:
            database.execute("ROLLBACK")
        raise
