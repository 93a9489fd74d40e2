"""Merge of the rows beside sessions: participants, programmes, records of people, studies, exports."""

import sqlite3
from collections.abc import Sequence
from typing import Any, NamedTuple

from sar_tui.store.merge import conflicts
from sar_tui.store.merge.conflicts import Content, Kind
from sar_tui.store.merge.people import People, add_participant
from sar_tui.store.tables import TABLES


class _Records(NamedTuple):
    """A table of records that are added and never changed. ``key``: columns that name a record."""

    kind: Kind
    table: str
    key: tuple[str, ...]


_TABLES = (
    _Records("programme", "programmes", ("participant", "task", "version")),
    _Records("record", "records", ("id", "version")),
)


def merge_records(db: sqlite3.Connection, people: People) -> dict[str, int]:
    """Add the records that only ``other`` has to the main database, and return the numbers of
    changed rows by table.
    """
    changed = {
        "participants": _participants(db),
        "exports": _exports(db),
        "people_events": _people_events(db),
        "studies": _studies(db),
    }
    for records in _TABLES:
        changed[records.table] = _merge(db, people, records)
    db.execute(
        "INSERT OR IGNORE INTO main.conflicts SELECT * FROM other.conflicts WHERE kind<>'session' "
        "AND (kind, key)"
        " NOT IN (SELECT kind, key FROM temp.decided)"
    )
    return changed


def _participants(db: sqlite3.Connection) -> int:
    rows = db.execute("SELECT code, created_at FROM other.participants ORDER BY rowid").fetchall()
    return sum(add_participant(db, "main", *row) for row in rows)


def _exports(db: sqlite3.Connection) -> int:
    names = [name for name in TABLES["exports"].names if name != "number"]
    same = " AND ".join(f"here.{name}=there.{name}" for name in names)
    return db.execute(
        f"INSERT INTO main.exports ({', '.join(names)}) SELECT {', '.join(names)} FROM "
        "other.exports AS there"
        f" WHERE NOT EXISTS (SELECT 1 FROM main.exports AS here WHERE {same}) ORDER BY number"
    ).rowcount


def _studies(db: sqlite3.Connection) -> int:
    """Add plans that the other site froze: each site has its own row of a version."""
    names = ", ".join(TABLES["studies"].names)
    return db.execute(
        f"INSERT OR IGNORE INTO main.studies ({names}) SELECT {names} FROM other.studies"
        " ORDER BY name, version, site"
    ).rowcount


def _people_events(db: sqlite3.Connection) -> int:
    listed = ", ".join(TABLES["people_events"].names)
    return db.execute(
        f"INSERT OR IGNORE INTO main.people_events ({listed}) SELECT {listed} FROM "
        "other.people_events ORDER BY at, id"
    ).rowcount


def _merge(db: sqlite3.Connection, people: People, records: _Records) -> int:
    db.execute("CREATE TEMP TABLE IF NOT EXISTS decided (kind, key)")
    names = TABLES[records.table].names
    same_key = " AND ".join(f"here.{name}=there.{name}" for name in records.key)
    both = f"main.{records.table} AS here JOIN other.{records.table} AS there ON {same_key}"
    changed = _attach_answers(db, records) if records.table == "records" else 0
    differ = " OR ".join(_differs(records, name) for name in names if name not in records.key)
    for row in db.execute(
        f"SELECT {', '.join(f'here.{name}' for name in names)}, "
        f"{', '.join(f'there.{name}' for name in names)}"
        f" FROM {both} WHERE {differ}"
    ).fetchall():
        changed += _decide(db, people, records, names, row)
    listed = ", ".join(names)
    changed += db.execute(
        f"INSERT INTO main.{records.table} ({listed}) SELECT {listed} FROM other.{records.table} "
        "AS there"
        f" WHERE NOT EXISTS (SELECT 1 FROM main.{records.table} AS here WHERE {same_key}) ORDER "
        "BY there.rowid"
    ).rowcount
    return changed


def _attach_answers(db: sqlite3.Connection, records: _Records) -> int:
    """Give answers that had no session yet the one that they have there."""
    same_key = " AND ".join(f"records.{name}=there.{name}" for name in records.key)
    there = f"SELECT session FROM other.records AS there WHERE {same_key}"
    return db.execute(
        f"UPDATE main.records SET session=({there}) WHERE session IS NULL AND EXISTS ({there} "
        "AND session NOTNULL)"
    ).rowcount


def _differs(records: _Records, name: str) -> str:
    """Return the condition that a column contradicts. An answer that has no session there may have
    one here.
    """
    condition = f"here.{name} IS NOT there.{name}"
    is_unknown = records.table == "records" and name == "session"
    return f"({condition} AND there.session NOTNULL)" if is_unknown else f"({condition})"


def _decide(
    db: sqlite3.Connection,
    people: People,
    records: _Records,
    names: Sequence[str],
    row: tuple[Any, ...],
) -> int:
    """Let one version of a record be in the table, and keep the others aside; return 1 if it is
    another than before.
    """
    here, there = (
        conflicts.in_words({records.table: [dict(zip(names, values, strict=True))]}, people)
        for values in (row[: len(names)], row[len(names) :])
    )
    key = conflicts.key_of(records.kind, here)
    aside = [
        version
        for schema in ("main", "other")
        for version in conflicts.contents(db, schema, records.kind, key)
    ]
    versions = {conflicts.digest(version): version for version in (here, there, *aside)}.values()
    chosen, *others = sorted(
        versions, key=lambda one: (_recorded(one[records.table][0]), conflicts.encoded(one))
    )
    db.execute("INSERT INTO temp.decided VALUES (?,?)", (records.kind, key))
    for version in others:
        conflicts.keep(db, "main", records.kind, key, version)
    if chosen == here:
        return 0
    old = dict(zip(names, row, strict=False))
    condition = " AND ".join(f"{name}=?" for name in records.key)
    db.execute(
        f"DELETE FROM main.{records.table} WHERE {condition}", [old[name] for name in records.key]
    )
    _insert(db, conflicts.as_stored(chosen, people))
    conflicts.drop(db, records.kind, key, conflicts.digest(chosen))
    return 1


def _recorded(row: dict[str, Any]) -> str:
    """Return when a row was recorded; empty if that is part of its key."""
    return str(row.get("created_at") or row.get("recorded_at") or "")


def _insert(db: sqlite3.Connection, content: Content) -> None:
    for table, rows in content.items():
        for row in rows:
            listed, slots = ", ".join(row), ", ".join("?" for _ in row)
            db.execute(f"INSERT INTO main.{table} ({listed}) VALUES ({slots})", list(row.values()))
