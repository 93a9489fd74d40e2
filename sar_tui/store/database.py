"""Opens the database: private, durable, of a known version."""

import contextlib
import os
import sqlite3
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import filelock
import platformdirs
import sqlite_utils

from sar_tui.store.schema import VERSION, migrations

FILE = "sar-tui.db"
_NOT_OURS = "{path} is not a SQLite database. Move it away, or choose another --data folder."
_TEMPORARY = {
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_NOMEM,
}


class StoreError(Exception):
    """The database cannot be used; one or two clear sentences.

    ``bad_input``: it is the wrong file, not a fault. ``temporary``: it may work later, with nothing changed here.
    """

    def __init__(self, message: str, *, bad_input: bool = False, temporary: bool = False) -> None:
        super().__init__(message)
        self.bad_input = bad_input
        self.temporary = temporary


def default_folder() -> Path:
    """Where data lives unless told otherwise: ``SAR_TUI_DATA``, else the user's data folder."""
    named = os.environ.get("SAR_TUI_DATA")
    return Path(named) if named else platformdirs.user_data_path("sar-tui")


def connect(folder: Path) -> sqlite_utils.Database:
    """Open the database of a data folder, made or brought up to date if need be.

    The folder is made 0700 and the file 0600. The connection commits by itself outside of explicit
    transactions; write-ahead log, every commit synced to the disk.

    Raises:
        StoreError: not a database of ours, a newer version's, not writable, or the disk is full.
    """
    path = folder / FILE
    if folder.exists() and not folder.is_dir():
        raise StoreError(f"{folder} is a file, not a folder to keep data in.", bad_input=True)
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        _make(path)
        if os.name == "posix" and stat.S_IMODE(path.stat().st_mode) != 0o600:
            path.chmod(0o600)
    except OSError as error:
        raise _unwritable(folder, error) from error
    try:
        connection = sqlite3.connect(path, timeout=10, isolation_level=None, check_same_thread=False)
        database = sqlite_utils.Database(connection)
        with filelock.FileLock(path.with_suffix(".lock"), timeout=10, mode=0o600):
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=FULL")
            _bring_up_to_date(database, path)
    except filelock.Timeout:
        raise StoreError(f"Another program keeps {path} locked. Close it and try again.") from None
    except OSError as error:
        raise _unwritable(folder, error) from error
    except sqlite3.Error as error:
        raise explain(error, path) from error
    return database


def _make(path: Path) -> None:
    """Make the file, if there is none.

    One that is there is never opened but by SQLite: to close it would take from this program all locks that its other
    connections hold on it (POSIX), and the next program to look at it would then take away the log they write to.
    """
    with contextlib.suppress(FileExistsError):
        os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))


def _unwritable(folder: Path, error: OSError) -> StoreError:
    return StoreError(f"The data folder {folder} cannot be written to: {error.strerror}.")


def explain(error: sqlite3.Error, path: Path | str = FILE) -> StoreError:
    """What SQLite's error means, in words."""
    code = (getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF
    known = {
        sqlite3.SQLITE_FULL: f"The disk is full: {path} cannot grow. Free some space.",
        sqlite3.SQLITE_READONLY: f"{path} is read-only. Give yourself the right to write to it and to its folder.",
        sqlite3.SQLITE_CANTOPEN: f"{path} cannot be opened. Does the folder exist, and may you write to it?",
        sqlite3.SQLITE_CORRUPT: f"{path} is damaged. Restore a backup, or choose another --data folder.",
        sqlite3.SQLITE_NOTADB: _NOT_OURS.format(path=path),
        sqlite3.SQLITE_BUSY: f"Another program keeps {path} locked. Close it and try again.",
        sqlite3.SQLITE_IOERR: f"The disk refuses to write {path}.",
        sqlite3.SQLITE_NOMEM: "The memory of this machine is used up. Close other programs.",
    }
    wrong_file = code in (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT)
    return StoreError(known.get(code, f"{path}: {error}."), bad_input=wrong_file, temporary=code in _TEMPORARY)


@contextmanager
def transaction(database: sqlite_utils.Database) -> Iterator[sqlite3.Connection]:
    """All or nothing: committed and on the disk when the block ends.

    Raises:
        StoreError: the disk refuses; nothing has changed.
    """
    connection: sqlite3.Connection = database.conn
    try:
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield connection
            connection.execute("COMMIT")
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            raise
    except sqlite3.Error as error:
        raise explain(error) from error


def _bring_up_to_date(database: sqlite_utils.Database, path: Path) -> None:
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version > VERSION:
        raise StoreError(
            f"{path} was written by a newer sar-tui (data version {version}, and this one knows {VERSION}). "
            "Update sar-tui.",
            bad_input=True,
        )
    if version < VERSION:
        if version:
            _back_up(database, path, version)
        migrations.apply(database)
        database.execute(f"PRAGMA user_version={VERSION}")


def _back_up(database: sqlite_utils.Database, path: Path, version: int) -> Path:
    """Copy the file, before it is changed."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    copy = path.with_name(f"{path.stem}-v{version}-{stamp}.db")
    os.close(os.open(copy, os.O_RDWR | os.O_CREAT, 0o600))
    target = sqlite3.connect(copy)
    with target:
        database.conn.backup(target)
    target.close()
    return copy
