"""Rows of a letter: those that one side has of a person and the other lacks, and what they may change.

They are a database of one person, which is merged like any other (`store.merge`).
"""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Literal
from urllib.parse import quote

import msgspec

from sar_tui.letterbox.sealing import packed
from sar_tui.store import schema, sites
from sar_tui.store.database import FILE, StoreError, create_file
from sar_tui.store.locks import Held, hold
from sar_tui.store.merge.ownership import leave_out
from sar_tui.store.tables import SESSION_TABLES, TABLES

Role = Literal["clinic", "home"]
Contents = dict[str, dict[str, str]]
"""By table the key of each row in words, with a fingerprint of the row when it was sent."""
OF_CLINIC = ("programmes", "people_events")
"""Tables that only a clinic writes."""
KINDS_OF_CLINIC = ("message-home", "training-days", "report-request")
"""Kinds of record that only a clinic writes: they tell a person at home something."""
_AT_ONCE = 20
"""Sessions in a letter."""
_NEWEST = 40
"""Sessions from before a home joined that its computer gets, so that levels and plans go on."""
_OWN = {
    "sessions": "SELECT id, status || ' ' || coalesce(ended_at, '') || ' ' || coalesce((SELECT "
    "max(seq) FROM {schema}.messages WHERE session_number=(SELECT number FROM "
    "{schema}.session_numbers WHERE id=sessions.id)), 0) FROM {schema}.sessions WHERE site='' AND "
    "mode<>'demonstration' AND id IN (SELECT session FROM {schema}.seats GROUP BY session HAVING "
    "count(*)=1 AND min(participant)=?) ORDER BY rowid",
    "records": "SELECT id || ' ' || version, coalesce(session, '') FROM {schema}.records WHERE "
    "site='' AND participant=? ORDER BY rowid",
    "programmes": "SELECT task || ' ' || version, '' FROM {schema}.programmes WHERE site='' AND "
    "participant=? ORDER BY rowid",
    "people_events": "SELECT id, '' FROM {schema}.people_events WHERE site='' AND participant=? "
    "ORDER BY at, id",
}
"""Query of the rows of a person: the key in words, and a fingerprint of the row."""
_KEYS = {
    "sessions": "id",
    "records": "id || ' ' || version",
    "programmes": "task || ' ' || version",
    "people_events": "id",
}


def of_person(db: sqlite3.Connection, participant: str, schema: str = "main") -> Contents:
    """Return all rows of a person that a letter may bring."""
    return {
        table: dict(db.execute(query.format(schema=schema), (participant,)).fetchall())
        for table, query in _OWN.items()
    }


def news(
    db: sqlite3.Connection,
    participant: str,
    known: Contents,
    *,
    writer: Role,
    running: Iterable[str],
    is_first: bool,
) -> Iterator[Contents]:
    """Yield the contents of letters with what the other side does not know, the oldest first.

    Args:
        db: the database.
        participant: whose rows they are.
        known: what the other side has.
        writer: which side writes.
        running: sessions that are not finished.
        is_first: the other side has joined since: a clinic sends only the newest sessions.
    """
    there = of_person(db, participant)
    found = {
        table: {
            key: fingerprint
            for key, fingerprint in rows.items()
            if known.get(table, {}).get(key) != fingerprint
        }
        for table, rows in there.items()
        if writer == "clinic" or table not in OF_CLINIC
    }
    skipped = set(running)
    sessions = [
        (id, fingerprint) for id, fingerprint in found.pop("sessions").items() if id not in skipped
    ]
    older: dict[str, str] = {}
    if is_first and writer == "clinic":
        older = dict(sessions[:-_NEWEST])
        sessions = sessions[-_NEWEST:]
    # a record of a session waits for it; one of a session that is never sent is not sent either
    never = older.keys() | known.get(NOT_SENT, {}).keys() | skipped
    at_reader = {*known.get("sessions", ()), *(id for id, _ in sessions)} - never
    records = {
        key: session
        for key, session in found.pop("records").items()
        if not session or session in at_reader
    }
    rest = {table: rows for table, rows in found.items() if rows}
    if older:  # said to be known, so that they are not sent later
        rest[NOT_SENT] = older
    step = _AT_ONCE if is_first else 1
    for start in range(0, max(len(sessions), 1), step):
        some = dict(sessions[start : start + step])
        of_later = {id for id, _ in sessions[start + step :]}
        its = {key: session for key, session in records.items() if session not in of_later}
        records = {key: session for key, session in records.items() if key not in its}
        parts = {"sessions": some, "records": its, **(rest if not start else {})}
        contents = {table: rows for table, rows in parts.items() if rows}
        if contents:
            yield contents


NOT_SENT = "older sessions"
"""In the place of a table: sessions that the other side does not get, and are not news either."""


def elsewhere(contents: Contents) -> dict[str, str]:
    """Return the session of each record of a letter whose session is not in it."""
    return {
        key: session
        for key, session in contents.get("records", {}).items()
        if session and session not in contents.get("sessions", {})
    }


def known_to(rows: Iterable[Contents]) -> Contents:
    """Return what the other side has, by the contents of letters in their order."""
    known: Contents = {}
    for contents in rows:
        for table, keys in contents.items():
            known.setdefault("sessions" if table == NOT_SENT else table, {}).update(keys)
    return known


# --- the database of a letter


WORK = ".letter-"
"""Beginning of the names of folders in a data folder in which letters are packed and unpacked."""


class Busy(StoreError):
    """Another program exchanges letters in this data folder now."""


@contextmanager
def alone(data: Path) -> Iterator[None]:
    """Be the only program that packs and unpacks letters in a data folder; remove what one that was
    killed has left. Raises Busy.
    """
    try:
        held = hold(data, "letterbox", "letters")
    except Held:
        raise Busy(
            "Letters are being exchanged already. Try again in a moment.", temporary=True
        ) from None
    try:
        for left in data.glob(f"{WORK}*"):
            shutil.rmtree(left, ignore_errors=True)
        yield
    finally:
        held.release()


@contextmanager
def work_folder(data: Path) -> Iterator[Path]:
    """Give a private folder in a data folder, and remove it afterwards. Raises StoreError."""
    try:
        place = tempfile.mkdtemp(prefix=WORK, dir=data)
    except OSError as error:
        raise StoreError(
            f"Nothing can be written to {data} ({error.strerror}).", temporary=True
        ) from error
    try:
        yield Path(place)
    finally:
        shutil.rmtree(place, ignore_errors=True)


def pack(data: Path, participant: str, contents: Contents) -> bytes:
    """Return the rows of a letter as a packed database; empty if there are none.

    Raises:
        StoreError: the database cannot be read, or the disk is full.
    """
    if not any(contents.get(table) for table in _OWN):
        return b""
    try:
        return _packed(data, participant, contents)
    except (OSError, sqlite3.Error) as error:
        raise StoreError(
            f"A letter cannot be written now: {getattr(error, 'strerror', None) or error}.",
            temporary=True,
        ) from error


def _packed(data: Path, participant: str, contents: Contents) -> bytes:
    with work_folder(data) as place:
        path = place / "letter.db"
        create_file(path)
        with closing(
            sqlite3.connect(f"file:{quote(str(path))}", uri=True, isolation_level=None)
        ) as db:
            for setting in ("journal_mode=OFF", "synchronous=OFF"):
                db.execute(f"PRAGMA {setting}")
            schema.create(db)
            db.execute("ATTACH ? AS own", (f"file:{quote(str((data / FILE).absolute()))}?mode=ro",))
            db.execute("BEGIN")
            db.execute("DELETE FROM topics")
            for table, condition, keys in _selected(contents):
                listed = ", ".join(f'"{name}"' for name in TABLES[table].names)
                db.execute(
                    f"INSERT INTO main.{table} ({listed}) SELECT {listed} FROM own.{table} WHERE "
                    f"{condition} {'' if TABLES[table].options else 'ORDER BY rowid'}",
                    {"keys": msgspec.json.encode(keys).decode(), "who": participant},
                )
            db.execute(
                "UPDATE records SET session=NULL WHERE session NOT IN (SELECT id FROM sessions)"
            )
            db.execute("COMMIT")
            db.execute("DETACH own")
        return packed(path.read_bytes())


_GIVEN = "(SELECT value FROM json_each(:keys))"


def _selected(contents: Contents) -> Iterator[tuple[str, str, list[str]]]:
    """Yield each table of a letter, the condition of its rows, and the keys in the condition."""
    sessions = list(contents.get("sessions", ()))
    yield "participants", "code=:who", []
    yield "site", "1", []
    if sessions:
        yield "topics", "1", []
        yield "sessions", f"id IN {_GIVEN}", sessions
        yield "session_numbers", f"id IN {_GIVEN}", sessions
        numbers = f"(SELECT number FROM main.session_numbers WHERE id IN {_GIVEN})"
        yield "messages", f"session_number IN {numbers}", sessions
        for table in SESSION_TABLES:
            yield table, f"session IN {_GIVEN}", sessions
    for table, key in _KEYS.items():
        if table != "sessions" and contents.get(table):
            yield table, f"participant=:who AND {key} IN {_GIVEN}", list(contents[table])


# --- what a letter may change


def check_rows(
    db: sqlite3.Connection,
    participant: str,
    writer: Role,
    sessions: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Check the database of a letter, attached as ``other``: it touches only its own person.

    Sessions that were moved to another person here are taken out of it.

    Args:
        db: this database, with the other one attached.
        participant: the person of whom the letter's writer may say something.
        writer: the side that signed the letter.
        sessions: the session of each record whose session is not in the letter.

    Raises:
        StoreError: it holds something else; or, if that is temporary, a session must come first.
    """
    allowed = {*_OF_PERSON, *_OF_SESSIONS, "topics", "site"}
    if writer == "clinic":
        allowed |= set(OF_CLINIC)
    for table in TABLES:
        if table not in allowed and db.execute(f"SELECT 1 FROM other.{table} LIMIT 1").fetchone():
            raise _refused(f"it has rows of {table}")
    if db.execute("SELECT code FROM other.site").fetchall() != [(sites.own(db),)]:
        raise _refused("it is of another site")
    for table in sorted(allowed):
        unnamed = " OR ".join(f'"{name}" IS NULL' for name in TABLES[table].key) or "0"
        if db.execute(f"SELECT 1 FROM other.{table} WHERE {unnamed} LIMIT 1").fetchone():
            raise _refused(f"it has {table} without a name")
    _leave_out_moved(db, participant)
    _name_sessions(db, participant, sessions)
    given = {"who": participant, "kinds": msgspec.json.encode(KINDS_OF_CLINIC).decode()}
    for what, query in _FOREIGN.items():
        if writer == "clinic" and what in _FOREIGN_OF_HOME:
            continue
        if db.execute(f"SELECT 1 {query} LIMIT 1", given).fetchone():
            raise _refused(what)
    for table in (*_OF_PERSON, "sessions", *OF_CLINIC):
        if db.execute(f"SELECT 1 FROM other.{table} WHERE site<>'' LIMIT 1").fetchone():
            raise _refused(f"it has {table} of another site")


def _leave_out_moved(db: sqlite3.Connection, participant: str) -> None:
    """Take out sessions that a letter of this person has brought before, and that were moved to
    another person since.
    """
    moved = db.execute(
        f"SELECT there.id FROM other.sessions AS there WHERE EXISTS {_SAT.format(session='there.id')}"
        " AND EXISTS (SELECT 1 FROM main.letters JOIN main.correspondents AS writer ON "
        "writer.id=correspondent, json_each(contents, '$.sessions') AS brought WHERE "
        "writer.participant=:who AND brought.key=there.id)",
        {"who": participant},
    ).fetchall()
    leave_out(db, [id for (id,) in moved])


def _name_sessions(db: sqlite3.Connection, participant: str, sessions: Mapping[str, str]) -> None:
    """Give records of sessions that are not in the letter their session."""
    for key, session in sessions.items():
        id, _, version = key.rpartition(" ")
        row = db.execute(
            "SELECT max(participant IS :who) FROM main.seats WHERE session=:session",
            {"who": participant, "session": session},
        ).fetchone()
        if row[0] is None:
            raise StoreError(
                f"A letter of {participant} waits for a session that has not arrived yet.",
                temporary=True,
            )
        if not row[0]:  # moved to another person meanwhile
            db.execute("DELETE FROM other.records WHERE id=? AND version=?", (id, version))
            continue
        db.execute(
            "UPDATE other.records SET session=? WHERE id=? AND version=?", (session, id, version)
        )


_OF_PERSON = ("participants", "records")
_OF_SESSIONS = ("sessions", "session_numbers", "messages", *SESSION_TABLES)
_SAT = (
    "(SELECT 1 FROM main.seats AS sat WHERE sat.session={session} AND sat.participant IS NOT :who)"
)
_FOREIGN: Mapping[str, str] = {
    "it has another person": "FROM other.participants WHERE code IS NOT :who",
    "it has a session of another person": "FROM other.seats WHERE participant IS NOT :who",
    "it has a session without a person": "FROM other.sessions WHERE NOT EXISTS (SELECT 1 FROM "
    "other.seats WHERE session=sessions.id)",
    "it has rows of a session that it does not bring": " UNION ALL SELECT 1 ".join(
        [
            "FROM other.session_numbers WHERE id NOT IN (SELECT id FROM other.sessions)",
            "FROM other.messages WHERE session_number NOT IN (SELECT number FROM "
            "other.session_numbers)",
            *(
                f"FROM other.{table} WHERE session NOT IN (SELECT id FROM other.sessions)"
                for table in SESSION_TABLES
            ),
        ]
    ),
    "it would change a session of another person": "FROM other.sessions AS there WHERE EXISTS "
    + _SAT.format(session="there.id"),
    "it would change a session of another site": "FROM other.sessions AS there JOIN main.sessions "
    "AS here USING (id) WHERE here.site<>''",
    "it has a record of another person": "FROM other.records WHERE participant IS NOT :who",
    "it would change a record of another person": "FROM other.records AS there JOIN main.records "
    "AS here USING (id) WHERE here.participant IS NOT :who",
    "it has a record of a session that is not the person's": "FROM other.records AS there WHERE "
    "session NOTNULL AND NOT EXISTS (SELECT 1 FROM other.sessions WHERE id=there.session) AND NOT "
    "EXISTS (SELECT 1 FROM main.seats AS sat WHERE sat.session=there.session AND "
    "sat.participant=:who)",
    "it has a version that is none": "FROM (SELECT version FROM other.records UNION ALL SELECT "
    "version FROM other.programmes) WHERE typeof(version)<>'integer' OR version NOT BETWEEN 1 AND "
    "1000000",
    "it has a programme of another person": "FROM other.programmes WHERE participant IS NOT :who",
    "it has an event of another person": "FROM other.people_events WHERE participant IS NOT :who",
    "it would change a record of the clinic": "FROM other.records AS there JOIN main.records AS here "
    "USING (id) WHERE NOT EXISTS (SELECT 1 FROM main.letters JOIN main.correspondents ON "
    "correspondents.id=correspondent, json_each(contents, '$.records') AS brought WHERE direction='in' "
    "AND correspondents.participant=:who AND brought.key LIKE there.id || ' %') AND NOT EXISTS (SELECT 1 FROM "
    "main.records AS same WHERE same.id=there.id AND same.version=there.version AND "
    "same.kind=there.kind AND same.content=there.content AND same.recorded_at=there.recorded_at)",
    "it has a record that only a clinic writes": "FROM other.records AS there WHERE kind IN "
    "(SELECT value FROM json_each(:kinds)) AND NOT EXISTS (SELECT 1 FROM main.records AS here "
    "WHERE here.id=there.id AND here.version=there.version AND here.content=there.content)",
}
"""Rows that a letter must not have, in words, and the query of each."""
_FOREIGN_OF_HOME = (
    "it has a record that only a clinic writes",
    "it would change a record of the clinic",
)


def _refused(what: str) -> StoreError:
    return StoreError(what, bad_input=True)
