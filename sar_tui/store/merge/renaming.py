"""Gives rows of a database the codes and sites by which another database stores them."""

import sqlite3
from collections.abc import Callable

from sar_tui.store.merge.people import People, in_full, site_of
from sar_tui.store.sites import OF_SITES

_PERSONS = (
    ("seats", "participant"),
    ("wellbeing", "participant"),
    ("adverse_events", "participant"),
    ("instrument_scores", "participant"),
)
"""Columns with the code of a person, beside ``participants``. Programmes keep the code that their site gave."""


def rename_others(db: sqlite3.Connection, people: People, site: str) -> None:
    """Rename all in the attached database ``other``, of a site, to what the main database stores."""
    _rename(db, "other", lambda code: people.stored(in_full(code, site)))
    _replace(db, "other", "programmes", "participant", lambda code: people.shortened(in_full(code, site)))
    if site != people.own:  # ids of adverse events are short, so that two sites may have the same
        _replace(db, "other", "adverse_events", "event", lambda event: people.shortened(in_full(event, site)))
        for table in OF_SITES:
            db.execute(f"UPDATE other.{table} SET site=CASE site WHEN '' THEN ? WHEN ? THEN '' ELSE site END",
                       (site, people.own))  # fmt: skip


def rename_own(db: sqlite3.Connection, people: People) -> int:
    """Rename those in the main database who are known as the same person now, and return the number of changed rows."""
    return _rename(db, "main", lambda code: people.stored(in_full(code, people.own)))


def _rename(db: sqlite3.Connection, schema: str, stored: Callable[[str], str]) -> int:
    changed = sum(_replace(db, schema, table, column, stored) for table, column in _PERSONS)
    for code, created_at in db.execute(f"SELECT code, created_at FROM {schema}.participants").fetchall():
        if (new := stored(code)) != code:
            db.execute(f"DELETE FROM {schema}.participants WHERE code=?", (code,))
            add_participant(db, schema, new, created_at)
            changed += 1
    return changed


def add_participant(db: sqlite3.Connection, schema: str, code: str, created_at: str) -> int:
    """Add a participant, or let one who is known be as old as is known now; return the number of changed rows."""
    return db.execute(
        f"INSERT INTO {schema}.participants (code, created_at, site) VALUES (?,?,?) ON CONFLICT (code) DO UPDATE"
        " SET created_at=excluded.created_at WHERE excluded.created_at<created_at",
        (code, created_at, site_of(code)),
    ).rowcount


def _replace(db: sqlite3.Connection, schema: str, table: str, column: str, stored: Callable[[str], str]) -> int:
    changed = 0
    for (old,) in db.execute(f"SELECT DISTINCT {column} FROM {schema}.{table}").fetchall():
        if (new := stored(old)) != old:
            statement = f"UPDATE OR IGNORE {schema}.{table} SET {column}=? WHERE {column}=?"
            changed += db.execute(statement, (new, old)).rowcount
    return changed
