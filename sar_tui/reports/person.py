"""Everything that is stored of one person, to be read by that person."""

import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.records.kind import KindError, find
from sar_tui.reports.sections import Section, Table
from sar_tui.store import exports, people_events, programmes, records, sessions, studies
from sar_tui.store.exports import LedgerEntry
from sar_tui.store.people_events import PersonEvent
from sar_tui.store.programmes import Programme
from sar_tui.store.records import Record
from sar_tui.store.sessions import local_time


class Note(msgspec.Struct, frozen=True):
    """A note on a session, or an event mark."""

    session: str
    author: str
    label: str
    text: str


class StudyRow(msgspec.Struct, frozen=True, kw_only=True):
    """A session, or a record, of a person in a study: an enrolment, a consent, a deviation and
    others.

    Attributes:
        at: when it was; ``what``: in words. ``details``: the rest, in words.
        visit, block: the place in the study; empty of what has none.
        id: of the session or the record.
    """

    study: str
    at: str
    what: str
    visit: str
    block: str
    details: str
    recorded_by: str
    id: str


class PersonReport(msgspec.Struct, frozen=True, kw_only=True):
    """All that is stored of a person.

    Attributes:
        sessions: as listed, the newest first. ``shared``: the ids of those for two. ``blind``: of
            those of a study that is blind still, without settings, which tell the condition.
        records: all versions.
        studies: their rows in studies, by time.
        programmes: all versions, by task.
        exports: those that held their sessions.
    """

    participant: str
    added: str | None
    events: list[PersonEvent]
    sessions: list[dict[str, Any]]
    shared: list[str]
    blind: list[str]
    records: list[Record]
    studies: list[StudyRow]
    notes: list[Note]
    programmes: dict[str, list[Programme]]
    exports: list[LedgerEntry]


_TELL_CONDITIONS = ("parameters", "theme", "software")
"""Columns of sessions that a blind study does not tell; the software has the hash of the theme."""


def read(db: sqlite3.Connection, folder: Path, code: str) -> PersonReport:
    """Read all that is stored of a participant. Raises StoreError."""
    listed = sessions.listing(db, folder, participant=code, also_damaged=True)
    blind_studies = studies.blind(db)
    blind = [row["id"] for row in listed if (row["study"] or {}).get("study") in blind_studies]
    hidden = dict.fromkeys(_TELL_CONDITIONS)
    listed = [row | hidden if row["id"] in blind else row for row in listed]
    ids = {row["id"] for row in listed}
    added = db.execute("SELECT created_at FROM participants WHERE code=?", (code,)).fetchone()
    known = records.listing(db, participant=code, with_removed=True)
    versions = [
        version
        for record in known
        for version in (records.versions(db, record.id) if record.kind != "answer" else [record])
    ]
    notes = [
        Note(*row)
        for row in db.execute(
            "SELECT notes.session, author, label, text FROM notes JOIN seats USING (session)"
            " WHERE participant=? ORDER BY notes.rowid",
            (code,),
        )
    ]
    return PersonReport(
        participant=code,
        added=added[0] if added else None,
        events=people_events.events(db, [code]),
        sessions=listed,
        shared=[row["id"] for row in listed if row["partner"]],
        blind=blind,
        records=versions,
        studies=_of_studies(listed, versions),
        notes=notes,
        programmes={
            task: programmes.versions(db, code, task) for task in programmes.tasks(db, code)
        },
        exports=[entry for entry in exports.ledger(db) if ids.intersection(entry.sessions)],
    )


_PLACE = ("study", "visit", "block")


def _of_studies(listed: Sequence[dict[str, Any]], versions: Sequence[Record]) -> list[StudyRow]:
    """Return the rows of a person in studies."""
    found = [_of_session(row) for row in listed if row["study"]]
    found += [_of_record(record) for record in versions if _is_of_study(record)]
    return sorted(found, key=lambda row: row.at)


def _of_session(row: dict[str, Any]) -> StudyRow:
    place = row["study"]
    details = {name: value for name, value in place.items() if name not in _PLACE}
    return StudyRow(
        **{name: str(place.get(name, "")) for name in _PLACE},
        at=row["started_at"],
        what=f"Session, {row['task']}",
        details=_in_words({**details, "status": row["status"]}),
        recorded_by="",
        id=row["id"],
    )


def _of_record(record: Record) -> StudyRow:
    kind = find(record.kind)
    titles = {field.name: field.title for field in kind.fields}
    details = {
        titles.get(name, name): value
        for name, value in record.content.items()
        if name not in _PLACE
    }
    return StudyRow(
        **{name: str(record.content.get(name, "")) for name in _PLACE},
        at=record.at,
        what=f"{kind.title}{', removed' * record.removed}",
        details=_in_words(details),
        recorded_by=record.recorded_by,
        id=record.id,
    )


def _is_of_study(record: Record) -> bool:
    try:
        return find(record.kind).group == "study"
    except KindError:
        return False


def _in_words(values: Mapping[str, object]) -> str:
    return "; ".join(f"{name}: {value}" for name, value in values.items())


def sections(found: PersonReport) -> list[Section]:
    """Return the report in words."""
    return [
        Section("What is stored", _summary(found)),
        *_listed(
            "Withdrawal, erasure",
            ("when", "what", "data", "reason", "by"),
            [
                (
                    local_time(each.at),
                    each.event,
                    each.details.data,
                    each.reason,
                    each.recorded_by,
                )
                for each in found.events
            ],
        ),
        *_listed(
            "Sessions",
            ("session", "began", "task", "status", "mode", "attempts"),
            [
                (
                    row["id"],
                    local_time(row["started_at"], row["utc_offset_s"]),
                    row["task"],
                    row["status"],
                    row["mode"],
                    str(row["attempts"]),
                )
                for row in found.sessions
            ],
        ),
        *_listed(
            "Studies",
            ("when", "study", "what", "visit", "block", "details", "by"),
            [
                (
                    _when(each.at),
                    each.study,
                    each.what,
                    each.visit,
                    each.block,
                    each.details,
                    each.recorded_by,
                )
                for each in found.studies
            ],
        ),
        *_listed(
            "Records",
            ("date", "record", "version", "kind", "contents", "by"),
            [
                (
                    _when(each.at),
                    each.id,
                    str(each.version),
                    each.kind,
                    _contents(each),
                    each.recorded_by,
                )
                for each in found.records
                if not _is_of_study(each)
            ],
        ),
        *_listed(
            "Notes",
            ("session", "by", "label", "text"),
            [(each.session, each.author, each.label, each.text) for each in found.notes],
        ),
        *_listed(
            "Programmes",
            ("task", "version", "saved", "settings", "reason", "by"),
            [
                (
                    task,
                    str(each.version),
                    local_time(each.created_at),
                    "; ".join(f"{name}: {value}" for name, value in each.parameters.items()),
                    each.reason,
                    each.author,
                )
                for task, versions in found.programmes.items()
                for each in versions
            ],
        ),
        *_listed(
            "Exports",
            ("when", "for", "format", "sessions", "by"),
            [
                (
                    local_time(each.exported_at),
                    each.recipient,
                    each.format,
                    str(len(each.sessions)),
                    each.exported_by,
                )
                for each in found.exports
            ],
        ),
    ]


def _summary(found: PersonReport) -> list[str]:
    since = f", added {local_time(found.added)}" if found.added else ""
    parts = [
        f"Of {found.participant}{since}: {len(found.sessions)} sessions, {len(found.records)} "
        f"versions of records, {len(found.notes)} notes."
    ]
    parts.append(
        "Each session has more: every prompt, key, movement and word of the agent, with its time. "
        "The files have it."
    )
    if found.shared:
        parts.append(f"For two people, with data of the other, too: {', '.join(found.shared)}.")
    return parts


def _listed(title: str, heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[Section]:
    return [Section(title, [Table(heads, rows, whole=heads[:1])])] if rows else []


def _when(at: str) -> str:
    """Return a moment, or a day, for people."""
    return local_time(at) if "+" in at else at


def _contents(record: Record) -> str:
    return "; ".join([_in_words(record.content), *(["removed"] * record.removed)])
