"""Records of people, append-only: a correction adds a version, and the earlier ones are kept.

What a record holds is declared by its kind (`records.kind`): adverse events, scores of instruments,
pain and tiredness, and what a clinic declares. Answers to questions between attempts are read as
records, too; their table follows from the logs of sessions, and nobody corrects it.
"""

import re
import secrets
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, Literal

import msgspec

from sar_tui.model.language import ENGLISH, Language
from sar_tui.records.kind import Kind, KindError, RecordError, Value, find
from sar_tui.store import tables
from sar_tui.store.counted import LIVE
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.participants import add as add_participant
from sar_tui.store.participants import admit, check_own
from sar_tui.store.training_days import utc

TOLD = "told in a pause"
"""Answer that follows from a key in a pause, and stands in the session's log."""
OF_LEDGERS = ("enrolment", "code-break")
"""Kinds that nobody corrects: what is drawn in a study next follows from the first, and the second
tells who was unblinded.
"""
ANSWER = "answer"
"""Kind of what was asked between attempts."""
_BETWEEN = "; "
"""Stands between several options, or labels."""
_DAY = len("2026-03-01")
_LOCAL = re.compile(r"\d{4}-\d{2}-\d{2}([ T]\d{2}:\d{2})?")


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """A record as it is known now.

    Attributes:
        id: the same in all its versions.
        version: 1 when it was entered; each correction adds one, and the earlier ones are kept.
        kind: name of its kind.
        at: local date, or date and time, that it is of; in UTC, with an offset, if a program
            noted it.
        session: the session that it belongs to; None if to none. ``seat``: of the participant.
        moment: before or after the session, or in a pause of it; empty without one.
        content: the values by the names of the kind's fields.
        removed: True if it was entered by mistake.
        recorded_at: UTC. ``recorded_by``: the login name of the user who recorded this version.
    """

    id: str
    version: int = 1
    kind: str
    participant: str
    at: str
    session: str | None = None
    seat: str = "A"
    moment: str = ""
    content: dict[str, Value] = {}
    removed: bool = False
    recorded_at: str = ""
    recorded_by: str = ""

    @property
    def day(self) -> str:
        """The date that it is of."""
        return self.at[:_DAY]


_FIELDS = Record.__struct_fields__


PAUSES = (
    "WITH given (id, session, seat, kind, at) AS (VALUES (?, ?, ?, ?, ?))"
    " INSERT OR IGNORE INTO records (id, version, kind, participant, session, seat, moment, at,"
    " content, recorded_at)"
    " SELECT id, 1, kind, participant, session, seat, 'pause', at,"
    f" json_object('answer', '{TOLD}'), at FROM given JOIN seats USING (session, seat)"
)
"""Statement that stores what a key in a pause said: id, session, seat, kind, time."""


# --- entering and correcting


def add(
    db: sqlite3.Connection,
    kind: Kind,
    participant: str,
    at: str,
    given: Mapping[str, Value | None],
    *,
    session: str | None = None,
    seat: str = "A",
    moment: str = "",
    author: str = "",
    is_new: bool = False,
    now: datetime | None = None,
    tr: Language = ENGLISH,
) -> Record:
    """Check and store a record, and return it as it is stored.

    Of a kind that is recorded once a day, it is a new version of that day's record.

    Args:
        db: the database.
        kind: its kind.
        participant: code of the participant.
        at: the local date, or date and time, that it is of; empty for ``now``.
        given: values or typed texts, by field.
        session, seat, moment: where it belongs.
        author: who records it.
        is_new: as in `participants.admit`.
        now: when it is recorded; None for the present.
        tr: the language in which an error is raised.

    Raises:
        StoreError: the participant is not known, a value is not valid, or the disk cannot write.
    """
    date = check_date(kind, at, tr) if at else _now_of(kind, now)
    content = _checked(kind, given, tr)
    if kind.entered_by == "therapist":
        (code,) = admit(db, [participant], is_new=is_new)
    else:  # a new participant is added with the first answer: the session may not begin
        code = check_own(participant)
    record = Record(
        id=_new_id(db),
        kind=kind.name,
        participant=code,
        at=date,
        session=session or (session_at(db, code, date) if _is_local(kind) else None),
        seat=seat,
        moment=moment,
        content=content,
        recorded_at=utc(now),
        recorded_by=author,
    )
    if kind.once_a_day and (earlier := _of_day(db, record)):
        record = msgspec.structs.replace(record, id=earlier.id, version=earlier.version + 1)
    add_participant(db, code, now)
    return _insert(db, record)


def _new_id(db: sqlite3.Connection) -> str:
    """Return an id that no record has."""
    while True:
        id = secrets.token_hex(5)
        if not db.execute("SELECT 1 FROM records WHERE id=?", (id,)).fetchone():
            return id


def correct(
    db: sqlite3.Connection,
    id: str,
    given: Mapping[str, Value | None],
    *,
    at: str | None = None,
    removed: bool = False,
    author: str = "",
    tr: Language = ENGLISH,
) -> Record:
    """Store a new version of a record, and return it; the earlier versions stay.

    Args:
        db: the database.
        id: of the record.
        given: the fields that change; the others keep their values.
        at: the date that it is of; None keeps it.
        removed: True if it was entered by mistake, and counts no longer.
        author: who corrects it.
        tr: the language in which an error is raised.

    Raises:
        StoreError: there is no such record, it is of another site, of a session's log or of
            `OF_LEDGERS`, nothing would change, a value is not valid, or the disk cannot write.
    """
    last = find_record(db, id)
    _, sign, site = id.partition("@")
    if sign:
        raise StoreError(
            tr("The record {id} is of {site}: it can be corrected only there.", id=id, site=site),
            bad_input=True,
        )
    if last.content.get("answer") == TOLD:
        raise StoreError(
            tr(
                "The record {id} is part of the log of its session, and stays as it is. A note "
                "can say more.",
                id=id,
            ),
            bad_input=True,
        )
    if last.kind in OF_LEDGERS:
        raise StoreError(
            tr("The record {id} is part of the ledger of a study, and stays as it is.", id=id),
            bad_input=True,
        )
    kind = kind_of(last.kind)
    changed = msgspec.structs.replace(
        last,
        at=last.at if at is None else check_date(kind, at, tr),
        content=_checked(kind, {**last.content, **given}, tr),
        removed=removed,
    )
    if changed == last:
        raise StoreError(
            tr("Nothing would change. Give another date, or another value."), bad_input=True
        )
    changed = msgspec.structs.replace(
        changed, version=last.version + 1, recorded_at=utc(), recorded_by=author
    )
    return _insert(db, changed)


def attach(db: sqlite3.Connection, session: str, participants: Sequence[str], since: str) -> None:
    """Give records that were entered since a time, before the session began, their session.

    Raises:
        StoreError: the disk cannot write.
    """
    slots = ",".join("?" for _ in participants)
    with transaction(db) as connection:
        connection.execute(
            "UPDATE records SET session=? WHERE session IS NULL AND moment='before'"
            f" AND recorded_at>=? AND participant IN ({slots})",
            (session, since, *participants),
        )


_NO_DATE = {
    False: "{field} is a date, such as 2026-03-01, not {given}.",
    True: "{field} is a date, such as 2026-03-01, or 2026-03-01T14:30, not {given}.",
}
"""Problem of a text that is no date, for kinds without and with a time of day."""


def check_date(kind: Kind, text: str, tr: Language = ENGLISH) -> str:
    """Return a date as it is stored: "2026-03-01", or "2026-03-01 14:30" if the kind has a time.

    Raises:
        StoreError: it is no date, or in the future.
    """
    given = text.strip()
    try:
        if not _LOCAL.fullmatch(given) or (len(given) > _DAY and not kind.has_time):
            raise ValueError
        date = datetime.fromisoformat(given)
    except ValueError:
        problem = tr(_NO_DATE[kind.has_time], field=tr(kind.when), given=f"{text!r:.40}")
        raise StoreError(problem, bad_input=True) from None
    if date > datetime.now():
        problem = tr("{field} {date} is in the future.", field=tr(kind.when), date=given)
        raise StoreError(problem, bad_input=True)
    return given.replace("T", " ")


def _is_local(kind: Kind) -> bool:
    """Return True if the dates of a kind are local ones, as a therapist writes them."""
    return kind.entered_by == "therapist"


def _now_of(kind: Kind, now: datetime | None) -> str:
    """Return a time, by default the present, as records of a kind have it."""
    if not _is_local(kind):
        return utc(now)
    form = "%Y-%m-%d %H:%M" if kind.has_time else "%Y-%m-%d"
    return (now or datetime.now()).astimezone().strftime(form)


def session_at(db: sqlite3.Connection, participant: str, at: str) -> str | None:
    """Return the live session of a participant that was under way at a local time; None without a
    time of day, or without a session.
    """
    if len(at) == _DAY:
        return None
    time = datetime.fromisoformat(at).astimezone(UTC)
    row = db.execute(
        "SELECT sessions.id FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
        f" WHERE participant=? AND {LIVE} AND started_at < ? AND ended_at >= ?"
        " ORDER BY seats.rowid DESC LIMIT 1",
        (participant, (time + timedelta(minutes=1)).isoformat(), time.isoformat()),
    ).fetchone()
    return row[0] if row else None


def kind_of(name: str) -> Kind:
    """Return a kind by its name. Raises StoreError."""
    try:
        return find(name)
    except KindError as error:
        raise StoreError(str(error), bad_input=True) from error


def _checked(kind: Kind, given: Mapping[str, Value | None], tr: Language) -> dict[str, Value]:
    try:
        return kind.read(given, tr)
    except RecordError as error:
        raise StoreError(str(error), bad_input=True) from error


def _of_day(db: sqlite3.Connection, record: Record) -> Record | None:
    """Return the newest version of a record of the same kind, person and day."""
    same = listing(db, kinds=(record.kind,), participant=record.participant, with_removed=True)
    return next((one for one in same if one.day == record.day), None)


def _insert(db: sqlite3.Connection, record: Record) -> Record:
    with transaction(db) as connection:
        store(connection, record)
    return record


def store(connection: sqlite3.Connection, record: Record) -> None:
    """Store a record that was checked, in a transaction of the caller."""
    check_own(record.participant)
    values = msgspec.structs.asdict(record)
    values["content"] = msgspec.json.encode(record.content).decode()
    connection.execute(tables.RECORDS.insert(*values), tuple(values.values()))


# --- reading


def listing(
    db: sqlite3.Connection,
    *,
    kinds: Iterable[str] = (),
    participant: str | None = None,
    session: str | None = None,
    only: Literal["", "without session"] = "",
    with_removed: bool = False,
) -> list[Record]:
    """Return the records as they are known now, by date; only those asked for.

    Args:
        db: the database.
        kinds: names of kinds; all if empty.
        participant, session: None for all.
        only: those that belong to no session, if asked for.
        with_removed: True for those entered by mistake, too.
    """
    wanted = tuple(kinds)
    conditions, values = _conditions(wanted, participant, session)
    if only == "without session":
        conditions.append("session IS NULL")
    newest = {record.id: record for record in _select(db, conditions, values)}
    kept = [record for record in newest.values() if with_removed or not record.removed]
    if not only and (not wanted or ANSWER in wanted):
        kept += _answers(db, participant, session)
    return sorted(kept, key=lambda record: (record.at.replace("T", " "), record.recorded_at))


def of_sessions(
    db: sqlite3.Connection, sessions: Sequence[str], kinds: Iterable[str]
) -> dict[str, list[Record]]:
    """Return the records of some sessions, as they are known now, by session."""
    conditions, values = _conditions(tuple(kinds), None, None)
    wanted = msgspec.json.encode(list(sessions)).decode()
    conditions.append("session IN (SELECT value FROM json_each(?))")
    newest = {record.id: record for record in _select(db, conditions, [*values, wanted])}
    found: dict[str, list[Record]] = {}
    for record in newest.values():
        if record.session and not record.removed:
            found.setdefault(record.session, []).append(record)
    return found


def of_everyone(db: sqlite3.Connection, kinds: Iterable[str]) -> list[Record]:
    """Return the records of some kinds of this site's participants, as they are known now.

    Each participant's are looked up: it takes no longer if there are many records of other kinds.
    """
    wanted = tuple(kinds)
    conditions, values = _conditions(wanted, None, None)
    known = "participant IN (SELECT code FROM participants WHERE site='')"
    newest = {record.id: record for record in _select(db, [known, *conditions], values)}
    return [record for record in newest.values() if not record.removed]


def find_record(db: sqlite3.Connection, id: str) -> Record:
    """Return a record as it is known now. Raises StoreError if there is none."""
    return versions(db, id)[-1]


def versions(db: sqlite3.Connection, id: str) -> list[Record]:
    """Return all versions of a record, the first one first. Raises StoreError if there is none."""
    found = list(_select(db, ["id=?"], [id]))
    if not found:
        raise StoreError(
            f"There is no record {id}. `sar-tui record list` lists them.", bad_input=True
        )
    return found


def _conditions(
    kinds: tuple[str, ...], participant: str | None, session: str | None
) -> tuple[list[str], list[Any]]:
    """Return conditions of a query, and their values."""
    conditions, values = [], list[Any]()
    if kinds:
        conditions.append(f"kind IN ({','.join('?' for _ in kinds)})")
        values += kinds
    for name, value in (("participant", participant), ("session", session)):
        if value is not None:
            conditions.append(f"{name}=?")
            values.append(value)
    return conditions, values


def _select(
    db: sqlite3.Connection, conditions: Sequence[str], values: Sequence[Any]
) -> Iterator[Record]:
    """Yield versions of records in the order in which they were recorded."""
    where = f"WHERE {' AND '.join(conditions)}" if conditions else ""
    rows = db.execute(
        f"SELECT {', '.join(_FIELDS)} FROM records {where} ORDER BY version, rowid", values
    )
    for row in rows:
        known = dict[str, Any](zip(_FIELDS, row, strict=True))
        content = msgspec.json.decode(known["content"], type=dict[str, Value])
        yield Record(**{**known, "content": content, "removed": bool(known["removed"])})


def _answers(
    db: sqlite3.Connection, participant: str | None, session: str | None
) -> Iterator[Record]:
    """Yield the answers to questions between attempts, and the other steps there."""
    conditions, values = _conditions((), participant, session)
    where = " AND ".join([LIVE if session is None else "1", *conditions])
    rows = db.execute(
        "SELECT answers.session, participant, seat, number, attempt, step, kind, text, labels,"
        " answers.status, answer, answered_ns, clock_anchor FROM answers"
        " JOIN seats USING (session, seat) JOIN runs USING (session, run)"
        f" JOIN sessions ON sessions.id=answers.session WHERE {where} ORDER BY session, number",
        values,
    )
    for (
        id,
        code,
        seat,
        number,
        attempt,
        step,
        form,
        text,
        labels,
        status,
        answer,
        at,
        clock,
    ) in rows:
        content: dict[str, Value] = {
            "number": number,
            "attempt": attempt,
            "step": step,
            "form": form,
            "question": text,
            "status": status,
        }
        options = msgspec.json.decode(labels)
        if options:
            content["labels"] = _BETWEEN.join(options)
        given = None if answer is None else msgspec.json.decode(answer)
        yield Record(
            id=f"{id}-{number}",
            kind=ANSWER,
            participant=code,
            at=_wall_time(clock, at),
            session=id,
            seat=seat,
            content=content | _given(form, options, given),
        )


def _given(form: str, options: Sequence[str], answer: Any) -> dict[str, Value]:
    """Return an answer as a number with its word, as chosen options, or as words."""
    if answer is None:
        return {}
    if isinstance(answer, list):
        return {"chosen": _BETWEEN.join(map(str, answer))}
    if isinstance(answer, int | float):
        is_labelled = form == "likert" and 0 < answer <= len(options)
        return {"value": answer} | ({"chosen": options[int(answer) - 1]} if is_labelled else {})
    return {"words" if form == "text" else "chosen": answer}


def _wall_time(clock_anchor: str, at: int) -> str:
    """Return the UTC of a stamp of a run's steady clock."""
    anchor = msgspec.json.decode(clock_anchor)
    began = datetime.fromisoformat(anchor["utc"])
    return (began + timedelta(microseconds=(at - anchor["clock_ns"]) / 1000)).isoformat()
