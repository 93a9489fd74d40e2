"""Gives rows of a database the codes and sites by which another database stores them."""

import sqlite3
from collections.abc import Callable

from sar_tui.store.merge.people import People, in_full, site_of
from sar_tui.store.sites import OF_SITES

_PERSONS = (
    ("seats", "participant"),
    ("records", "participant"),
)
"""Columns with the code of a person, beside ``participants``. Programmes keep the code that their
site gave.
"""
_MARK = "\x01"
"""Put before a value that is to be replaced: no value begins with it."""


def rename_others(db: sqlite3.Connection, people: People, site: str) -> None:
    """Rename all in the attached database ``other``, of a site, to what the main database
    stores.
    """
    _rename(db, "other", lambda code: people.stored(in_full(code, site)))
    _replace(
        db, "other", "programmes", "participant", lambda code: people.shortened(in_full(code, site))
    )
    if site != people.own:  # ids of records are short, so that two sites may have the same
        _replace(
            db,
            "other",
            "records",
            "id",
            lambda id: people.shortened(in_full(id, site)),
        )
        for table in OF_SITES:
            db.execute(f"UPDATE other.{table} SET site=CASE site WHEN '' THEN ? WHEN ? THEN '' ELSE site END",
                       (site, people.own))  # fmt: skip


def rename_own(db: sqlite3.Connection, people: People) -> int:
    """Rename those in the main database who are known as the same person now, and return the number
    of changed rows.
    """
    return _rename(db, "main", lambda code: people.stored(in_full(code, people.own)))


def _rename(db: sqlite3.Connection, schema: str, stored: Callable[[str], str]) -> int:
    changed = sum(_replace(db, schema, table, column, stored) for table, column in _PERSONS)
    rows = db.execute(
        f"SELECT code, created_at FROM {schema}.participants ORDER BY rowid"
    ).fetchall()
    renamed = [row for row in rows if stored(row[0]) != row[0]]
    db.executemany(
        f"DELETE FROM {schema}.participants WHERE code=?", [(code,) for code, _ in renamed]
    )
    for code, created_at in renamed:
        add_participant(db, schema, stored(code), created_at)
    return changed + len(renamed)


def add_participant(db: sqlite3.Connection, schema: str, code: str, created_at: str) -> int:
    """Add a participant, or let one who is known be as old as is known now; return the number of
    changed rows.
    """
    return db.execute(
        f"INSERT INTO {schema}.participants (code, created_at, site) VALUES (?,?,?) ON CONFLICT "
        "(code) DO UPDATE"
        " SET created_at=excluded.created_at WHERE excluded.created_at<created_at",
        (code, created_at, site_of(code)),
    ).rowcount


def _replace(
    db: sqlite3.Connection, schema: str, table: str, column: str, stored: Callable[[str], str]
) -> int:
    """Replace the values of a column all at once: a new value may be the old one of another row."""
    olds = [old for (old,) in db.execute(f"SELECT DISTINCT {column} FROM {schema}.{table}")]
    news = [(old, new) for old in olds if (new := stored(old)) != old]
    marked = [(f"{_MARK}{old}", old) for old, _ in news]
    db.executemany(f"UPDATE {schema}.{table} SET {column}=? WHERE {column}=?", marked)
    statement = f"UPDATE OR IGNORE {schema}.{table} SET {column}=? WHERE {column}=?"
    changed = sum(db.execute(statement, (new, f"{_MARK}{old}")).rowcount for old, new in news)
    # Of two rows that would have the same key now, one keeps what it had.
    db.executemany(
        f"UPDATE {schema}.{table} SET {column}=? WHERE {column}=?",
        [(old, mark) for mark, old in marked],
    )
    return changed
