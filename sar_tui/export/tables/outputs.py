"""Parts of actions as outputs did them: a row for what each output said, showed or moved."""

import re
import sqlite3
from collections.abc import Iterator
from functools import partial
from typing import Any, get_args

from sar_tui.export.columns import SESSION, TO_SESSION, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.export.messages_of_topic import messages_of_topic
from sar_tui.model.messages.base import ActionPart

_ENDS = ("done", "aborted", "failed")


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
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
        yield (
            session, number, run, action, _kind(output), deed, part.get("started_ns"), part.get("ended_ns"),
            part.get("outcome"),
        )  # fmt: skip


def _kind(output: object) -> str | None:
    """Return the kind of an output: the first word of its name, which may go on with an address."""
    found = re.match(r"[a-z]+", str(output))
    return found[0] if found else None


def outputs(damage: Damage) -> Table:
    """Return the table of what outputs did."""
    return Table(
        name="outputs",
        title="A part of an action, as one output did it",
        columns=(
            SESSION,
            stored(
                "output.number",
                "integer",
                "Number of the part in its session, from 1.",
                name="part",
                required=True,
            ),
            stored("messages.run", "integer", "The run of the program.", required=True),
            stored(
                "output.action",
                "string",
                "The action. Not in the table of actions: tones of a prompt (go-…) and of the end "
                "of an attempt "
                "(end-…), and gaze cues (cue-…).",
            ),
            stored(
                "output.output", "string", "Kind of the output: screen, speech, tones, servo, ros."
            ),
            stored("output.deed", "string", "What it did.", levels=get_args(ActionPart)),
            stored(
                "output.started_ns",
                "integer",
                "When it was audible or visible; missing: never.",
                unit="ns",
            ),
            stored(
                "output.ended_ns",
                "integer",
                "When it ended. Text ends when other text replaces it.",
                unit="ns",
            ),
            stored(
                "output.outcome",
                "string",
                "How it ended; missing: it was under way at the end.",
                levels=_ENDS,
            ),
        ),
        key=("session", "part"),
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
