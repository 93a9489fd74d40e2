"""Sessions examined by the hashes of their logs, and their rows derived again from the log."""

import json
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from itertools import product, takewhile
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ALL
from sar_tui.store import log_hashes, messages, rows
from sar_tui.store.log_hashes import Entry
from sar_tui.store.merge.people import People, in_full, local_code, stored_pairs
from sar_tui.store.messages import StoredRow
from sar_tui.store.record_changes import changes, ends_and_changes, erased_hashes, status_after
from sar_tui.store.records import TOLD
from sar_tui.store.tables import TABLES
from sar_tui.store.training_days import utc

DERIVED = ("trials", "attempts", "actions", "answers", "notes")
"""Tables whose rows follow from the messages."""
_STATEMENTS = {
    name: each.statement for name, each in rows.PROJECTIONS.items() if each.table in DERIVED
}
_TOPICS = frozenset(name for name, topic in ALL.items() if topic.type in rows.KINDS)
"""Topics whose messages become more than a row of ``messages``."""
REMOVED = "The hashes of its log were removed."
_RUNNING = ("running", "interrupted")
"""Statuses of a session that has not ended: a program that was killed leaves the first one."""


class Examined(NamedTuple):
    """A session, examined.

    Attributes:
        log: what was changed in its log and what is stored with it, in sentences.
        rows: what was changed in the rows that follow from the log.
    """

    log: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()


def examine(database: sqlite3.Connection) -> Iterator[tuple[str, Examined]]:
    """Yield each session with what is found. The database is only read."""
    people = _people(database)
    sessions = [id for (id,) in database.execute("SELECT id FROM sessions ORDER BY rowid")]
    with closing(Derivation(database)) as derivation:
        for session in sessions:
            yield session, _examined(database, session, people, derivation)


def altered(database: sqlite3.Connection) -> list[str]:
    """Return the sessions whose rows are not as they follow from their log, where the log is as it
    was recorded.
    """
    return [session for session, found in examine(database) if found.rows and not found.log]


def _examined(
    database: sqlite3.Connection, session: str, people: People, derivation: "Derivation"
) -> Examined:
    groups = _groups(database, session)
    row = database.execute(
        "SELECT status, ended_at, log_hash FROM sessions WHERE id=?", (session,)
    ).fetchone()
    if row is None:  # its id is damaged, which is told elsewhere
        return Examined()
    status, ended_at, last = row
    if not groups:
        return Examined((REMOVED,) if last else ())
    listed = [entry for group in groups for entry in group.beside]
    log = [
        *_changed_groups(database, session, people, groups),
        *_added(database, session, groups, listed),
    ]
    if groups[-1].hash != last:
        log.append("The last hash of its log is not the one in the row of the session.")
    # what follows is lost, too
    if log and messages.count(database, session, groups[-1].until) < groups[-1].until:
        return Examined(tuple(log))
    ends = _changed_end(database, session, status, ended_at, listed)
    return _with_rows(Examined(tuple(log), tuple(ends)), session, derivation)


def _with_rows(found: Examined, session: str, derivation: "Derivation") -> Examined:
    """Return what was found, and how the rows of a session differ from those that follow from its
    log.
    """
    if not derivation.derive(session):
        unread = (
            "Messages of it cannot be read by this version of sar-tui, so that its rows "
            "cannot be compared."
        )
        return found._replace(log=(*found.log, unread))
    return found._replace(rows=(*found.rows, *derivation.differences(session)))


# --- the log


class _Group(NamedTuple):
    number: int
    until: int
    beside: list[Entry]
    hash: str


def _groups(database: sqlite3.Connection, session: str) -> list[_Group]:
    found = database.execute(
        "SELECT number, seq, beside, hash FROM log_hashes WHERE session=? ORDER BY number",
        (session,),
    )
    return [
        _Group(number, until, log_hashes.entries(beside), str(stored))
        if isinstance(until, int)
        else _Group(-1, 0, [], "")  # damaged
        for number, until, beside, stored in found
    ]


def _changed_groups(
    database: sqlite3.Connection, session: str, people: People, groups: Sequence[_Group]
) -> Iterator[str]:
    """Yield the groups whose hash is not that of their messages and of what is stored with them."""
    stored = messages.stored_rows(database, session)
    erased = erased_hashes(database, session)
    waiting = next(stored, None)
    before, first, number = "", 1, 0
    for position, group in enumerate(groups, start=1):
        digests = []
        while waiting is not None and waiting.seq <= group.until:
            digests.append(_first_hash(waiting, erased))
            number = waiting.seq
            waiting = next(stored, None)
        beside = [
            _possible_hashes(database, session, people, entry, erased) for entry in group.beside
        ]
        holds = any(
            log_hashes.group_hash(before, (*digests, *some)) == group.hash
            for some in product(*beside)
        )
        if not holds or (group.number, group.until) != (position, number):
            yield _where(first, group)
        before, first = group.hash, group.until + 1
    if waiting is not None:
        yield f"There are messages from number {waiting.seq} on that were added to its log."


def _first_hash(row: StoredRow, erased: Mapping[tuple[str, bytes], bytes]) -> bytes:
    """Return the hash of a message as it was recorded."""
    digest = log_hashes.message_hash(row)
    return erased.get((str(row.seq), digest), digest)


def _where(first: int, group: _Group) -> str:
    """Return the sentence about a group that was changed."""
    names = {
        "facts": "the facts of the session",
        "run": "run {}",
        "stream": "sensor stream {}",
        "ended": "the end",
    }
    parts = [f"messages {first} to {group.until}"] if group.until >= first else []
    parts += [names[kind].format(*key) for kind, *key in group.beside if kind in names]
    chunks = [key for kind, *key in group.beside if kind == "chunk"]
    parts += [f"{len(chunks)} blocks of samples"] if chunks else []
    return (
        "Its log was changed: not as recorded are one or more of: "
        f"{', '.join(parts) or 'its hashes'}."
    )


def _possible_hashes(
    database: sqlite3.Connection,
    session: str,
    people: People,
    entry: Entry,
    erased: Mapping[tuple[str, bytes], bytes],
) -> list[bytes]:
    """Return the hash of a row beside the messages as it was recorded; of the session's facts, with
    each code of its participants.

    ``erased``: as `erased_hashes` returns them.
    """
    if entry != ["facts"]:
        found = [log_hashes.entry_hash(database, session, entry)]
    else:
        seats = log_hashes.seats(database, session)
        codes = [
            _codes_at_first(database, session, people, seat, code) for seat, code in seats.items()
        ]
        found = [
            log_hashes.facts_hash(database, session, dict(zip(seats, some, strict=True)))
            for some in product(*codes)
        ]
    name = log_hashes.name_of(entry)
    return [erased.get((name, each), each) for each in found]


def recorded_facts(database: sqlite3.Connection, session: str) -> bytes:
    """Return the hash of a session's facts as they were recorded: by the first group of its log, if
    that is as it was recorded; else as they are now.
    """
    erased = erased_hashes(database, session)
    possible = _possible_hashes(database, session, _people(database), ["facts"], erased)
    first = next(iter(_groups(database, session)), None)
    if first is not None and first.beside == [["facts"]]:
        until = first.until
        stored = takewhile(lambda row: row.seq <= until, messages.stored_rows(database, session))
        digests = [_first_hash(row, erased) for row in stored]
        for each in possible:
            if log_hashes.group_hash("", (*digests, each)) == first.hash:
                return each
    return possible[0]


def _codes_at_first(
    database: sqlite3.Connection, session: str, people: People, seat: str, code: str
) -> list[str]:
    """Return the codes that a participant may have had in the session's log.

    A merge gives a participant of another site a code in full, or that of the same person here; and
    the session may have been moved to another participant since.
    """
    possible = _codes_of(people, code)
    for change in reversed(changes(database, session)):
        if change.change == "moved" and change.seat == seat and change.details:
            after = str(change.details.get("after"))
            possible = (
                _codes_of(people, str(change.details.get("before"))) if after in possible else []
            )
    return possible


def _codes_of(people: People, code: str) -> list[str]:
    group = people.group(in_full(code, people.own))
    return sorted({code, *group, *(local_code(one) for one in group)})


def _people(database: sqlite3.Connection) -> People:
    own = database.execute("SELECT code FROM site").fetchone()
    return People(own[0] if own else "", stored_pairs(database))


def _added(
    database: sqlite3.Connection, session: str, groups: Sequence[_Group], listed: list[Entry]
) -> Iterator[str]:
    """Yield the rows beside the messages that no group knows."""
    known = {tuple(entry) for entry in listed}
    added = Counter(
        entry[0]
        for entry in log_hashes.entries_there(database, session)
        if tuple(entry) not in known
    )
    names = {"run": "runs", "stream": "sensor streams", "chunk": "blocks of samples"}
    for kind, count in added.items():
        yield f"There are {names[kind]} that were added to its log: {count}."


# --- what follows from the log


def _changed_end(
    database: sqlite3.Connection,
    session: str,
    status: str,
    ended_at: str | None,
    listed: list[Entry],
) -> Iterator[str]:
    """Yield what is wrong with the status and the end in the row of a session."""
    derived = status_after(ends_and_changes(database, session))
    if status != derived and not (status in _RUNNING and derived in _RUNNING):
        yield f"Its status is {status}, and by its log it is {derived}."
    if ended_at != _end(listed):
        yield "The time of its end was changed."


def _end(listed: Sequence[Entry]) -> str | None:
    """Return the time at which a session ended; None if it goes on, or its program was killed."""
    last = next((entry for entry in reversed(listed) if entry[0] in ("run", "ended")), ["run"])
    return str(last[1]) if last[0] == "ended" else None


class Derivation:
    """Derives rows of sessions from their messages, in the groups in which they were stored."""

    def __init__(self, database: sqlite3.Connection) -> None:
        self._database = database
        self._memory = sqlite3.connect(":memory:", isolation_level=None)
        self._memory.text_factory = database.text_factory
        self._pauses: list[tuple[Any, ...]] = []
        for table in DERIVED:
            self._memory.execute(TABLES[table].create)

    def close(self) -> None:
        """Forget the rows."""
        self._memory.close()

    def derive(self, session: str) -> bool:
        """Derive the rows of a session. Return False if a message cannot be read.

        Without hashes nothing tells the groups: all messages of a run are taken for one.
        """
        for table in DERIVED:
            self._memory.execute(f"DELETE FROM {table}")
        self._pauses = []
        ends = [group.until for group in _groups(self._database, session)]
        number = 0
        waiting: list[Record] = []
        run = 0
        for row in messages.stored_rows(self._database, session, topics=_TOPICS):
            while number < len(ends) and row.seq > ends[number]:
                self._store(session, run, waiting)
                waiting, number = [], number + 1
            if row.run != run:
                self._store(session, run, waiting)
                waiting, run = [], row.run
            try:
                waiting.append(Record(row.seq, row.at, ALL[row.topic], messages.decoded(row)))
            except (TypeError, msgspec.MsgspecError):
                return False
        self._store(session, run, waiting)
        return True

    def _store(self, session: str, run: int, records: list[Record]) -> None:
        if not records:
            return
        found = rows.rows_beside(session, run, records, utc())
        self._pauses = [] if found["refusals"] else self._pauses + found["pauses"]
        for kind, statement in _STATEMENTS.items():
            if found[kind]:
                self._memory.executemany(statement, found[kind])

    def differences(self, session: str) -> Iterator[str]:
        """Yield how the rows of a session differ from those that were derived."""
        for table in DERIVED:
            yield from self._difference(table, session)
        said = Counter((seat, kind) for _, _, seat, kind, _ in self._pauses)
        stored = Counter(
            self._database.execute(
                "SELECT seat, kind FROM records WHERE session=? AND moment='pause'"
                " AND json_extract(content, '$.answer')=?",
                (session, TOLD),
            ).fetchall()
        )
        if said != stored:
            yield "Its pauses for pain or tiredness are not those of its log."

    def _difference(self, table: str, session: str) -> Iterator[str]:
        stored, derived = (
            self._rows(database, table, session) for database in (self._database, self._memory)
        )
        here, there = Counter(stored), Counter(derived)
        here, there = here - there, there - here
        if not here and not there:
            return
        more_rows, fewer_rows = (
            Counter(repr(tuple(map(_comparable, row))) for row in each.elements())
            for each in (here, there)
        )
        more, less = (more_rows - fewer_rows).total(), (fewer_rows - more_rows).total()
        if not more and not less:
            return
        changed = min(more, less)
        parts = [
            f"{count} {words}"
            for count, words in (
                (changed, "changed"),
                (less - changed, "missing"),
                (more - changed, "added"),
            )
            if count
        ]
        yield f"Rows of {table} are not as its log has them: {', '.join(parts)}."

    def _rows(
        self, database: sqlite3.Connection, table: str, session: str
    ) -> list[tuple[Any, ...]]:
        listed = ", ".join(TABLES[table].names)
        found = database.execute(
            f"SELECT {listed} FROM {table} WHERE session=? ORDER BY rowid", (session,)
        )
        return found.fetchall()

    def rebuild(self, session: str) -> None:
        """Put the derived rows in place of those of a session, in a transaction of the caller."""
        for table in DERIVED:
            self._database.execute(f"DELETE FROM {table} WHERE session=?", (session,))
            self._database.executemany(
                TABLES[table].insert(), self._rows(self._memory, table, session)
            )
        listed_beside = [
            entry for group in _groups(self._database, session) for entry in group.beside
        ]
        status = status_after(ends_and_changes(self._database, session))
        self._database.execute(
            "UPDATE sessions SET status=?, ended_at=? WHERE id=?",
            (status, _end(listed_beside), session),
        )


def _comparable(value: Any) -> Any:
    """Return a value of a row so that JSON with 3 and with 3.0 is the same: a message that was read
    has the second.

    A text in which an object has a name twice is no JSON that was stored: SQLite would read the
    first value of it.
    """
    if isinstance(value, str) and value[:1] in ("{", "["):
        try:
            return json.loads(value, object_pairs_hook=_object, parse_int=_number)
        except (ValueError, RecursionError):
            return value
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(sorted(pairs))
    if len(found) < len(pairs):
        raise ValueError("a name stands twice")
    return found


def _number(digits: str) -> float:
    number = int(digits)
    return float(number) if abs(number) < 2**53 else number
