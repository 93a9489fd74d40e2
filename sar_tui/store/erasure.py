"""A person's data erased, or without what identifies the person: in the database, its write-ahead
log, rescue files, and the backups of the data folder. Pages on their progress are deleted there.

The event is stored with the change of the rows, in one transaction. If the command is interrupted and
given again, the free pages and the other files are looked through again.
"""

import contextlib
import mmap
import re
import secrets
import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui.store import exports, people_events, schema, sites
from sar_tui.store.backup import FOLDER as BACKUPS
from sar_tui.store.database import (
    FILE,
    SAVED,
    StoreError,
    connect,
    explain,
    sidecars,
    transaction,
    version_of,
)
from sar_tui.store.exports import LedgerEntry
from sar_tui.store.locks import hold, is_held
from sar_tui.store.merge import conflicts
from sar_tui.store.merge.people import Pair, People, in_full, rename_own, stored_pairs
from sar_tui.store.participants import check_code, check_known, check_own
from sar_tui.store.people_events import Details, PersonEvent
from sar_tui.store.personal_rows import Changed, apply, details_of, with_full_codes
from sar_tui.store.repair import exclusive
from sar_tui.store.tables import FIRST_VERSION, PEOPLE_EVENTS, TABLES, VERSION

MANIFEST = "sar-tui-export.json"
"""Name of the file in an export that names its sessions."""
_OF_FIRST_VERSION = {table.name for table in TABLES.values() if table.since <= FIRST_VERSION}
_LETTERS = "ABCDEFGHJKMNPQRSTVWXYZ23456789"
"""Characters of a random code: without those that are mistaken for others."""


class Refusal(msgspec.Struct, frozen=True):
    """A file that may hold data of the person, and could not be rewritten; why, in a sentence."""

    file: str
    why: str


class Done(msgspec.Struct, frozen=True, kw_only=True):
    """Result of an erasure or a de-identification.

    Attributes:
        event: as it is stored.
        sessions: the number of their sessions. ``shared``: of those for two, of which the part of
            the partner stays.
        rewritten: files beside the database that held the person. ``refused``: those that could not
            be rewritten. ``deleted``: pages on their progress.
        exports: those that held sessions of the person. ``folders``: of them, those that are in the
            data folder.
        speech: folders into which the agent's speech in their sessions was recorded.
    """

    event: PersonEvent
    sessions: int
    shared: int
    rewritten: list[str]
    refused: list[Refusal]
    deleted: list[str]
    exports: list[LedgerEntry]
    folders: list[str]
    speech: list[str]


def erase(
    folder: Path, code: str, *, author: str, reason: str, now: datetime | None = None
) -> Done:
    """Erase all of a participant of this site. One who was erased already is looked for again, in
    all files.

    Raises:
        StoreError: nobody has the code, they are of another site, a session of them runs, another
            program has the database open, or the disk cannot write. Nothing was erased then.
    """
    code = check_code(code)
    with closing(connect(folder)) as database:
        event = people_events.erasure(database, code)
        if event is None:
            check_known(database, check_own(code))
            event = people_events.new_event(
                "erased",
                code,
                author=author,
                reason=reason,
                replaced_by=_unused(database, "ERASED-"),
                now=now,
            )
    return _everywhere(folder, event, code)


def de_identify(
    folder: Path, code: str, *, author: str, reason: str, now: datetime | None = None
) -> Done:
    """Take out what was typed of a participant of this site, and login names, and give them a
    random code. Which one they had is noted nowhere.

    Raises:
        StoreError: as `erase`.
    """
    code = check_own(code)
    with closing(connect(folder)) as database:
        check_known(database, code)
        event = people_events.new_event(
            "de-identified",
            _unused(database, ""),
            author=author,
            reason=reason,
            now=now,
        )
    return _everywhere(folder, event, code)


def _unused(database: sqlite3.Connection, prefix: str) -> str:
    """Return a random code that nobody has."""
    while True:
        code = prefix + "".join(secrets.choice(_LETTERS) for _ in range(8))
        known = "SELECT 1 FROM participants WHERE code=:code UNION SELECT 1 FROM seats WHERE participant=:code"
        if not database.execute(known, {"code": code}).fetchone():
            return code


def _everywhere(folder: Path, event: PersonEvent, code: str) -> Done:
    with hold(folder, "participant", code), hold(folder, "merge", FILE):
        with _alone(folder / FILE) as database:
            _check_nothing_runs(database, folder, code)
            same = _same(database, code)
            before = _details(database, event, code)
            event = msgspec.structs.replace(event, details=before)
            speech = _speech(database, event)
            # once the database has another code, nothing tells the earlier one
            is_first = event.event == "de-identified"
            others = _other_files(folder, event, code, same) if is_first else None
            changed = _apply(database, event, code)
            _clean(database, folder / FILE)
            of_exports = _exports(database, event)
        rewritten, refused, deleted = others or _other_files(folder, event, code, same)
        for session in event.details.sessions if event.event == "erased" else ():
            with contextlib.suppress(OSError):
                (folder / SAVED / f"{session}.json").unlink()
    with contextlib.suppress(OSError):  # its name has the code
        (folder / "locks" / f"participant-{code}.lock").unlink()
    return Done(
        event=event,
        sessions=changed.sessions,
        shared=changed.shared,
        rewritten=rewritten,
        refused=refused,
        deleted=deleted,
        exports=of_exports,
        folders=_export_folders(folder, event),
        speech=speech,
    )


def _same(database: sqlite3.Connection, code: str) -> set[Pair]:
    """Return the pairs of codes by which a person is known."""
    own = sites.own(database)
    people = People(own, stored_pairs(database))
    group = people.group(in_full(code, own))
    return {pair for pair in people.same if group.issuperset(pair)}


def _codes(code: str, same: Collection[Pair]) -> list[str]:
    """Return all codes of a person, of other sites in full."""
    return [code, *sorted({each for pair in same for each in pair})]


# --- the database


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[sqlite3.Connection]:
    """Open a database that no other program has open, with nothing in its write-ahead log.

    Raises:
        StoreError: another program has it open: what it reads would stay in the log.
    """
    with exclusive(path) as database:
        _empty_log(database, path)
        database.execute("PRAGMA secure_delete=ON")
        yield database


def _empty_log(database: sqlite3.Connection, path: Path) -> None:
    """Bring the write-ahead log into the file. Raises StoreError if another program reads it."""
    busy, *_ = database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
    if busy:
        raise StoreError(
            f"Another program has {path} open. Close sar-tui everywhere, and try again.",
            temporary=True,
            locked=True,
        )


def _check_nothing_runs(database: sqlite3.Connection, folder: Path, code: str) -> None:
    for (session,) in database.execute("SELECT session FROM seats WHERE participant=?", (code,)):
        if is_held(folder, "session", session):
            raise StoreError(
                f"{code} is in the session {session} now. Try again when it has ended."
            )


def _details(database: sqlite3.Connection, event: PersonEvent, code: str) -> Details:
    """Return what an event names: what it did, and what is found of the person now."""
    found = details_of(database, code)
    return Details(
        sessions={**event.details.sessions, **found.sessions},
        records=tuple(sorted({*event.details.records, *found.records})),
    )


def _apply(database: sqlite3.Connection, event: PersonEvent, code: str) -> Changed:
    """Store an event, and do what it says, in one transaction."""
    own = sites.own(database)
    with transaction(database) as connection:
        connection.execute("DELETE FROM people_events WHERE id=?", (event.id,))
        people_events.insert(connection, event)
        full = with_full_codes(event, own)
        return apply(connection, full, old=in_full(code, own))


def _clean(database: sqlite3.Connection, path: Path) -> None:
    """Write the file anew, without free pages, and empty its log. Raises StoreError."""
    database.execute("PRAGMA temp_store=MEMORY")
    database.execute("VACUUM")
    _empty_log(database, path)


def _speech(database: sqlite3.Connection, event: PersonEvent) -> list[str]:
    """Return the folders into which speech was recorded."""
    found = []
    for session in event.details.sessions:
        row = database.execute(
            "SELECT json_extract(parameters, '$.speech') FROM sessions WHERE id=?", (session,)
        ).fetchone()
        if row and str(row[0]).startswith("file:"):
            found.append(str(row[0]).removeprefix("file:"))
    return sorted(set(found))


def _exports(database: sqlite3.Connection, event: PersonEvent) -> list[LedgerEntry]:
    held = set(event.details.sessions)
    return [entry for entry in exports.ledger(database) if held.intersection(entry.sessions)]


# --- other files


class _Files(NamedTuple):
    """Files beside the database, as `Done` has them."""

    rewritten: list[str]
    refused: list[Refusal]
    deleted: list[str]


def _other_files(folder: Path, event: PersonEvent, code: str, same: Collection[Pair]) -> _Files:
    """Do what an event says to rescue files, backups and copies in a data folder, and delete pages
    on the person's progress.
    """
    words = [*_codes(code, same), *event.details.sessions]
    rewritten, refused = [], []
    for path in _databases(folder):
        try:
            if _may_hold(path, words) and _rewrite(path, event, code, same):
                rewritten.append(str(path))
        except (StoreError, OSError) as error:
            refused.append(Refusal(str(path), str(error)))
        except sqlite3.Error as error:
            refused.append(Refusal(str(path), str(explain(error, path))))
    return _Files(rewritten, refused, _delete_pages(folder, _codes(code, same)))


def _databases(folder: Path) -> list[Path]:
    """Return the files in a data folder, except its database, that are databases by their names."""
    places = (folder, folder / BACKUPS)
    found = [path for place in places if place.is_dir() for path in place.iterdir()]
    left = [path for path in folder.glob(".merge-*/*") if path.is_file()]
    return sorted(
        path
        for path in (*found, *left)
        if path.is_file() and path.suffix in (".db", ".part") and path != folder / FILE
    )


def _may_hold(path: Path, words: Collection[str]) -> bool:
    """Return True if one of some words is in a file, or in its log."""
    return any(_has(each, words) for each in (path, sidecars(path)[0]) if each.exists())


def _has(path: Path, words: Collection[str]) -> bool:
    if not path.stat().st_size:
        return False
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as held:
        return any(held.find(word.encode()) >= 0 for word in words)


def _rewrite(path: Path, event: PersonEvent, code: str, same: Collection[Pair]) -> bool:
    """Do what an event says to a database that is not in use. Return False if it is not about it.

    Args:
        same: pairs of codes by which the person is known, which it may lack.

    Raises:
        StoreError: it is in use, damaged, or of another version.
    """
    with _alone(path) as database:
        if not 0 < (version := version_of(database, path)) <= VERSION:
            raise StoreError(f"{path} is no database of sar-tui.")
        there = "SELECT name FROM sqlite_master WHERE type='table'"
        lacking = _OF_FIRST_VERSION - {name for (name,) in database.execute(there)}
        if lacking:
            raise StoreError(f"It has no table {min(lacking)}.")
        is_in = _is_in(database, version, code, same)
        if not is_in and not _may_hold(path, event.details.sessions):
            return False
        if version < VERSION:
            schema.upgrade(database, version)
        _note_same(database, same)
        _apply(database, event, code)
        _clean(database, path)
        (state,) = database.execute("PRAGMA integrity_check(1)").fetchone()
        if state != "ok":
            raise StoreError(f"It is damaged ({state}).")
    return True


def _is_in(database: sqlite3.Connection, version: int, code: str, same: Collection[Pair]) -> bool:
    """Return True if a database of some version holds something of a person, or may: in a version
    that is kept aside.
    """
    own = sites.own(database)
    people = People(own, stored_pairs(database))
    known = (*_codes(code, same), *people.group(in_full(code, own)))
    codes = msgspec.json.encode([people.shortened(each) for each in known]).decode()
    held = [
        ("participants", "code"),
        ("seats", "participant"),
        ("records", "participant"),
        ("programmes", "participant"),
    ]
    if PEOPLE_EVENTS.since <= version:
        held.append((PEOPLE_EVENTS.name, "participant"))
    found = "SELECT 1 FROM {} WHERE {} IN (SELECT value FROM json_each(?)) LIMIT 1"
    if any(database.execute(found.format(*each), (codes,)).fetchone() for each in held):
        return True
    return database.execute("SELECT 1 FROM conflicts LIMIT 1").fetchone() is not None


def _note_same(database: sqlite3.Connection, same: Collection[Pair]) -> None:
    """Let a database know a person by all codes, if it does not yet."""
    own, before = sites.own(database), stored_pairs(database)
    if not own or before.issuperset(same):
        return
    people = People(own, before.union(same))
    with transaction(database) as connection:
        connection.executemany("INSERT OR IGNORE INTO same_people VALUES (?,?)", sorted(same))
        conflicts.rename(connection, "main", people)
        rename_own(connection, people)


def _delete_pages(folder: Path, codes: Collection[str]) -> list[str]:
    """Delete pages on the progress of a person, which are named by code and task, and return their
    paths. Codes have no small letters, and tasks begin with one.
    """
    person = "|".join(map(re.escape, codes))
    name = re.compile(rf"progress-({person})-[a-z_][^/]*\.html")
    found = sorted(path for path in folder.iterdir() if name.fullmatch(path.name))
    for path in found:
        path.unlink()
    return [str(path) for path in found]


def _export_folders(folder: Path, event: PersonEvent) -> list[str]:
    """Return the exports in a data folder that hold sessions of a person."""
    manifests = (folder / "exports").rglob(MANIFEST)
    return sorted(str(path.parent) for path in manifests if _has(path, event.details.sessions))
