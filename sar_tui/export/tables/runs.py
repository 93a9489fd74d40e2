"""Runs of the program: a row each. Resuming a session adds one."""

import sqlite3
from collections.abc import Iterator
from functools import partial

from sar_tui.export.columns import SESSION, TO_SESSION, Table, Values, stored
from sar_tui.export.damage import Damage


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    for run, anchor, software in database.execute(
        "SELECT run, clock_anchor, software FROM runs WHERE session=? ORDER BY run", (session,)
    ):
        at, made_by = (
            damage.object_of("clock_anchor", anchor),
            damage.object_of("software", software),
        )
        packages = made_by.get("packages")
        numpy = packages.get("numpy") if isinstance(packages, dict) else None
        yield (
            *(session, run, at.get("clock_ns"), at.get("utc"), at.get("utc_offset_s")),
            *(made_by.get("sar_tui"), made_by.get("python"), numpy),
        )


def runs(damage: Damage) -> Table:
    """Return the table of runs."""
    return Table(
        name="runs",
        title="A run of the program on a session",
        columns=(
            SESSION,
            stored("runs.run", "integer", "Number of the run, from 1.", required=True),
            stored(
                "runs.clock_anchor.clock_ns",
                "integer",
                "The steady clock at the moment of clock_utc: it relates the stamps of the run to "
                "the time of day.",
                unit="ns",
            ),
            stored(
                "runs.clock_anchor.utc",
                "datetime",
                "The time of day at the moment of clock_ns, UTC.",
                name="clock_utc",
            ),
            stored(
                "runs.clock_anchor.utc_offset_s",
                "integer",
                "Local time minus UTC where the session was played; days of progress are counted "
                "by it.",
                unit="s",
            ),
            stored("sessions.software.sar_tui", "string", "Version of sar-tui."),
            stored("sessions.software.python", "string", "Version of Python."),
            stored(
                "sessions.software.packages.numpy",
                "string",
                "Version of numpy, by which movements are measured.",
            ),
        ),
        key=("session", "run"),
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
