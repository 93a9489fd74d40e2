"""Participants of the sessions: a row each."""

import sqlite3
from collections.abc import Iterator

from sar_tui.export.columns import Table, Values, stored


def _rows(database: sqlite3.Connection, code: str) -> Iterator[Values]:
    found = database.execute("SELECT created_at FROM participants WHERE code=?", (code,)).fetchone()
    yield (code, found[0] if found else None)


PARTICIPANTS = Table(
    name="participants",
    title="A participant of these sessions",
    columns=(
        stored(
            "participants.code",
            "string",
            "Code of the participant.",
            name="participant",
            required=True,
        ),
        stored("participants.created_at", "datetime", "When the participant was added, UTC."),
    ),
    key=("participant",),
    rows=_rows,
    of="participant",
)
