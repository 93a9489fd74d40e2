"""Notes and event marks: a row each."""

import sqlite3
from collections.abc import Iterator
from functools import partial

from sar_tui.export.columns import SESSION, TO_SESSION, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.export.roles import ROLES, role
from sar_tui.export.run_numbers import runs_of_notes


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    run = runs_of_notes(database, session, damage)
    found = database.execute(
        "SELECT at_ns, author, label, text FROM notes WHERE session=? ORDER BY rowid", (session,)
    )
    for number, (at, author, label, text) in enumerate(found, 1):
        yield session, number, run(at), at, role(author), label, text


def notes(damage: Damage) -> Table:
    """Return the table of notes and event marks."""
    return Table(
        name="notes",
        title="A note, or an event mark",
        columns=(
            SESSION,
            stored(
                "notes.number",
                "integer",
                "Number of the note in its session, from 1.",
                name="note",
                required=True,
            ),
            stored("messages.run", "integer", "The run of the program."),
            stored(
                "notes.at_ns", "integer", "When it was written, steady clock of the run.", unit="ns"
            ),
            stored("notes.author.role", "string", "Who wrote it.", name="written_by", levels=ROLES),
            stored("notes.label", "string", "Label of an event mark."),
            stored("notes.text", "string", "The text."),
        ),
        key=("session", "note"),
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
