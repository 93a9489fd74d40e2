"""Keeps a live session safe outside the database: a note of what was saved, and a rescue file if
need be.
"""

import contextlib
import sqlite3
from collections.abc import Sequence
from pathlib import Path

from sar_tui.loop.bus import Record
from sar_tui.store.database import Moved, StoreConnection, StoreError
from sar_tui.store.last_saved import LastSaved, has_message
from sar_tui.store.rescue import Rescue, remove

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
