"""Rows of a person in a database: taken out, or without what identifies the person.

What is done follows from the database and the event alone, so that all databases which know of the
event hold the same, whatever the order in which they are merged.
"""

import sqlite3
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec

from sar_tui.model.messages import RecordChanged
from sar_tui.records.kind import KindError, find
from sar_tui.store import log_hashes, redaction
from sar_tui.store.merge import conflicts
from sar_tui.store.merge.people import Pair, People, in_full, local_code, site_of, stored_pairs
from sar_tui.store.merge.session_records import remove
from sar_tui.store.people_events import Details, PersonEvent
from sar_tui.store.record_changes import changes
from sar_tui.store.sites import own as own_site

ENROLMENT = "enrolment"
"""Kind of the records with what was drawn for a person of a study."""
FINAL = ("de-identified", "erased")
"""Events that change what is stored of the person."""


class Changed(NamedTuple):
    """Numbers of what an event changed in a database.

    ``sessions``: all of the person. ``shared``: those of them for two, which stay for the partner.
    ``others``: rows of other tables.
    """

    sessions: int = 0
    shared: int = 0
    others: int = 0

    def __bool__(self) -> bool:
        return any(self)


def with_full_codes(event: PersonEvent, own: str) -> PersonEvent:
    """Return an event of a database of the site ``own`` with its codes and its site in full."""
    return msgspec.structs.replace(
        event,
        participant=in_full(event.participant, own),
        replaced_by=event.replaced_by and in_full(event.replaced_by, own),
        site=event.site or own,
    )


def apply(
    db: sqlite3.Connection,
    event: PersonEvent,
    *,
    old: str = "",
    same: Iterable[Pair] = (),
    at: str | None = None,
) -> Changed:
    """Do to a database what an event says, in a transaction of the caller; nothing if it is done.

    A site's event is about all of the person in the database of that site, and elsewhere about what
    came from there.

    Args:
        event: with codes in full (see `with_full_codes`). Others than erasures and
            de-identifications change nothing.
        old: of a de-identification, the code of the person until then, in full; without it, it is
            looked for by the sessions and records that the event names.
        same: codes of the same persons, beside those that the database has.
        at: the site into whose database all this goes; None for the database's own.
    """
    if event.event not in FINAL:
        return Changed()
    own = own_site(db)
    people = People(own, stored_pairs(db) | set(same))
    person = _Person(event, people, own if at is None else at)
    if event.event == "erased":
        return _erase(db, person)
    return _deidentify(db, person, old)


def details_of(db: sqlite3.Connection, participant: str) -> Details:
    """Return what an event about all of a participant has to name: sessions with the seat, and
    records.
    """
    sessions = db.execute(
        "SELECT session, seat FROM seats WHERE participant=? ORDER BY session", (participant,)
    )
    records = db.execute(
        "SELECT DISTINCT id FROM records WHERE participant=? ORDER BY id", (participant,)
    )
    return Details(sessions=dict(sessions.fetchall()), records=tuple(id for (id,) in records))


class _Person:
    """The person of an event, by the names of a database.

    Attributes:
        code: by which their rows are stored. ``codes``: all of the person, by which their programmes
            are.
        site: whose rows the event is about, as a column ``site`` has it. ``is_own``: it is about
            all.
    """

    def __init__(self, event: PersonEvent, people: People, at: str) -> None:
        self.event = event
        self.people = people
        self.is_own = event.site == at
        self.site = "" if event.site == people.own else event.site
        self.code = people.stored(event.participant)
        self.codes = {people.shortened(each) for each in people.group(event.participant)}
        self.name = people.name(event.participant)
        self.replaced_by = people.shortened(event.replaced_by)
        self.records = {people.shortened(in_full(id, event.site)) for id in event.details.records}
        self.said = RecordChanged(
            change="erased" if event.event == "erased" else "redacted",
            actor=event.recorded_by,
            at=event.at,
            reason=event.reason,
        )

    def of_site(self, table: str) -> str:
        """Return the condition that a row is one that the event is about."""
        return "1" if self.is_own else f"{table}.site=:site"

    def programme_codes(self) -> list[str]:
        """Return the codes that programmes have, which keep those of their site."""
        own = self.people.shortened(self.event.participant)
        return sorted(self.codes) if self.is_own else [own]


# --- erasing


def _erase(db: sqlite3.Connection, person: _Person) -> Changed:
    whole, shared = [], []
    for session, seat, is_for_two in _sessions(db, person):
        done = {one.seat: one.at for one in changes(db, session) if one.change == "erased"}
        if not is_for_two or done.keys() - {seat}:
            whole.append(session)
        elif done.get(seat) != person.event.at:
            shared.append((session, seat))
    gone = {*whole, *(session for session, _ in shared)}
    _erase_conflicts(db, gone, lambda row: _is_of(row, person))
    for session in whole:
        db.execute("DELETE FROM records WHERE session=?", (session,))
    remove(db, whole)
    db.executemany("DELETE FROM session_numbers WHERE id=?", [(session,) for session in whole])
    for session, seat in shared:
        said = msgspec.structs.replace(person.said, seat=seat)
        old = log_hashes.seats(db, session)[seat]
        redaction.erase_seat(db, session, seat, old, person.replaced_by, said)
    others = _anonymise_enrolments(db, person)
    others += _rename_replaced(db, person, [person.code], person.replaced_by)
    others += _delete(db, "records", "participant", [person.code], person)
    others += _delete(db, "records", "id", sorted(person.records), person)
    others += _delete(db, "programmes", "participant", person.programme_codes(), person)
    if person.is_own or site_of(person.code) == person.site:
        others += db.execute("DELETE FROM participants WHERE code=?", (person.code,)).rowcount
    others += db.execute(
        "DELETE FROM people_events WHERE participant IN (?, ?) AND site=?"
        " AND event IN ('withdrawn', 'resumed')",
        (person.code, person.people.shortened(person.event.participant), person.site),
    ).rowcount
    return Changed(len(whole) + len(shared), len(shared), others)


def _anonymise_enrolments(db: sqlite3.Connection, person: _Person) -> int:
    """Leave the number and the group of a person in each study, under a code that nobody has: what
    was drawn stays drawn.
    """
    return db.execute(
        "UPDATE records SET participant=:gone, recorded_by='', session=NULL"
        f" WHERE kind=:kind AND participant<>:gone AND {person.of_site('records')}"
        " AND (participant=:code OR id IN (SELECT value FROM json_each(:ids)))",
        {
            "gone": person.replaced_by,
            "kind": ENROLMENT,
            "site": person.site,
            "code": person.code,
            "ids": msgspec.json.encode(sorted(person.records)).decode(),
        },
    ).rowcount


def _rename_replaced(
    db: sqlite3.Connection, person: _Person, codes: Iterable[str], new: str
) -> int:
    """Replace the code of a person in the enrolments of those who came in their place, which have
    it as the site of the person does.
    """
    return sum(
        db.execute(
            "UPDATE records SET content=json_set(content, '$.replaces', :new) WHERE kind=:kind"
            " AND site=:site AND json_valid(content)"
            " AND json_extract(content, '$.replaces')=:old",
            {
                "new": local_code(new),
                "old": local_code(code),
                "kind": ENROLMENT,
                "site": person.site,
            },
        ).rowcount
        for code in codes
    )


def _sessions(db: sqlite3.Connection, person: _Person) -> list[tuple[str, str, bool]]:
    """Return the sessions of the person with their seat, and whether they are for two."""
    named = msgspec.json.encode(person.event.details.sessions).decode()
    return db.execute(
        "SELECT own.session, own.seat, other.seat NOTNULL FROM seats AS own"
        " JOIN sessions ON sessions.id=own.session"
        " LEFT JOIN seats AS other ON other.session=own.session AND other.seat<>own.seat"
        f" WHERE {person.of_site('sessions')} AND own.participant<>:gone AND (own.participant=:code"
        " OR EXISTS (SELECT 1 FROM json_each(:named) AS given"
        " WHERE given.key=own.session AND given.value=own.seat)) ORDER BY own.session",
        {"site": person.site, "code": person.code, "named": named, "gone": person.replaced_by},
    ).fetchall()


def _delete(
    db: sqlite3.Connection, table: str, column: str, values: Sequence[str], person: _Person
) -> int:
    kept = " AND kind<>:kept" if table == "records" else ""
    return sum(
        db.execute(
            f"DELETE FROM {table} WHERE {column}=:value AND {person.of_site(table)}{kept}",
            {"value": value, "site": person.site, "kept": ENROLMENT},
        ).rowcount
        for value in values
    )


def _erase_conflicts(
    db: sqlite3.Connection, sessions: Container[str], is_gone: Callable[[Mapping[str, Any]], bool]
) -> None:
    """Erase all versions that are kept aside of some sessions, and those with a seat, a programme or
    a record that goes.
    """
    rows = db.execute("SELECT kind, key, digest, content FROM conflicts").fetchall()
    for kind, key, digest, packed in rows:
        content = conflicts.decoded(packed)
        if kind == "session":
            (session,) = content["sessions"]
            found = [{**seat, "site": session["site"]} for seat in content["seats"]]
        else:
            found = next(iter(content.values()))
        if (kind == "session" and key in sessions) or any(map(is_gone, found)):
            db.execute(
                "DELETE FROM conflicts WHERE kind=? AND key=? AND digest=?", (kind, key, digest)
            )


def _is_of(row: Mapping[str, Any], person: _Person) -> bool:
    """Return True if a version of a programme or a record, or a seat of one of a session, is of the
    person.
    """
    code = in_full(str(row["participant"]), person.people.own)
    is_of_site = person.is_own or row.get("site") == person.event.site
    return is_of_site and person.name == person.people.name(code)


# --- taking out what identifies


def _deidentify(db: sqlite3.Connection, person: _Person, old: str) -> Changed:
    """Replace the code, and erase texts, of the person; of another database, of the sessions and
    records that the event names.
    """
    new = person.code
    known = person.people.stored(old) if old else ""
    given = {
        "site": person.site,
        "new": new,
        "known": known,
        "sessions": msgspec.json.encode(person.event.details.sessions).decode(),
        "records": msgspec.json.encode(sorted(person.records)).decode(),
    }
    others_codes = (
        "participant NOT IN (SELECT :new UNION ALL SELECT replaced_by FROM people_events)"
    )
    sessions = db.execute(
        "SELECT seats.session, seat, participant FROM seats JOIN sessions ON sessions.id=session"
        f" WHERE {person.of_site('sessions')} AND {others_codes} AND (participant=:known OR EXISTS"
        " (SELECT 1 FROM json_each(:sessions) AS named WHERE key=session AND value=seat))"
        " ORDER BY session",
        given,
    ).fetchall()
    records = db.execute(
        f"SELECT DISTINCT id, participant FROM records WHERE {person.of_site('records')}"
        f" AND {others_codes} AND (participant=:known"
        " OR id IN (SELECT value FROM json_each(:records))) ORDER BY id",
        given,
    ).fetchall()
    codes = {code for *_, code in sessions} | {code for _, code in records} | ({known} - {""})
    others = 0
    for session, seat, code in sessions:
        said = msgspec.structs.replace(person.said, seat=seat)
        redaction.erase_texts(db, session, seat, code, new, said)
    for id, _ in records:
        others += _redact_record(db, id, new)
    for code in sorted(codes):
        if not _has_more(db, code):
            others += _rename_rest(db, person, code, new)
    others += _rename_replaced(db, person, sorted(codes), new)
    for code in codes if person.is_own and old else ():
        full = in_full(code, person.people.own)
        db.execute("DELETE FROM same_people WHERE ? IN (code, same_as)", (full,))
    gone = {session for session, *_ in sessions}
    names = {person.people.name(in_full(code, person.people.own)) for code in codes}
    _erase_conflicts(db, gone, lambda row: row["participant"] in names)
    return Changed(len(sessions), 0, others)


def _redact_record(db: sqlite3.Connection, id: str, new: str) -> int:
    rows = db.execute("SELECT rowid, kind, content FROM records WHERE id=?", (id,)).fetchall()
    for row, kind, content in rows:
        db.execute(
            "UPDATE records SET participant=?, recorded_by='', content=? WHERE rowid=?",
            (new, _without_words(kind, content), row),
        )
    return len(rows)


def _without_words(kind: str, content: str) -> str:
    """Return the values of a record without those that were typed; of a kind that is not declared
    here, without all texts.
    """
    try:
        values = msgspec.json.decode(content, type=dict[str, Any])
    except msgspec.MsgspecError:
        return "{}"
    try:
        stays = {each.name for each in find(kind).fields if each.type != "text" or not each.typed}
    except KindError:
        stays = set()
    kept = {
        name: "" if name not in stays and isinstance(value, str) else value
        for name, value in values.items()
    }
    return msgspec.json.encode(kept).decode()


def _has_more(db: sqlite3.Connection, code: str) -> bool:
    """Return True if somebody has sessions or records by a code."""
    return any(
        db.execute(f"SELECT 1 FROM {table} WHERE participant=? LIMIT 1", (code,)).fetchone()
        for table in ("seats", "records")
    )


def _rename_rest(db: sqlite3.Connection, person: _Person, code: str, new: str) -> int:
    """Give programmes, the participant and earlier events the other code, without texts."""
    changed = db.execute(
        "UPDATE OR REPLACE programmes SET participant=:new, author='', reason=''"
        f" WHERE participant=:old AND {person.of_site('programmes')}",
        {"new": new, "old": code, "site": person.site},
    ).rowcount
    changed += db.execute(
        "UPDATE people_events SET participant=?, reason='', recorded_by=''"
        " WHERE participant=? AND site=?",
        (new, code, person.site),
    ).rowcount
    db.execute(
        "UPDATE correspondents SET participant=?, state='revoked', device='{}' WHERE participant=?",
        (new, code),
    )  # what a computer at home still writes would have the old code
    row = db.execute("SELECT created_at, site FROM participants WHERE code=?", (code,)).fetchone()
    if row is not None:
        db.execute("DELETE FROM participants WHERE code=?", (code,))
        db.execute("INSERT OR IGNORE INTO participants (code, created_at, site) VALUES (?,?,?)",
                   (new, *row))  # fmt: skip
    return changed + (row is not None)
