"""Keeps a live session safe outside the database: a rescue file if need be, and a note of what was
saved, which reveals a damaged or deleted log.
"""

import contextlib
import os
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import msgspec

from sar_tui.drivers.files import make_private
from sar_tui.loop.bus import Record
from sar_tui.model.messages import TrialEnded
from sar_tui.store import messages
from sar_tui.store.database import SAVED, Moved, StoreConnection, StoreError
from sar_tui.store.locks import is_held
from sar_tui.store.rescue import Rescue, remove, rescue_files

MOST_MOVES = 5
"""Number of rescue files after which the file system is taken to be one whose file numbers change
by themselves.
"""


class Safeguard:
    """Decides which database a live session is written to.

    Attributes:
        file: the rescue file in which the session goes on; None while it is written to the
            database.
        reason: why it does not go on in the database.
    """

    def __init__(self, folder: Path, session: str, database: sqlite3.Connection) -> None:
        self.file: Path | None = None
        self.reason = ""
        self._verb = "goes on"
        self._before: tuple[Path | None, str, str] = (None, "", "")
        self._is_whole = True
        self._moves = 0
        self._session = session
        self._rescue = Rescue(folder, session, database)
        self._note = LastSaved(folder, session)

    @property
    def text(self) -> str:
        """Text that says what happened to the database, and where the session goes on; empty if all
        is well.
        """
        if not self.file:
            return ""
        before = "" if self._is_whole else " What was done before that is not in it."
        return f"{self.reason} The session {self._verb} in {self.file}.{before}"

    def in_place(self, database: StoreConnection) -> StoreConnection:
        """Return the database if its files are in place; else a rescue file with all that it holds.

        Raises:
            StoreError: the rescue file cannot be written; the next call tries it again.
        """
        if self._moves == MOST_MOVES:
            return database
        try:
            database.check()
        except Moved as moved:
            self.reason = str(moved)
            return self._use(self._rescue.copy_all(database))
        return database

    def take_over(
        self, database: StoreConnection, reason: str, *, at_end: bool = False
    ) -> StoreConnection:
        """Return a rescue file with this session, because the database cannot be written to for
        ``reason``.

        Raises:
            StoreError: the rescue file cannot be written.
        """
        if self._moves == MOST_MOVES:
            raise StoreError(reason)
        taken = self._rescue.copy_session(database)
        self._before = (self.file, self.reason, self._verb)
        self.reason = reason
        self._verb = "was saved" if at_end else "goes on"
        return self._use(taken)

    def _use(self, database: StoreConnection) -> StoreConnection:
        self._moves += 1
        self.file = database.path
        self._is_whole = self._is_whole and has_message(
            database, self._session, self._note.saved.seq
        )
        return database

    def give_up(self, database: StoreConnection) -> None:
        """Remove the rescue file that was taken last: it could not be written to either."""
        with contextlib.suppress(sqlite3.Error):
            database.close()
        if self.file:
            remove(self.file)
        self.file, self.reason, self._verb = self._before

    def saved(self, records: Sequence[Record]) -> None:
        """Note that messages are on the disk."""
        self._note.note(records)

    def close(self) -> None:
        """Close the note, which stays until the database file holds everything."""
        self._note.close()


# --- notes of what was saved
#
# SQLite ignores its write-ahead log from the first damaged byte on, and begins a new one if the log
# was deleted. After a crash nothing in the database shows that messages were lost. A note does: it
# is written after each commit, and removed when the session's messages are in the database file
# itself.


_WIDTH = 128
"""Bytes of a note: each is written over the last one in a single call."""


class Saved(msgspec.Struct, frozen=True):
    """The last message of a session that was saved, and its last trial (0: none yet)."""

    seq: int
    attempt: int = 0
    trial: int = 0


class LastSaved:
    """Writes the note of a session. If it cannot be written, the session goes on without.

    Attributes:
        saved: the last message that was saved.
    """

    def __init__(self, folder: Path, session: str) -> None:
        self._path = _path(folder, session)
        self._file = -1
        self.saved = read(self._path) or Saved(0)
        with contextlib.suppress(OSError):
            make_private(self._path.parent)
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)

    def note(self, records: Sequence[Record]) -> None:
        """Note that these messages are on the disk."""
        seq = max((record.seq for record in records if not record.topic.stream), default=0)
        if self._file < 0 or not seq:
            return
        trials = [record.message for record in records if isinstance(record.message, TrialEnded)]
        attempt, trial = (
            (trials[-1].attempt, trials[-1].trial)
            if trials
            else (self.saved.attempt, self.saved.trial)
        )
        self.saved = Saved(seq, attempt, trial)
        with contextlib.suppress(OSError):
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, msgspec.json.encode(self.saved).ljust(_WIDTH))

    def close(self) -> None:
        """Close the file. The note stays."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def has_message(database: sqlite3.Connection, session: str, seq: int) -> bool:
    """Return True if a database has a message of a session; there is no message 0."""
    found = database.execute(
        "SELECT 1 FROM events WHERE session=? AND seq=?", (session, seq)
    ).fetchone()
    return seq == 0 or found is not None


def read(path: Path) -> Saved | None:
    """Return a note, or None if there is none that can be read."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=Saved)
    except (OSError, msgspec.MsgspecError):
        return None


class Loss(msgspec.Struct, frozen=True):
    """A session whose last messages were saved, and are not in the database.

    ``kept``: the last message that is in the database; None if the session is gone altogether.
    """

    session: str
    saved: Saved
    kept: Saved | None
    note: Path

    def __str__(self) -> str:
        was = _place(self.saved)
        now = f"ends with {_place(self.kept)}" if self.kept else "is missing altogether"
        return (
            f"Data was lost: session {self.session} was saved up to {was}, but in the database "
            f"it {now}."
        )


def losses(database: sqlite3.Connection, folder: Path) -> list[Loss]:
    """Return the sessions of which the database lacks what was saved, and remove the notes that are
    not needed.

    Sessions under way, and those in a rescue file, are left out.
    """
    found = []
    whole = []
    for path in sorted((folder / SAVED).glob("*.json")) if (folder / SAVED).is_dir() else ():
        session, saved = path.stem, read(path)
        if saved is None or is_held(folder, "session", session) or rescue_files(folder, session):
            continue
        kept = _kept(database, session)
        if kept is None or kept.seq < saved.seq:
            found.append(Loss(session, saved, kept, path))
        else:
            whole.append(path)
    if whole and merge_log(database):
        for path in whole:
            _remove(path)
    return found


def forget(database: sqlite3.Connection, folder: Path, session: str) -> None:
    """Remove a session's note if its messages are in the database file."""
    saved, kept = read(_path(folder, session)), _kept(database, session)
    if saved and kept and kept.seq >= saved.seq and merge_log(database):
        _remove(_path(folder, session))


def merge_log(database: sqlite3.Connection) -> bool:
    """Copy the write-ahead log into the database file. Return True if the file then holds all that
    was committed.
    """
    try:
        busy, pages, copied = database.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
    except sqlite3.Error:
        return False
    return not busy and pages == copied


def _kept(database: sqlite3.Connection, session: str) -> Saved | None:
    if not database.execute("SELECT 1 FROM sessions WHERE id=?", (session,)).fetchone():
        return None
    _, seq = messages.extent(database, session)
    last = database.execute(
        "SELECT attempt, trial FROM trials WHERE session=? ORDER BY rowid DESC LIMIT 1", (session,)
    ).fetchone()
    return Saved(seq, *(last or ()))


def _place(saved: Saved) -> str:
    return (
        f"attempt {saved.attempt}, trial {saved.trial}"
        if saved.trial
        else f"message {saved.seq}, before any trial"
    )


def _path(folder: Path, session: str) -> Path:
    return folder / SAVED / f"{session}.json"


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()
