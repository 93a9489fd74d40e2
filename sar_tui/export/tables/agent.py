"""The agent's actions, each with the decision on it, and what outputs did of them: a row each."""

import re
import sqlite3
from collections.abc import Iterator
from typing import Any, get_args

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
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.log import messages_of_topic, runs_of_actions
from sar_tui.model.messages.base import ActionPart
from sar_tui.store.tables import ACTIONS

_ACTIONS = Stored(ACTIONS, objects=("proposed", "final"))
_PARTS = [part.name for part in ACTIONS["proposed"].parts if part.leaves]


def _parts(which: str, meaning: str) -> list[Column]:
    """Return the columns of the parts of an action: of the proposed one, or of the final one."""
    made = []
    for name in _PARTS:
        part = stored(f"actions.proposed.{name}")
        made.append(
            Column(
                f"{which}_{name}", f"{meaning}: {part.meaning}", part.type, treatment=part.treatment
            )
        )
    return made


_COLUMNS = with_others(
    _ACTIONS.columns,
    {
        "action": [
            stored(
                "messages.run",
                meaning="The run of the program in which it was decided, or else proposed.",
                required=False,
            )
        ],
        "kind": [stored("actions.proposed.attempt")],
        "ended_ns": [
            stored("actions.final.level"),
            *_parts("proposed", "As proposed"),
            *_parts("final", "As it was done"),
        ],
    },
)


def actions(damage: Damage) -> Table:
    """Return the table of the agent's actions."""

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        run = runs_of_actions(database, session, damage)
        for row in _ACTIONS.rows(database, session, damage, order="rowid"):
            proposed, final = row["proposed"], row["final"]
            row["run"] = run(row["action"])
            row["attempt"] = (proposed or final).get("attempt") or None
            row["final_level"] = final.get("level")
            for name in _PARTS:
                row[f"proposed_{name}"] = _text(proposed.get(name))
                row[f"final_{name}"] = _text(final.get(name))
            yield row

    return Table(
        name="actions",
        title=ACTIONS.row,
        columns=_COLUMNS,
        key=("session", "action"),
        rows=in_order(_COLUMNS, rows),
        references=(TO_SESSION,),
    )


def _text(value: object) -> str | None:
    return None if value is None or value == "" else str(value)


_ENDS = ("done", "aborted", "failed")
_OUTPUT_COLUMNS = (
    SESSION,
    Column(
        "part",
        "Number of the part in its session, from 1.",
        "integer",
        required=True,
        treatment="open",
    ),
    RUN,
    Column(
        "action",
        "The action. Not in the table of actions: tones of a prompt (go-…) and of the end of an "
        "attempt (end-…), and gaze cues (cue-…).",
        "string",
        treatment="open",
    ),
    Column(
        "output",
        "Kind of the output: screen, speech, tones, servo, or a robot: ros, ros4hri, furhat, reachy.",
        "string",
        treatment="open",
    ),
    Column("deed", "What it did.", "string", levels=get_args(ActionPart), treatment="open"),
    Column(
        "started_ns",
        "When it was audible or visible; missing: never.",
        "integer",
        unit="ns",
        treatment="clock",
    ),
    Column(
        "ended_ns",
        "When it ended. Text ends when other text replaces it.",
        "integer",
        unit="ns",
        treatment="clock",
    ),
    Column(
        "outcome",
        "How it ended; missing: it was under way at the end.",
        "string",
        levels=_ENDS,
        treatment="open",
    ),
)


def outputs(damage: Damage) -> Table:
    """Return the table of what outputs did: said, showed or moved."""

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Values]:
        found: list[dict[str, Any]] = []
        latest: dict[tuple[Any, ...], dict[str, Any]] = {}
        for run, at, report in messages_of_topic(database, session, "output/report", damage):
            key = (run, report.get("action"), report.get("output"), report.get("deed"))
            part = latest.get(key)
            if part is None or "outcome" in part:
                part = latest[key] = {"key": key}
                found.append(part)
            state, when = report.get("state"), report.get("at") or at
            if state == "started":
                part.setdefault("started_ns", when)
            elif state in _ENDS:
                part |= {"ended_ns": when, "outcome": state}
        for number, part in enumerate(found, 1):
            run, action, output, deed = part["key"]
            ends = (part.get("started_ns"), part.get("ended_ns"), part.get("outcome"))
            yield session, number, run, action, _kind(output), deed, *ends

    return Table(
        name="outputs",
        title="A part of an action, as one output did it",
        columns=_OUTPUT_COLUMNS,
        key=("session", "part"),
        rows=rows,
        references=(TO_SESSION,),
    )


def _kind(output: object) -> str | None:
    """Return the kind of an output: the first word of its name, which may go on with an address."""
    found = re.match(r"[a-z]+", str(output))
    return found[0] if found else None
