"""Merges another database into this one: what it has more is added, nothing is lost, and the order
does not matter.
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from sar_tui.drivers.files import make_private, unused
from sar_tui.store import sessions, sites
from sar_tui.store.backup import FOLDER, back_up
from sar_tui.store.database import FILE, StoreError, connect, transaction
from sar_tui.store.locks import Held, hold, is_held
from sar_tui.store.merge import conflicts
from sar_tui.store.merge.comparison import number_topics
from sar_tui.store.merge.conflicts import Conflict
from sar_tui.store.merge.ownership import leave_out, refuse, split_pairs
from sar_tui.store.merge.people import (
    Pair,
    People,
    parse_same,
    rename_others,
    rename_own,
    stored_pairs,
)
from sar_tui.store.merge.records import merge_records
from sar_tui.store.merge.rights import Rights, keep_rights, take_over
from sar_tui.store.merge.session_records import follow_moves, merge_sessions
from sar_tui.store.merge.source import copied, remove_leftovers

Start = Callable[[str], Callable[[int, int], None]]
"""Begins a step with a name, and returns a function that is called with what is done of it, and the
whole.
"""


class Merged(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a merge.

    Attributes:
        site: of this database. ``other``: of the other one; empty if there was none.
        added, updated: ids of sessions that this database did not have, or less of.
        records: numbers of other rows that were added or changed, by table.
        left_out: sessions that run there now.
        refused: a sentence on each record there that only this site, or another one, could have
            written.
        rescue_files: of the other data folder, which were not read.
        conflicts: all versions that are kept aside. ``new_conflicts``: the number of those that are
            new.
        same: codes in full that are the same person.
        erased: codes of people whose data was erased here, as their site erased it.
        backup: of this database as it was before; None if nothing had to change.
    """

    site: str
    other: str = ""
    added: list[str] = []
    updated: list[str] = []
    records: dict[str, int] = {}
    left_out: list[str] = []
    refused: list[str] = []
    rescue_files: list[str] = []
    conflicts: list[Conflict] = []
    new_conflicts: int = 0
    same: list[Pair] = []
    erased: list[str] = []
    backup: str | None = None


def merge(
    folder: Path,
    other: Path | None,
    same: Iterable[str] = (),
    *,
    site: str = "",
    one_site: bool = False,
    check_letter: Callable[[sqlite3.Connection], None] | None = None,
    start: Start,
) -> Merged:
    """Bring what another database has into that of a data folder, in one transaction. The other one
    is only read.

    Args:
        folder: the data folder.
        other: the other database, or its data folder; None only to note who is the same person.
        same: codes of the same person, such as "P01@BERN=P01".
        site: code of the other one's site, if it has none.
        one_site: both databases are of one site, so that the same code is the same person.
        check_letter: the other database came in a sealed letter. The function is called with it
            attached as ``other``, and raises StoreError if the letter's writer could not have
            written it. No backup is made: a letter only adds rows of one person.
        start: begins a step.

    Raises:
        StoreError: the other database cannot be merged, a session runs here, or the disk cannot
            write. Nothing has changed then.
    """
    with closing(connect(folder)) as db, _alone(folder):
        own = sites.own(db)
        if not own:
            raise StoreError(
                "This site has no code yet, by which others know it. Set it first, such as: "
                "sar-tui site BERN",
                bad_input=True,
            )
        pairs = {parse_same(text, own) for text in same}
        if other is None:
            return _changed(db, folder, lambda: _note(db, own, pairs), backs_up=True)
        with copied(other, folder, start("Reading")) as source:
            rights = keep_rights(db, source.copy, own, site, pairs)
            db.execute("ATTACH ? AS other", (str(source.copy),))
            try:
                db.execute("PRAGMA other.journal_mode=OFF")
                db.execute("PRAGMA other.synchronous=OFF")
                _check_no_demonstration(db, other)
                if check_letter is not None:
                    check_letter(db)
                site = _site_of_other(db, own, other, site and sites.check_site(site), one_site)
                is_letter = check_letter is not None
                result = _changed(
                    db,
                    folder,
                    lambda: _merge(
                        db,
                        own,
                        site,
                        pairs,
                        source.running,
                        rights,
                        start("Merging"),
                        is_letter=is_letter,
                    ),
                    backs_up=not is_letter,
                )
            finally:
                db.execute("DETACH other")
        return msgspec.structs.replace(
            result,
            left_out=list(source.running),
            rescue_files=[str(path) for path in source.rescue_files],
        )


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Hold the lock of merges, and refuse if a session runs here: it would wait for the
    database.
    """
    try:
        held = hold(folder, "merge", FILE)
    except Held:
        raise StoreError(
            "Another merge goes on in this data folder. Wait until it has ended."
        ) from None
    try:
        remove_leftovers(folder)
        yield
    finally:
        held.release()


def _check_nothing_runs(db: sqlite3.Connection, folder: Path) -> None:
    for (id,) in db.execute("SELECT id FROM main.sessions WHERE status='running'").fetchall():
        if is_held(folder, "session", id):
            raise StoreError(
                f"Session {id} is running here, and a merge would hold it up: merge when it has "
                "ended."
            )


def _check_no_demonstration(db: sqlite3.Connection, other: Path) -> None:
    """Raise StoreError if one of two databases holds a demonstration: its people are invented."""
    for schema, which in (("other", str(other)), ("main", "This database")):
        if sessions.is_demonstration(db, schema):
            raise StoreError(
                f"{which} holds a demonstration. Its people are invented: it is not merged.",
                bad_input=True,
            )


def _site_of_other(
    db: sqlite3.Connection, own: str, other: Path, given: str, one_site: bool
) -> str:
    row = db.execute("SELECT code FROM other.site").fetchone()
    site = str(row[0]) if row else given
    if not site:
        raise StoreError(
            f"{other} has no code of its site. Set it there first, such as sar-tui site BERN, or "
            "name it: --site BERN",
            bad_input=True,
        )
    if given and given != site:
        raise StoreError(f"{other} is of {site}, not of {given}.", bad_input=True)
    if site == own and not one_site:
        raise StoreError(
            f"{other} is of {own}, as this database is. If the same code is the same person in "
            "both, such as on two "
            "computers of one clinic, add --one-site; otherwise give one of them another code by "
            "sar-tui site.",
            bad_input=True,
        )
    if site != own and one_site:
        raise StoreError(
            f"{other} is of {site}, and this database of {own}: leave out --one-site.",
            bad_input=True,
        )
    return site


def _changed(
    db: sqlite3.Connection, folder: Path, work: Callable[[], Merged], *, backs_up: bool
) -> Merged:
    """Do what changes the database in one transaction, after a backup if ``backs_up``; if there was
    nothing to do, nothing changes.
    """
    _check_nothing_runs(db, folder)
    with _undone_unless_changed(db) as changes:
        result = work()
        if changes(result) and backs_up:
            make_private(folder / FOLDER)
            path = unused(
                folder / FOLDER / f"sar-tui-before-merge-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.db"
            )
            # another connection: it copies what was there before this transaction
            back_up(folder, path)
            result = msgspec.structs.replace(result, backup=str(path))
    return result


class _Unchanged(Exception):
    pass


@contextmanager
def _undone_unless_changed(db: sqlite3.Connection) -> Iterator[Callable[[Merged], bool]]:
    has_changed = False
    before = conflicts.listing(db)

    def changes(result: Merged) -> bool:
        nonlocal has_changed
        found = (result.added, result.updated, result.conflicts != before)
        has_changed = any(found) or any(result.records.values())
        return has_changed

    try:
        with transaction(db):
            yield changes
            if not has_changed:
                raise _Unchanged
    except _Unchanged:
        pass


def _note(db: sqlite3.Connection, own: str, pairs: set[Pair]) -> Merged:
    people, changed = _same_people(db, own, pairs)
    return Merged(
        site=own,
        records={"same_people": changed},
        conflicts=conflicts.listing(db),
        same=sorted(people.same),
    )


def _same_people(db: sqlite3.Connection, own: str, pairs: set[Pair]) -> tuple[People, int]:
    """Note who is the same person, and return the number of rows that changed."""
    before = stored_pairs(db)
    people = People(own, before | pairs)
    people.check()
    if people.same == before:
        return people, 0
    db.executemany("INSERT OR IGNORE INTO main.same_people VALUES (?,?)", sorted(people.same))
    conflicts.rename(db, "main", people)
    return people, len(people.same - before) + rename_own(db, people)


def _merge(
    db: sqlite3.Connection,
    own: str,
    site: str,
    pairs: set[Pair],
    running: Iterable[str],
    rights: Rights,
    progress: Callable[[int, int], None],
    *,
    is_letter: bool,
) -> Merged:
    before = set(conflicts.listing(db))
    theirs, refused = stored_pairs(db, "other"), list[str]()
    if site != own:
        theirs, refused = split_pairs(People(own, stored_pairs(db) | pairs), theirs, site)
    people, renamed = _same_people(db, own, pairs | theirs)
    erased = take_over(db, rights)
    leave_out(db, running)
    number_topics(db)
    rename_others(db, people, site)
    conflicts.rename(db, "other", people)
    if site != own:
        refused += refuse(db, people, site, has_other_names=bool(refused))
    sessions = merge_sessions(db, people, progress)
    follow_moves(db, people)
    records = {"same_people": renamed, **merge_records(db, people)}
    records["people_events"] += len(erased)
    if sessions.added or sessions.updated:
        put_in_order(db, sessions.added if is_letter else ())
    aside = conflicts.listing(db)
    return Merged(
        site=own,
        other=site,
        added=sessions.added,
        updated=sessions.updated,
        records=records,
        refused=[*rights.refused, *refused],
        erased=erased,
        conflicts=aside,
        new_conflicts=len(set(aside) - before),
        same=sorted(people.same),
    )


# --- the order of sessions: one's own as they were stored, others between them by time


_BY_LETTER = """
SELECT session.key FROM main.letters, json_each(letters.contents, '$.sessions') AS session
WHERE direction='in'"""
"""The sessions that sealed letters brought, which arrive in any order."""


def put_in_order(db: sqlite3.Connection, arrived: Iterable[str] = ()) -> None:
    """Renumber the rows of sessions and seats, so that lists and reports have the sessions in their
    order.

    A session that was recorded here and seems to have begun before an earlier one, as the clock was
    set back, stays after it. ``arrived``: sessions that a letter brings now.
    """
    elsewhere = {id for (id,) in db.execute(_BY_LETTER)}.union(arrived)
    stored = db.execute("SELECT id, site, started_at FROM main.sessions ORDER BY rowid").fetchall()
    latest, began = "", {}
    is_own = {id: not site and id not in elsewhere for id, site, _ in stored}
    for id, _, started_at in stored:
        if is_own[id]:
            latest = max(latest, started_at)
        began[id] = latest if is_own[id] else started_at
    place = {id: number for number, (id, *_) in enumerate(stored)}
    wanted = sorted(
        began, key=lambda id: (began[id], *((0, place[id], "") if is_own[id] else (1, 0, id)))
    )
    first = next(
        (
            number
            for number, (id, (old, *_)) in enumerate(zip(wanted, stored, strict=True))
            if id != old
        ),
        None,
    )
    if first is not None:
        _move_to_end(db, wanted[first:])


def _move_to_end(db: sqlite3.Connection, sessions: list[str]) -> None:
    (last,) = db.execute("SELECT max(rowid) FROM main.sessions").fetchone()
    db.executemany(
        "UPDATE main.sessions SET rowid=? WHERE id=?",
        [(last + n, id) for n, id in enumerate(sessions, start=1)],
    )
    (seat,) = db.execute("SELECT max(rowid) FROM main.seats").fetchone()
    for id in sessions:
        for (old,) in db.execute(
            "SELECT rowid FROM main.seats WHERE session=? ORDER BY seat", (id,)
        ).fetchall():
            seat += 1
            db.execute("UPDATE main.seats SET rowid=? WHERE rowid=?", (seat, old))
