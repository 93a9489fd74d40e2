"""Everything that is stored of one person, to be read by that person."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.reports.sections import Section, Table
from sar_tui.store import exports, people_events, programmes, records, sessions
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


class PersonReport(msgspec.Struct, frozen=True, kw_only=True):
    """All that is stored of a person.

    Attributes:
        sessions: as listed, the newest first. ``shared``: the ids of those for two.
        records: all versions.
        programmes: all versions, by task.
        exports: those that held their sessions.
    """

    participant: str
    added: str | None
    events: list[PersonEvent]
    sessions: list[dict[str, Any]]
    shared: list[str]
    records: list[Record]
    notes: list[Note]
    programmes: dict[str, list[Programme]]
    exports: list[LedgerEntry]


def read(db: sqlite3.Connection, folder: Path, code: str) -> PersonReport:
    """Read all that is stored of a participant. Raises StoreError."""
    listed = sessions.listing(db, folder, participant=code, also_damaged=True)
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
        records=versions,
        notes=notes,
        programmes={
            task: programmes.versions(db, code, task) for task in programmes.tasks(db, code)
        },
        exports=[entry for entry in exports.ledger(db) if ids.intersection(entry.sessions)],
    )


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
            "Records",
            ("date", "record", "version", "kind", "contents", "by"),
            [
                (
                    local_time(each.at) if "+" in each.at else each.at,
                    each.id,
                    str(each.version),
                    each.kind,
                    _contents(each),
                    each.recorded_by,
                )
                for each in found.records
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


def _contents(record: Record) -> str:
    values = [f"{name}: {value}" for name, value in record.content.items()]
    return "; ".join((*values, *(["removed"] * record.removed)))
