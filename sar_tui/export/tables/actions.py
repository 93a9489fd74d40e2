"""The agent's actions, each with the decision on it: a row each."""

import sqlite3
from collections.abc import Iterator
from functools import partial

from sar_tui.export.columns import SESSION, TO_SESSION, Column, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.export.roles import ROLES, role
from sar_tui.export.run_numbers import runs_of_actions

_PARTS = {
    "text": stored("actions.proposed.text", "string", "Text on the screen."),
    "spoken": stored("actions.proposed.spoken", "string", "Text that is said."),
    "face": stored("actions.proposed.face", "string", "The agent's face."),
    "gesture": stored("actions.proposed.gesture", "string", "The agent's gesture."),
    "gaze": stored("actions.proposed.gaze", "string", "Direction of the agent's gaze."),
    "tone": stored("actions.proposed.tone", "string", "A tone."),
    "valence": stored("actions.proposed.valence", "string", "Valence of feedback."),
    "degree": stored("actions.proposed.degree", "string", "Degree of feedback."),
    "evidence": stored(
        "actions.proposed.evidence", "string", "Changes that feedback reports, each with its MDC95."
    ),
}


def _parts(prefix: str, of: str) -> list[Column]:
    return [
        Column(
            f"{prefix}_{each.name}", f"{of}: {each.meaning}", each.type, treatment=each.treatment
        )
        for each in _PARTS.values()
    ]


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    run = runs_of_actions(database, session, damage)
    for id, kind, proposed, final, decision, actor, *rest in database.execute(
        "SELECT id, kind, proposed, final, decision, actor, mode, ground, reason, proposed_ns, "
        "shown_ns, deadline_ns,"
        " decided_ns, started_ns, ended_ns FROM actions WHERE session=? ORDER BY rowid",
        (session,),
    ):
        first, last = damage.object_of("proposed", proposed), damage.object_of("final", final)
        attempt = (first or last).get("attempt") or None
        yield (
            session, id, run(id), kind, attempt, decision, role(actor), *rest, last.get("level"),
            *(_or_none(first.get(key)) for key in _PARTS), *(_or_none(last.get(key)) for key in _PARTS),
        )  # fmt: skip


def _or_none(value: object) -> object:
    return None if value is None or value == "" else str(value)


def actions(damage: Damage) -> Table:
    """Return the table of the agent's actions."""
    return Table(
        name="actions",
        title="An action of the agent, or one that was proposed, and the decision on it",
        columns=(
            SESSION,
            stored(
                "actions.id",
                "string",
                "Id of the action in its session.",
                name="action",
                required=True,
            ),
            stored(
                "messages.run",
                "integer",
                "The run of the program in which it was decided, or else proposed.",
            ),
            stored(
                "actions.kind",
                "string",
                "What it is for: greeting, feedback, …; difficulty is a change of level.",
            ),
            stored(
                "actions.proposed.attempt",
                "integer",
                "The attempt it belongs to; missing if to none.",
            ),
            stored(
                "actions.decision",
                "string",
                "Outcome of the decision; missing: undecided when the session ended.",
                levels=("accepted", "edited", "rejected", "initiated", "dropped"),
            ),
            stored("actions.actor.role", "string", "Who decided.", name="decided_by", levels=ROLES),
            stored(
                "actions.mode",
                "string",
                "The mode it was decided in.",
                levels=("autonomous", "veto", "approve", "manual"),
            ),
            stored("actions.ground", "string", "Ground of the decision."),
            stored("actions.reason", "string", "Why it was dropped."),
            stored("actions.proposed_ns", "integer", "When it was proposed.", unit="ns"),
            stored(
                "actions.shown_ns",
                "integer",
                "When it was first shown on an operator's screen.",
                unit="ns",
            ),
            stored(
                "actions.deadline_ns",
                "integer",
                "When it is decided without an operator.",
                unit="ns",
            ),
            stored("actions.decided_ns", "integer", "When it was decided.", unit="ns"),
            stored("actions.started_ns", "integer", "When the first output started.", unit="ns"),
            stored(
                "actions.ended_ns",
                "integer",
                "When the last output was done, stopped or failed.",
                unit="ns",
            ),
            stored(
                "actions.final.level",
                "integer",
                "The level that was decided on.",
                name="final_level",
            ),
            *_parts("proposed", "As proposed"),
            *_parts("final", "As it was done"),
        ),
        key=("session", "action"),
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
