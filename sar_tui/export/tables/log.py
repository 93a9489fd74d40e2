"""Notes and event marks, acts taken back, signals for cameras, and messages: a row each."""

import sqlite3
from collections.abc import Iterator
from functools import partial
from typing import get_args, get_type_hints

from sar_tui.export.columns import (
    RUN,
    SESSION,
    TO_SESSION,
    Column,
    Row,
    Stored,
    Table,
    Values,
    in_order,
    role,
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.log import messages_of_topic, runs_of_notes
from sar_tui.loop.topics import TAKEN_BACK
from sar_tui.model.messages import TakenBackKind
from sar_tui.model.messages.inputs import SyncSignal
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


_ROLE = stored("notes.author.role", name="taken_back_by", meaning="Who did it, and took it back.")


def _taken_back(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    found = messages_of_topic(database, session, TAKEN_BACK.name, damage)
    for number, (run, at, act) in enumerate(found, 1):
        of, by = act.get("number") or None, role(act.get("actor"), _ROLE.levels)
        yield session, number, run, act.get("done"), at, act.get("what"), of, by


def taken_back(damage: Damage) -> Table:
    """Return the table of the acts that were taken back."""
    return Table(
        name="taken_back",
        title="An act that a person took back, so that it counts nowhere",
        columns=(
            SESSION,
            Column("act", "Number of the act in its session, from 1.", "integer", required=True,
                   treatment="open"),
            RUN,
            stored("messages.at_ns", name="done_ns", meaning="When it was done, steady clock."),
            stored("messages.at_ns", meaning="When it was taken back, steady clock of the run."),
            Column("what", "What it was.", "string", levels=get_args(TakenBackKind),
                   treatment="open"),
            Column("number", "Number of the attempt that was begun, or of the step that was "
                   "answered.", "integer", treatment="open"),
            _ROLE,
        ),
        key=("session", "act"),
        rows=partial(_taken_back, damage),
        references=(TO_SESSION,),
    )  # fmt: skip


_TYPES = get_type_hints(SyncSignal)


def _signals(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    found = database.execute(
        "SELECT seq, run, at_ns, message FROM events WHERE session=? AND topic='output/sync' "
        "ORDER BY seq",
        (session,),
    )
    for number, (seq, run, at, message) in enumerate(found, 1):
        signal = damage.object_of("message", message, f"message {seq}")
        yield session, number, run, signal.get("at") or at, signal.get("what"), signal.get("source")


def sync_signals(damage: Damage) -> Table:
    """Return the table of the flashes and tones by which videos are aligned."""
    return Table(
        name="sync_signals",
        title="A signal for cameras: a flash of the screen, or a tone",
        columns=(
            SESSION,
            Column(
                "signal",
                "Number of the signal in its session, from 1.",
                "integer",
                required=True,
                treatment="open",
            ),
            RUN,
            stored("messages.at_ns", meaning="When it began, steady clock of the run."),
            Column(
                "what", "What it was.", "string", levels=get_args(_TYPES["what"]), treatment="open"
            ),
            Column(
                "source",
                "How the time is known: its frame was flushed, the screen was refreshed (less "
                "exact), or its samples were fed to the sound card.",
                "string",
                levels=get_args(_TYPES["source"]),
                treatment="open",
            ),
        ),
        key=("session", "signal"),
        rows=partial(_signals, damage),
        references=(TO_SESSION,),
    )


def _messages(database: sqlite3.Connection, session: str) -> Iterator[Values]:
    for row in database.execute(
        "SELECT seq, run, at_ns, topics.name FROM messages JOIN topics ON topics.id=topic"
        " WHERE session_number=(SELECT number FROM session_numbers WHERE id=?) ORDER BY seq",
        (session,),
    ):
        yield (session, *row)


EVENTS = Table(
    name="events",
    title="A message in the program, without its content",
    columns=(
        SESSION,
        stored("messages.seq"),
        RUN,
        stored("messages.at_ns"),
        stored("topics.name"),
    ),
    key=("session", "seq"),
    rows=_messages,
    references=(TO_SESSION,),
)
