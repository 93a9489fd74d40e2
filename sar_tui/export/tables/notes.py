"""Notes and event marks: a row each."""

import sqlite3
from collections.abc import Iterator

from sar_tui.export.columns import (
    TO_SESSION,
    Column,
    Row,
    Stored,
    Table,
    in_order,
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.run_numbers import runs_of_notes
from sar_tui.store.tables import NOTES

_NOTES = Stored(NOTES)
_COLUMNS = with_others(
    _NOTES.columns,
    {
        "session": [
            Column(
                "note",
                "Number of the note in its session, from 1.",
                "integer",
                required=True,
                treatment="open",
            ),
            stored("messages.run", required=False),
        ]
    },
)


def notes(damage: Damage) -> Table:
    """Return the table of notes and event marks."""

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        run = runs_of_notes(database, session, damage)
        found = _NOTES.rows(database, session, damage, order="rowid")
        for number, row in enumerate(found, 1):
            row["note"] = number
            row["run"] = run(row["at_ns"])
            yield row

    return Table(
        name="notes",
        title=NOTES.row,
        columns=_COLUMNS,
        key=("session", "note"),
        rows=in_order(_COLUMNS, rows),
        references=(TO_SESSION,),
    )
