"""The exercises of a participant who trains alone, and the session that each begins with."""

import sqlite3
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

from sar_tui.plugins import Catalogue, PluginError
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.store import programmes, sessions
from sar_tui.store.counted import counts
from sar_tui.store.database import StoreError

_LOOKED_AT = 50
"""Latest sessions of the participant in which the last one is looked for."""
RESUMED_WITHIN = timedelta(hours=12)
"""Age up to which an interrupted session goes on; after that, a new one begins."""


def exercises(
    database: sqlite3.Connection, folder: Path, catalogue: Catalogue, participant: str
) -> list[str]:
    """Return the names of the tasks that a participant does alone.

    These are the tasks of their programmes, or without one, the task of their last session. Tasks
    for two and tasks that are not installed any more are left out.

    Raises:
        StoreError: there is none.
    """
    names = programmes.tasks(database, participant)
    if not names:
        rows = sessions.listing(database, folder, participant=participant, limit=_LOOKED_AT)
        names = [row["task"] for row in rows if counts(row)][:1]
    found = [name for name in names if _is_for_one(catalogue, name)]
    if not found:
        raise StoreError(
            f"{participant} has no exercise to do alone. Save a programme in the app (F2), or run "
            "a session first.",
            bad_input=True,
        )
    return found


def _is_for_one(catalogue: Catalogue, name: str) -> bool:
    try:
        return len(catalogue.task(name).seats) == 1
    except PluginError:
        return False


def plan_exercise(
    database: sqlite3.Connection, catalogue: Catalogue, participant: str, task: str
) -> Plan:
    """Return the plan of a new session by the newest programme. Raises like `plan.make_plan`."""
    saved = programmes.newest(database, participant, task)
    return make_plan(catalogue, task, [participant], saved=saved)


def unfinished(
    database: sqlite3.Connection,
    folder: Path,
    participant: str,
    task: str,
    now: Callable[[], datetime] = lambda: datetime.now(UTC),
) -> str | None:
    """Return the id of the participant's last session of a task if it was interrupted here not long
    ago; else None.
    """
    rows = sessions.listing(database, folder, participant=participant, limit=_LOOKED_AT)
    last = next((row for row in rows if row["task"] == task and counts(row)), None)
    if last is None or last["status"] != "interrupted" or last["partner"] or last["site"]:
        return None
    age = now() - datetime.fromisoformat(last["started_at"])
    return str(last["id"]) if timedelta(0) <= age < RESUMED_WITHIN else None


PLAN_ERRORS = (StoreError, PluginError, ParameterError, Failed)
"""Reasons why an exercise cannot be planned."""
