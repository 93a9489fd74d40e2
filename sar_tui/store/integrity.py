"""The whole database examined: damaged pages, rows without their session, gaps, damaged samples and
texts.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import NamedTuple

from sar_tui.loop.topics import ATTEMPT_ENDED
from sar_tui.store import schema
from sar_tui.store.counted import LIVE
from sar_tui.store.damaged_rows import Kind, damages
from sar_tui.store.database import explain
from sar_tui.store.locks import is_held
from sar_tui.store.log_examination import REMOVED, examine
from sar_tui.store.tables import VERSION

_MOST_FAULTS = 20
"""Largest number of damaged pages that are named."""
_WITH_ERASED = (
    "SELECT session FROM seats JOIN people_events ON replaced_by=seats.participant"
    " WHERE event='erased'"
)
"""The sessions for two in which the part of one was erased."""
_WITHOUT_PARTICIPANT = {
    "seats": LIVE,  # simulated people are no participants
    "records": f"(mode IS NULL OR {LIVE})",
}
"""Tables whose rows need their participant, if a condition holds."""
_GAPS = {
    "events": (
        "SELECT id, '', min(seq), max(seq), count(*) FROM messages"
        " JOIN session_numbers ON number=session_number GROUP BY id"
    ),
    "trials": (
        "SELECT session, ' of attempt ' || attempt, min(trial), max(trial), count(DISTINCT trial) "
        f"FROM trials WHERE session NOT IN ({_WITH_ERASED})"
        " GROUP BY session, attempt"
    ),
    "blocks of samples": (
        "SELECT session, ' of stream ' || stream, min(seq), max(seq), count(*) FROM imu_chunks "
        "GROUP BY session, stream"
    ),
}


Progress = Callable[[int, int], None]
"""Called with what is done and what there is."""


class Flaw(NamedTuple):
    """A flaw of the database. ``where``: a session or a participant; empty for the file. ``what``:
    in words.
    """

    kind: Kind
    where: str
    what: str


def flaws(
    database: sqlite3.Connection, *, gaps: bool = True, progress: Progress = lambda done, of: None
) -> Iterator[Flaw]:
    """Yield the flaws of a database, as it was when the first of them was looked for.

    Nothing is written, and a session may go on meanwhile. Gaps are looked for unless they do not
    matter. ``progress`` is called with the number of sessions that were examined, and of all.

    Raises:
        StoreError: the database cannot be read at all.
    """
    texts = database.text_factory
    database.text_factory = lambda raw: raw.decode(errors="replace")  # ids may be damaged, too
    try:
        database.execute("BEGIN")
        try:
            found = list(damaged_pages(database)) or list(changed_schema(database))
            yield from found
            if not found:  # the rest is read from these pages, and through these views
                yield from _damaged_rows(database)
                yield from _without_participant(database)
                if gaps:
                    yield from _gaps(database)
                    yield from _lost_trials(database)
                    yield from _without_hashes(database)
                yield from _changed(database, progress)
        finally:
            database.text_factory = texts
            if database.in_transaction:
                database.execute("ROLLBACK")
    except sqlite3.Error as error:
        raise explain(error) from error


def damaged_pages(database: sqlite3.Connection, attached: str = "") -> Iterator[Flaw]:
    """Yield what is wrong with the pages of the file.

    Args:
        attached: another database, of which only tables are looked at: its indexes may be anything.
    """
    check = f"{attached}.quick_check" if attached else "integrity_check"
    try:
        for (text,) in database.execute(f"PRAGMA {check}({_MOST_FAULTS})"):
            if text != "ok":
                yield Flaw("file", "", f"The file is damaged: {text}.")
    except sqlite3.DatabaseError as error:
        if getattr(error, "sqlite_errorcode", 0) & 0xFF != sqlite3.SQLITE_CORRUPT:
            raise
        yield Flaw("file", "", f"The file is damaged: {error}.")


def changed_schema(database: sqlite3.Connection) -> Iterator[Flaw]:
    """Yield views and triggers that would show, or store, something else than those of this version
    do.

    Views that somebody added are none of them: only their author reads them. A database of an
    earlier release has none either, as it is brought up to date first.
    """
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version != VERSION:
        return
    here, own = _schema(database), _own_schema()
    for name in sorted(here.keys() | own.keys()):
        kind, text = here.get(name, ("", ""))
        if (kind, text) != own.get(name) and (name in own or kind == "trigger"):
            yield Flaw(
                "file", "", f"The {own.get(name, (kind, ''))[0]} {name} is not as sar-tui makes it."
            )


def _schema(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return type and text of each view and trigger, by name."""
    found = database.execute(
        "SELECT name, type, sql FROM main.sqlite_master WHERE type IN ('view', 'trigger')"
    )
    return {name: (kind, text) for name, kind, text in found}


@cache
def _own_schema() -> dict[str, tuple[str, str]]:
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as database:
        schema.create(database)
        return _schema(database)


def _damaged_rows(database: sqlite3.Connection) -> Iterator[Flaw]:
    for each in damages(database):
        for where, what in database.execute(
            f"SELECT {each.where}, {each.words} FROM {each.table} WHERE {each.condition} GROUP BY "
            f"1, {each.part}"
        ):
            yield Flaw(each.kind, str(where), what)


def _without_participant(database: sqlite3.Connection) -> Iterator[Flaw]:
    for table, condition in _WITHOUT_PARTICIPANT.items():
        with_session = (
            "" if "mode" not in condition else f" LEFT JOIN sessions ON sessions.id={table}.session"
        )
        where = "session" if table == "seats" else "participant"
        for (whose,) in database.execute(
            f"SELECT DISTINCT {where} FROM {table}{with_session} WHERE {condition}"
            " AND participant NOT IN (SELECT code FROM participants)"
            " AND participant NOT IN (SELECT replaced_by FROM people_events)"
        ):
            yield Flaw("orphan", str(whose), f"There are {table} without a participant.")


def _changed(database: sqlite3.Connection, progress: Progress) -> Iterator[Flaw]:
    """Yield the sessions whose log or rows were changed."""
    (of,) = database.execute("SELECT count(*) FROM sessions").fetchone()
    for done, (session, examined) in enumerate(examine(database), 1):
        progress(done, of)
        yield from (Flaw("log", session, fault) for fault in examined.log)
        yield from (Flaw("rows", session, fault) for fault in examined.rows)


def _without_hashes(database: sqlite3.Connection) -> Iterator[Flaw]:
    """Yield the sessions that lack even the last hash of their log."""
    for (session,) in database.execute(
        "SELECT id FROM sessions JOIN session_numbers USING (id) WHERE log_hash=''"
        " AND id NOT IN (SELECT session FROM log_hashes)"
        " AND number IN (SELECT session_number FROM messages)"
    ):
        yield Flaw("log", session, REMOVED)


def _lost_trials(database: sqlite3.Connection) -> Iterator[Flaw]:
    """Yield attempts and trials that lack each other. An attempt may have trials and no row if it
    stopped, was skipped, or began again.
    """
    for session, seat, attempt in database.execute(
        "SELECT DISTINCT session, seat, attempt FROM trials WHERE NOT EXISTS"
        " (SELECT 1 FROM attempts WHERE session=trials.session AND attempt=trials.attempt AND "
        "seat=trials.seat)"
        " AND EXISTS (SELECT 1 FROM attempts WHERE session=trials.session AND "
        "attempt>=trials.attempt)"
    ):
        if attempt in _ended_attempts(database, session):
            yield Flaw(
                "gap",
                str(session),
                f"Of attempt {attempt} there are trials of seat {seat}, but not its result.",
            )
    for session, seat, attempt in database.execute(
        "SELECT session, seat, attempt FROM attempts WHERE trials>0 AND NOT EXISTS"
        " (SELECT 1 FROM trials WHERE session=attempts.session AND attempt=attempts.attempt AND "
        "seat=attempts.seat)"
    ):
        yield Flaw(
            "gap",
            str(session),
            f"Of attempt {attempt} there is the result of seat {seat}, but no trial.",
        )


def _gaps(database: sqlite3.Connection) -> Iterator[Flaw]:
    for what, query in _GAPS.items():
        for session, of, first, last, count in database.execute(query):
            # a row of damaged pages, which is told elsewhere
            if session is None or not isinstance(last, int):
                continue
            if missing := last - count:
                yield Flaw("gap", session, f"Of {last} {what}{of}, {missing} are missing.")
            elif first != 1:
                yield Flaw("gap", session, f"The {what}{of} do not begin at 1.")
    yield from _lost_attempts(database)


def _lost_attempts(database: sqlite3.Connection) -> Iterator[Flaw]:
    """Yield the sessions that lack attempts which ended. Numbers are left out by attempts that were
    skipped, taken back, or began again.
    """
    gaps = (
        "SELECT session, max(attempt) FROM attempts GROUP BY session"
        " HAVING max(attempt)>count(DISTINCT attempt)"
    )
    for session, last in database.execute(gaps).fetchall():
        if session is None or not isinstance(last, int):
            continue
        there = database.execute("SELECT attempt FROM attempts WHERE session=?", (session,))
        missing = _ended_attempts(database, session) - {attempt for (attempt,) in there}
        if missing:
            yield Flaw("gap", session, f"Of {last} attempts, {len(missing)} are missing.")


def _ended_attempts(database: sqlite3.Connection, session: str) -> set[int]:
    """Return the numbers of the attempts that ended, by the log."""
    ended = database.execute(
        "SELECT json_extract(message, '$.attempt') FROM events WHERE session=? AND topic=?"
        " AND json_valid(message)",
        (session, ATTEMPT_ENDED.name),
    )
    return {attempt for (attempt,) in ended}


def interrupted(database: sqlite3.Connection, folder: Path) -> list[str]:
    """Return the ids of sessions that were left before their end, and that no program runs. That is
    no flaw.
    """
    stopped = (
        "SELECT CAST(id AS BLOB), status FROM sessions WHERE status IN ('running', "
        "'interrupted') ORDER BY rowid"
    )
    found = [
        (bytes(name).decode(errors="replace"), status) for name, status in database.execute(stopped)
    ]
    return [
        name
        for name, status in found
        if status != "running" or not is_held(folder, "session", name)
    ]


def counts(database: sqlite3.Connection) -> dict[str, int]:
    """Return the number of rows of each table."""
    tables = database.execute(
        "SELECT name FROM sqlite_master WHERE type='table' AND name NOT LIKE 'sqlite%' ORDER BY "
        "name"
    ).fetchall()
    return {
        name: int(database.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0])
        for (name,) in tables
    }
