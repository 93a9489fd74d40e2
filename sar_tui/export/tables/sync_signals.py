"""Signals for cameras at the start of a run: a row each."""

import sqlite3
from collections.abc import Iterator
from functools import partial
from typing import get_args, get_type_hints

from sar_tui.export.columns import RUN, SESSION, TO_SESSION, Column, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.model.messages.inputs import SyncSignal

_TYPES = get_type_hints(SyncSignal)


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
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
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
