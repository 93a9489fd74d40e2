"""Rows that are stored and read by hand, as no program does."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store.database import connect
from sar_tui.store.tables import TABLES, Type

Place = sqlite3.Connection | Path
"""An open database, or a data folder."""
_LEAST: dict[Type, object] = {"json": "{}", "integer": 0, "number": 0.0, "boolean": 0, "blob": b""}
_FIRST = {"attempt": 1, "trial": 1, "seat": "A", "run": 1, "version": 1, "task": "keyboard",
          "theme": "calm", "participant": "P01", "mode": "live", "seed": 1, "practice": 0,
          "level": 1, "parameters": "{}", "software": "{}", "machine": "{}"}  # fmt: skip


def sql(place: Place, statement: str, *values: object) -> list[Any]:
    """Run a statement, and return its rows."""
    if isinstance(place, Path):
        with closing(connect(place)) as database:
            return sql(database, statement, *values)
    return place.execute(statement, values).fetchall()


def value(place: Place, query: str, *values: object) -> Any:
    """Return the first value of the first row of a query."""
    return sql(place, query, *values)[0][0]


def insert(place: Place, table: str, **given: object) -> None:
    """Store a row. Columns that are not given have their default, or the least that the table
    takes.
    """
    row = {
        column.name: _FIRST.get(column.name, _LEAST.get(column.type, ""))
        for column in TABLES[table].columns
        if column.name in _FIRST or ("NOT NULL" in column.sql and "DEFAULT" not in column.sql)
    }
    row |= given
    names, places = ", ".join(f'"{name}"' for name in row), ", ".join("?" * len(row))
    sql(place, f"INSERT INTO {table} ({names}) VALUES ({places})", *row.values())


def add_message(
    database: sqlite3.Connection, session: str, seq: int, at: int, topic: str, message: object
) -> None:
    """Store a message of run 1 as an object, or as the text that it is, whether or not it is one of
    its topic.
    """
    text = message if isinstance(message, str) else json.dumps(message)
    sql(database, "INSERT OR IGNORE INTO session_numbers (id) VALUES (?)", session)
    sql(database, "INSERT OR IGNORE INTO topics (name, fields) VALUES (?, '')", topic)
    database.execute(
        "INSERT INTO messages (session_number, seq, run, at_ns, topic, message)"
        " SELECT number, ?, 1, ?, topics.id, ? FROM session_numbers, topics"
        " WHERE session_numbers.id=? AND name=? AND fields=''",
        (seq, at, text, session, topic),
    )
