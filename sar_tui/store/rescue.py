"""Rescue files: databases beside the database, in which a session goes on that cannot be written
there any more.

The database may have been removed or replaced during the session, or another program may keep it
locked when the session is left. A rescue file is an ordinary database; ``bring_back`` copies its
sessions into the database.
"""

import contextlib
import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import NamedTuple, get_args

from sar_tui.drivers.files import make_private, unused
from sar_tui.store import messages, people_events, sessions, sites
from sar_tui.store.database import (
    RESCUE,
    RESCUED,
    StoreConnection,
    StoreError,
    connect,
    create_file,
    explain,
    open_file,
    sidecars,
    transaction,
)
from sar_tui.store.locks import is_held
from sar_tui.store.personal_rows import apply, with_full_codes
from sar_tui.store.repair import readable
from sar_tui.store.salvage import Missing
from sar_tui.store.tables import ADDED_LATER, TABLES, with_column

_FACTS = {
    "sessions": "id=?",
    "seats": "session=?",
    "runs": "session=?",
    "participants": "code IN (SELECT participant FROM seats WHERE session=?)",
}
"""The rows that are needed to begin a session anew, by table."""


def rescue_files(folder: Path, session: str = "") -> list[Path]:
    """Return the rescue files of a data folder, or of one of its sessions, that were not brought
    back yet.
    """
    name = re.compile(rf"{RESCUE}{session or '[0-9a-z]+'}(-[0-9]+)?\.db")
    try:
        return sorted(path for path in folder.iterdir() if name.fullmatch(path.name))
    except OSError:
        return []


class Rescue:
    """Makes the rescue file of a session.

    Args:
        folder: the data folder.
        session: the session's id.
        database: the rows of the session, its seats, runs and participants are read from here, as
            long as they can be.
    """

    def __init__(self, folder: Path, session: str, database: sqlite3.Connection) -> None:
        self._folder = folder
        self._session = session
        self._facts = sqlite3.connect(":memory:", check_same_thread=False)
        for table, condition in _FACTS.items():
            found = database.execute(f"SELECT * FROM {table} WHERE {condition}", (session,))
            names = ", ".join(name for name, *_ in found.description)
            self._facts.execute(f"CREATE TABLE {table} ({names})")
            slots = ", ".join("?" for _ in found.description)
            self._facts.executemany(f"INSERT INTO {table} VALUES ({slots})", found)

    def copy_all(self, database: StoreConnection) -> StoreConnection:
        """Copy all that an open database holds into a new rescue file, and open that.

        The files of an open database can be read even if they were removed. If they were damaged,
        only this session is copied, or what can be read of it.

        Raises:
            StoreError: the rescue file cannot be written.
        """
        with self._new_file() as path:
            try:
                self._create(path)
                with closing(sqlite3.connect(path)) as target:
                    database.backup(target)
                    (state,) = target.execute("PRAGMA quick_check(1)").fetchone()
                    if state == "ok" and self._is_in(target):
                        return open_file(path)
            except sqlite3.Error as error:
                if not (found := explain(error, path)).unreadable:
                    raise found from error
            remove(path)
            return self._copy_session(database, path)

    def copy_session(self, database: StoreConnection) -> StoreConnection:
        """Copy this session into a new rescue file, and open that.

        Raises:
            StoreError: the rescue file cannot be written.
        """
        with self._new_file() as path:
            return self._copy_session(database, path)

    def _copy_session(self, database: StoreConnection, path: Path) -> StoreConnection:
        target = open_file(path)
        try:
            try:
                copy_session(database, target, self._session)
            except StoreError as error:
                if not error.unreadable:
                    raise
            if not self._is_in(target):
                self._copy_facts(target)
        except BaseException:
            target.close()
            raise
        return target

    def _copy_facts(self, target: StoreConnection) -> None:
        with transaction(target) as connection:
            for table in _FACTS:
                copy_rows(self._facts, connection, table)

    def _create(self, path: Path) -> None:
        try:
            make_private(self._folder)
            create_file(path)
        except OSError as error:
            raise StoreError(
                f"{path} cannot be written: {error.strerror}.", temporary=True
            ) from error

    def _is_in(self, database: sqlite3.Connection) -> bool:
        return bool(
            database.execute("SELECT 1 FROM sessions WHERE id=?", (self._session,)).fetchone()
        )

    @contextlib.contextmanager
    def _new_file(self) -> Iterator[Path]:
        """Yield a path that no file has; remove the file again on failure."""
        path = unused(self._folder / f"{RESCUE}{self._session}.db")
        try:
            yield path
        except BaseException:
            remove(path)
            raise


def remove(path: Path) -> None:
    """Remove a database with its log."""
    for each in (path, *sidecars(path)):
        with contextlib.suppress(OSError):
            each.unlink()


# --- bringing back


class Waiting(NamedTuple):
    """A session that a rescue file holds, with the number of its trials there."""

    session: str
    participants: str
    task: str
    trials: int


def waiting(path: Path) -> list[Waiting]:
    """Return what a rescue file holds. Raises StoreError if it cannot be read."""
    count = "SELECT count(*) FROM trials WHERE session=?"
    with readable(path) as (source, _):
        return [
            Waiting(*row, *source.execute(count, row[:1]).fetchone()) for row in _sessions(source)
        ]


class BroughtBack(NamedTuple):
    """A session of a rescue file.

    ``problem``: why it was left there; empty if it is in the database now. ``damaged``: numbers of
    its messages that were left there, because they cannot be read. ``missing``: rows that are lost,
    by table, if the file is damaged.
    """

    file: Path
    session: str
    participants: str
    task: str
    problem: str = ""
    damaged: tuple[int, ...] = ()
    missing: tuple[tuple[str, int], ...] = ()


def bring_back(folder: Path) -> list[BroughtBack]:
    """Copy the sessions of all rescue files that the database lacks, or has less of, into the
    database.

    Of a file that is damaged, such as one that was cut short, all that can be read is brought back.
    A file of which nothing is left to bring back gets another name, and stays.

    Raises:
        StoreError: the database or a rescue file cannot be used.
    """
    found: list[BroughtBack] = []
    with closing(connect(folder)) as database:
        for path in rescue_files(folder):
            with readable(path) as (source, missing):
                here = [
                    each._replace(missing=_of_session(missing, each.session))
                    for row in _sessions(source)
                    if (each := _bring(path, row, source, database, folder))
                ]
                here += [
                    BroughtBack(path, one.session, "?", "?", "the session itself cannot be read")
                    for one in missing
                    if one.table == "sessions"
                ]
                is_whole = not any(each.problem for each in here)
                _bring_rest(source, database, _NOT_OF_SESSIONS if is_whole else ())
            found += here
            if is_whole:
                _rename(path)
    return found


def _of_session(missing: Sequence[Missing], session: str) -> tuple[tuple[str, int], ...]:
    return tuple((one.table, one.rows) for one in missing if one.session == session)


def _sessions(database: sqlite3.Connection) -> list[tuple[str, str, str]]:
    """Return id, participants and task of each session, in order."""
    texts = database.text_factory
    database.text_factory = lambda raw: raw.decode(errors="replace")
    found = database.execute(
        "SELECT id, coalesce((SELECT group_concat(participant, ', ') FROM seats WHERE "
        "session=id), '?'), task"
        " FROM sessions ORDER BY sessions.rowid"
    ).fetchall()
    database.text_factory = texts
    return found


def _bring(
    path: Path,
    row: tuple[str, str, str],
    source: sqlite3.Connection,
    database: sqlite3.Connection,
    folder: Path,
) -> BroughtBack | None:
    """Copy a session unless the database has as much of it; None if so."""
    session = row[0]
    first, last, run = _extent(source, session)
    _, there, last_run = _extent(database, session)
    is_known = database.execute("SELECT 1 FROM sessions WHERE id=?", (session,)).fetchone()
    if is_held(folder, "session", session):
        return BroughtBack(path, *row, "it is still running")
    if is_known and last <= there:
        return None
    if last_run > run:
        return BroughtBack(
            path, *row, "it was resumed in the database since, and went on differently"
        )
    if erased := _erased(source, database, session):
        return BroughtBack(
            path,
            *row,
            f"{erased} was erased, and `sar-tui participant erase {erased}` takes them out of it",
        )
    if not _is_readable(source, session):
        return BroughtBack(
            path, *row, "its rows are damaged, so that no command could read the database"
        )
    damaged = copy_session(source, database, session, adds=first > 1)
    return BroughtBack(path, *row, damaged=tuple(damaged))


def _erased(source: sqlite3.Connection, database: sqlite3.Connection, session: str) -> str:
    """Return the code of a participant of a session who was erased in the database; empty if there
    is none.
    """
    seats = source.execute("SELECT seat, participant FROM seats WHERE session=?", (session,))
    codes = dict(seats.fetchall())
    for event in people_events.events(database):
        is_of_session = (
            event.participant in codes.values() or event.details.sessions.get(session) in codes
        )
        is_replaced = event.replaced_by in codes.values()
        if event.event == "erased" and is_of_session and not is_replaced:
            return event.participant
    return ""


def _is_readable(database: sqlite3.Connection, session: str) -> bool:
    """Return True if all rows of a session can be read, beside its messages."""
    try:
        for table in get_args(sessions.Table):
            sessions.rows(database, table, session)
        seated = sessions.rows(database, "seats", session)
        return sessions.stored(database, session) is not None and bool(seated)
    except (StoreError, sqlite3.Error):
        return False


def _extent(database: sqlite3.Connection, session: str) -> tuple[int, int, int]:
    """Return the numbers of a session's first and last message and of its last run; 0 if there are
    none.
    """
    first, last = messages.extent(database, session)
    (run,) = database.execute(
        "SELECT coalesce(max(run), 0) FROM runs WHERE session=?", (session,)
    ).fetchone()
    return first, last, run


_NOT_OF_SESSIONS = (
    "site", "same_people", "people_events", "conflicts", "participants", "programmes", "records",
    "studies",
)  # fmt: skip


def _bring_rest(
    source: sqlite3.Connection, database: sqlite3.Connection, tables: Sequence[str]
) -> None:
    """Copy rows of some tables that the database lacks; and do again what was done for people's
    rights, as the file may hold what was there before.
    """
    # without it, erased rows would stay in parts of the file that are free
    database.execute("PRAGMA secure_delete=ON")
    with transaction(database) as connection:
        for table in tables:
            copy_rows(source, connection, table, or_ignore=True)
        own = sites.own(connection)
        for event in people_events.events(connection):
            apply(connection, with_full_codes(event, own))


def _rename(path: Path) -> None:
    """Give a file that was brought back the name that says so."""
    try:
        path.rename(unused(path.with_name(path.name.replace(RESCUE, RESCUED, 1))))
    except OSError as error:
        raise StoreError(
            f"{path} was brought back, but cannot be renamed: {error.strerror}."
        ) from error


# --- copies of sessions


def copy_session(
    source: sqlite3.Connection, target: sqlite3.Connection, session: str, *, adds: bool = False
) -> list[int]:
    """Copy a session with its participants and their programmes.

    What the target has of the session is replaced; if ``adds``, it is kept, as the source has only
    what followed.

    Both databases must have the present version.

    Returns:
        The numbers of messages that are damaged, which were not copied.

    Raises:
        StoreError: the target cannot be written to, or the source cannot be read; nothing was
            copied.
    """
    with transaction(target) as connection:
        for table in with_column("session"):
            keeps = adds or table in ADDED_LATER
            if not keeps:
                connection.execute(f'DELETE FROM "{table}" WHERE session=?', (session,))
            copy_rows(source, connection, table, "session=?", session, or_ignore=keeps)
        damaged = messages.copy(source, connection, session, adds=adds)
        connection.execute("DELETE FROM sessions WHERE id=?", (session,))
        copy_rows(source, connection, "sessions", "id=?", session)
        seated = "(SELECT participant FROM seats WHERE session=?)"
        copy_rows(source, connection, "participants", f"code IN {seated}", session, or_ignore=True)
        copy_rows(
            source, connection, "programmes", f"participant IN {seated}", session, or_ignore=True
        )
    return damaged


def copy_rows(
    source: sqlite3.Connection,
    target: sqlite3.Connection,
    table: str,
    condition: str = "?",
    value: object = True,
    *,
    or_ignore: bool = False,
) -> None:
    """Copy the rows of a table that fulfil a condition with one value; by default all."""
    names = ", ".join(TABLES[table].names)
    rows = source.execute(f"SELECT {names} FROM {table} WHERE {condition} ORDER BY rowid", (value,))
    how = "INSERT OR IGNORE" if or_ignore else "INSERT"
    target.executemany(TABLES[table].insert(how=how), rows)
