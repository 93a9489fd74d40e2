"""The database file: opened with private permissions, durable commits and the current schema."""

import contextlib
import errno
import os
import sqlite3
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from urllib.parse import quote

import msgspec
import platformdirs

from sar_tui.drivers.file_limit import largest_file
from sar_tui.drivers.files import make_private
from sar_tui.model.language import Sentence
from sar_tui.store import schema
from sar_tui.store.tables import FIRST_VERSION, VERSION, Table

FILE = "sar-tui.db"
LOCK = "sar-tui.lock"
"""Held while a database is opened, so that one program migrates it."""
RESCUE, RESCUED = "sar-tui-rescue-", "sar-tui-rescued-"
"""Beginnings of the names of rescue files: to be brought back, and those that were. See
`store.rescue`.
"""
SAVED = "saved"
"""Folder of the notes of what was saved. See `store.safeguard`."""
_LOCK_TIMEOUT_S = 10
_NOT_OURS = (
    "{path} is not a SQLite database. If it was one, restore a backup. Else move it away, or choose "
    "another --data folder."
)
UNWRITABLE = "The data folder {folder} cannot be written to: {why}."
_NOT_TEXT = "Could not decode to UTF-8"
"""Part of the message of Python's module, without an error code of SQLite, if a text is damaged."""
_LARGE_MB = 200.0
"""Size of a database from which it is announced that it is copied and brought up to date."""
_TEMPORARY = {
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_NOMEM,
}


class StoreError(Exception):
    """The database cannot be used. The message is one or two clear sentences.

    ``bad_input``: the user's input is wrong, such as the wrong file. ``temporary``: it may work
    later without a change. ``locked``: another program is writing. ``unreadable``: the file is
    damaged, or its disk is gone.
    """

    def __init__(
        self,
        message: str,
        *,
        bad_input: bool = False,
        temporary: bool = False,
        locked: bool = False,
        unreadable: bool = False,
    ) -> None:
        super().__init__(message)
        self.bad_input = bad_input
        self.temporary = temporary
        self.locked = locked
        self.unreadable = unreadable


def default_folder() -> Path:
    """Return the default data folder: ``SAR_TUI_DATA``, or else the user's data folder."""
    named = os.environ.get("SAR_TUI_DATA")
    return Path(named) if named else platformdirs.user_data_path("sar-tui")


class Moved(StoreError):
    """The database was removed, replaced or cut short while it was open: what is written to it may
    be lost.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message, temporary=True)


class StoreConnection(sqlite3.Connection):
    """A connection that notices if its files are no longer those that it opened.

    On POSIX a file can be removed or replaced while it is open. SQLite then writes on,
    successfully, to files that nobody can open again.
    """

    path: Path | None = None
    _files: tuple[tuple[Path, int, int], ...] = ()
    _size = 0

    def watch(self, path: Path) -> None:
        """Remember the identity of the database, its write-ahead log and its shared memory."""
        self.path = path
        there = [each for each in (path, *sidecars(path)) if each.exists()]
        self._files = tuple(
            (each, found.st_dev, found.st_ino) for each in there if (found := each.stat())
        )
        self._size = path.stat().st_size

    def check(self) -> None:
        """Raise Moved if a file of the database was removed, replaced or cut short."""
        for path, device, number in self._files:
            try:
                found = path.stat()
            except (FileNotFoundError, NotADirectoryError):
                raise Moved(f"{path} was removed while it was in use.") from None
            except OSError:
                continue  # the disk cannot tell now; writing reports why
            if (found.st_dev, found.st_ino) != (device, number):
                raise Moved(f"{path} was replaced by another file while it was in use.")
            if path == self.path:
                if found.st_size < self._size:
                    raise Moved(f"{path} was overwritten while it was in use.")
                self._size = found.st_size


def sidecars(path: Path) -> tuple[Path, Path]:
    """Return the paths of a database's write-ahead log and of its shared memory."""
    return path.with_name(f"{path.name}-wal"), path.with_name(f"{path.name}-shm")


def connect(folder: Path) -> StoreConnection:
    """Open the database of a data folder; create or upgrade it if necessary.

    The folder is created with mode 0700 and the file with 0600. The connection commits
    automatically outside of explicit transactions, uses a write-ahead log, and syncs every commit
    to the disk.

    Raises:
        StoreError: the file is not a sar-tui database, a newer or an unreleased version wrote it,
            it is not writable, or the disk is full.
    """
    return open_file(folder / FILE)


def commit_unsynced(database: sqlite3.Connection) -> None:
    """Let the system decide when commits reach the disk: for data that can be made again."""
    database.execute("PRAGMA synchronous=OFF")


def sync(database: sqlite3.Connection) -> None:
    """Bring all commits to the disk, and each later one at once."""
    database.execute("PRAGMA synchronous=FULL")
    database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()


def open_file(path: Path) -> StoreConnection:
    """Open a database as `connect` does, whatever its file is called."""
    folder = path.parent
    try:
        if folder.exists() and not folder.is_dir():
            raise StoreError(f"{folder} is a file, not a folder to keep data in.", bad_input=True)
        make_private(folder)
        create_file(path)
        if os.name == "posix" and stat.S_IMODE(path.stat().st_mode) != 0o600:
            path.chmod(0o600)
    except OSError as error:
        raise _unwritable(folder, error) from error
    try:
        database = sqlite3.connect(
            path, timeout=10, isolation_level=None, check_same_thread=False, factory=StoreConnection
        )
    except sqlite3.Error as error:
        raise explain(error, path) from error
    try:
        _prepare(database, path)
    except BaseException:
        database.close()
        raise
    return database


def _prepare(database: StoreConnection, path: Path) -> None:
    """Bring an open database up to date, and set how it is written to. Raises StoreError."""
    try:
        if version_of(database, path) == VERSION:
            database.execute("PRAGMA journal_mode=WAL")
        else:
            with _alone(path):
                _bring_up_to_date(database, path)
        database.execute("PRAGMA synchronous=FULL")
        database.watch(path)
    except OSError as error:
        raise _unwritable(path.parent, error) from error
    except sqlite3.Error as error:
        raise explain(error, path) from error
    except UnicodeDecodeError as error:  # SQLite's words about a damaged schema, which quote it
        raise damaged(path) from error


def connect_to_read(folder: Path) -> sqlite3.Connection:
    """Open the database of a data folder to read it, also where nothing can be written, such as on
    an archive.

    Raises:
        StoreError: as `connect`; or nothing can be written, and the database must first be migrated
            or recovered.
    """
    try:
        return connect(folder)
    except StoreError as refused:
        if refused.bad_input or not (database := _open_read_only(folder / FILE)):
            raise
    if (version := version_of(database, folder / FILE)) != VERSION:
        database.close()
        raise StoreError(
            f"{folder} cannot be written to, and its data is of another version of sar-tui (data "
            f"version {version}, "
            f"and this one reads {VERSION}). Copy it to a folder that can be written to, and name "
            "that with --data."
        )
    return database


def connect_unchanged(folder: Path) -> sqlite3.Connection:
    """Open the database of another data folder to read it, and write nothing there.

    Raises:
        StoreError: there is none, it cannot be read, or its data is of another version.
    """
    path = folder / FILE
    database = _open_read_only(path) if path.is_file() else None
    if database is None:
        raise StoreError(f"{folder} has no database that can be read.", bad_input=True)
    if (version := version_of(database, path)) != VERSION:
        database.close()
        raise StoreError(
            f"The data in {folder} is of another version of sar-tui (data version {version}, and "
            f"this one reads {VERSION}). Let this one bring it up to date: sar-tui sessions --data "
            f"{folder}",
            bad_input=True,
        )
    return database


def _open_read_only(path: Path) -> sqlite3.Connection | None:
    """Open a database whose folder cannot be written to; None if it cannot be read either."""
    log, _ = sidecars(path)
    try:
        is_complete = not log.exists() or log.stat().st_size == 0
    except OSError:
        return None
    for option in ("mode=ro", "immutable=1") if is_complete else ("mode=ro",):
        try:
            database = sqlite3.connect(
                f"file:{quote(str(path.absolute()))}?{option}", uri=True, isolation_level=None
            )
            database.execute("SELECT 1 FROM sessions LIMIT 1").fetchone()
        except (sqlite3.Error, UnicodeDecodeError):
            continue
        return database
    return None


def create_file(path: Path) -> None:
    """Create the file with mode 0600 unless it exists.

    Only SQLite may open an existing file: closing it would release all locks that other connections
    of this process hold on it (POSIX), and another program could then remove the write-ahead log
    they write to.
    """
    with contextlib.suppress(FileExistsError):
        os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))


def _unwritable(folder: Path, error: OSError) -> StoreError:
    if error.errno == errno.ENAMETOOLONG:
        text = "{folder} is too long for the name of a file or folder."
        return StoreError(Sentence(text, folder=str(folder)), bad_input=True)
    return StoreError(Sentence(UNWRITABLE, folder=str(folder), why=error.strerror))


def is_not_text(error: sqlite3.Error | sqlite3.Warning) -> bool:
    """Return True if an error says that a text is damaged: its bytes are not UTF-8."""
    return _NOT_TEXT in str(error)


_KNOWN = {
    sqlite3.SQLITE_FULL: "The disk is full: {path} cannot grow. Free some space.",
    sqlite3.SQLITE_READONLY: "{path} is read-only. Change the permissions of the file, of its "
    "folder, and of {path}-wal and {path}-shm, which another user may have left.",
    sqlite3.SQLITE_CANTOPEN: "{path} cannot be opened. Does the folder exist, and may you write to "
    "it?",
    sqlite3.SQLITE_NOTADB: _NOT_OURS,
    sqlite3.SQLITE_BUSY: "Another program keeps {path} locked. Close it and try again.",
    sqlite3.SQLITE_IOERR: "The disk cannot write {path}.",
    sqlite3.SQLITE_NOMEM: "This machine has no memory left. Close other programs.",
}
_LIMITED = (
    "The disk cannot write {path}. This login may write no file larger than {limit} bytes "
    "(ulimit -f)."
)


def explain(error: sqlite3.Error, path: Path | str = FILE) -> StoreError:
    """Return an error of SQLite as a StoreError with a clear message."""
    code = (getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF
    if code == sqlite3.SQLITE_CORRUPT or is_not_text(error):
        return damaged(path)
    limit = largest_file()
    text = _LIMITED if code == sqlite3.SQLITE_IOERR and limit is not None else _KNOWN.get(code, "")
    wrong_file = code == sqlite3.SQLITE_NOTADB
    return StoreError(
        Sentence(
            text or "{path}: {error}.",
            path=str(path),
            error=str(error),
            limit=f"{limit:,}" if limit else "",
        ),
        bad_input=wrong_file,
        temporary=code in _TEMPORARY,
        locked=code == sqlite3.SQLITE_BUSY,
        unreadable=wrong_file or code in (sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN),
    )


def damaged(path: Path | str = FILE) -> StoreError:
    """Return the error of a database whose bytes have changed."""
    said = Sentence(
        "{path} is damaged. Restore a backup, save what can be read (`sar-tui check --repair`), "
        "or choose another --data folder.",
        path=str(path),
    )
    return StoreError(said, bad_input=True, unreadable=True)


def read_json(text: str) -> Any:
    """Return the value of a JSON column. Raises StoreError if it is no JSON: a byte of the file has
    changed.
    """
    try:
        return msgspec.json.decode(text)
    except (msgspec.DecodeError, TypeError) as error:
        raise damaged() from error


def store(connection: sqlite3.Connection, table: Table, **values: Any) -> None:
    """Store a row of some columns, in a transaction of the caller; values of JSON columns are
    encoded.
    """
    row = [
        msgspec.json.encode(value).decode() if table[name].type == "json" else value
        for name, value in values.items()
    ]
    connection.execute(table.insert(*values), row)


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[sqlite3.Connection]:
    """Run a block as one transaction, committed and on the disk when the block ends.

    Raises:
        Moved: the files of the database were removed or replaced; nothing has changed.
        StoreError: the disk cannot write; nothing has changed.
    """
    if isinstance(database, StoreConnection):
        database.check()
    try:
        database.execute("BEGIN IMMEDIATE")
        try:
            yield database
            database.execute("COMMIT")
        except BaseException:
            if database.in_transaction:
                database.execute("ROLLBACK")
            raise
    except sqlite3.Error as error:
        raise explain(error) from error


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold the lock under which one program at a time creates or migrates the database."""
    import filelock

    try:
        with filelock.FileLock(path.with_name(LOCK), timeout=_LOCK_TIMEOUT_S, mode=0o600):
            yield
    except filelock.Timeout:
        raise StoreError(f"Another program keeps {path} locked. Close it and try again.") from None


def version_of(database: sqlite3.Connection, path: Path, schema: str = "main") -> int:
    """Return the version of a database's data; 0 if it is empty, or of another program.

    Raises:
        StoreError: a newer program, or an unreleased one, wrote it.
    """
    (version,) = database.execute(f"PRAGMA {schema}.user_version").fetchone()
    if version > VERSION:
        raise StoreError(
            f"{path} was written by a newer sar-tui (data version {version}, and this one knows "
            f"{VERSION}). "
            "Update sar-tui.",
            bad_input=True,
        )
    if 0 < version < FIRST_VERSION:
        raise unreleased(path)
    return int(version)


def unreleased(path: Path) -> StoreError:
    """Return the error of a database that a version of the program before the first release wrote."""
    return StoreError(
        f"{path} was written by a sar-tui before 0.2.0, the first release: export it with the "
        "version that wrote it (`sar-tui export --to FOLDER`), and keep new data in another "
        "folder (--data).",
        bad_input=True,
    )


def _bring_up_to_date(database: sqlite3.Connection, path: Path) -> None:
    """Create or upgrade the tables, unless another program has done so meanwhile."""
    version = version_of(database, path)
    if not version and database.execute("SELECT 1 FROM sqlite_master LIMIT 1").fetchone():
        raise StoreError(
            f"{path} is a database of another program. Choose another --data folder.",
            bad_input=True,
        )
    if 0 < version < VERSION:
        _announce(path)
        _back_up(database, path, version)
    database.execute("PRAGMA journal_mode=WAL")
    if not version:
        schema.create(database)
    elif version < VERSION:
        schema.upgrade(database, version)


def _announce(path: Path) -> None:
    """Say what takes a moment if a large file is brought up to date."""
    megabytes = path.stat().st_size / 1e6
    if megabytes > _LARGE_MB:
        print(
            f"{path} ({megabytes:.0f} MB) is brought up to date for this version of sar-tui. A "
            "copy of it is kept.",
            file=sys.stderr,
            flush=True,
        )


def _back_up(database: sqlite3.Connection, path: Path, version: int) -> Path:
    """Copy the file before an upgrade, and return the copy."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    copy = path.with_name(f"{path.stem}-v{version}-{stamp}.db")
    os.close(os.open(copy, os.O_RDWR | os.O_CREAT, 0o600))
    target = sqlite3.connect(copy)
    with target:
        database.backup(target)
    target.close()
    return copy
