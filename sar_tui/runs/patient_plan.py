"""The exercises of a participant who trains alone, and the session that each begins with."""

import sqlite3
from collections.abc import Callable, Sequence
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from statistics import median
from typing import NamedTuple

from msgspec.structs import replace

from sar_tui.plugins import Catalogue, PluginError
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.store import programmes, sessions
from sar_tui.store.counted import counts
from sar_tui.store.database import StoreError
from sar_tui.store.training_days import trained_at

_MEASURED = 5
"""Latest sessions of a task whose length tells how long the next one takes."""
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


class Exercise(NamedTuple):
    """A task of a participant's day.

    Attributes:
        name: of the task.
        is_done: a session of it was finished today.
        is_known: a session of it was finished before, on any day.
        minutes: of its last sessions, the median; None if there is none.
    """

    name: str
    is_done: bool = False
    is_known: bool = False
    minutes: float | None = None


def day_plan(
    database: sqlite3.Connection,
    folder: Path,
    participant: str,
    names: Sequence[str],
    today: date,
) -> list[Exercise]:
    """Return what a participant does today, with what is done."""
    rows = sessions.listing(database, folder, participant=participant, limit=_LOOKED_AT)
    finished = [row for row in rows if counts(row) and row["status"] == "completed"]
    return [
        _exercise(name, [row for row in finished if row["task"] == name], today) for name in names
    ]


def _exercise(name: str, finished: Sequence[sessions.Row], today: date) -> Exercise:
    """Return an exercise by its finished sessions, newest first."""
    if not finished:
        return Exercise(name)
    days = [trained_at(row["started_at"], row["utc_offset_s"]).date() for row in finished]
    lasted = [
        datetime.fromisoformat(row["ended_at"]) - datetime.fromisoformat(row["started_at"])
        for row in finished[:_MEASURED]
        if row["ended_at"]
    ]
    minutes = median(each.total_seconds() for each in lasted) / 60 if lasted else None
    return Exercise(name, today in days, True, minutes)


def plan_exercise(
    database: sqlite3.Connection,
    catalogue: Catalogue,
    participant: str,
    task: str,
    *,
    is_known: bool = False,
) -> Plan:
    """Return the plan of a new session by the newest programme.

    Args:
        is_known: the participant has finished the task before: unless the programme says otherwise,
            its instructions are left out.

    Raises:
        PLAN_ERRORS: like `plan.make_plan`.
    """
    saved = programmes.newest(database, participant, task)
    plan = make_plan(catalogue, task, [participant], saved=saved)
    if is_known and plan.parameters.instructions == "first time":
        return replace(plan, parameters=replace(plan.parameters, instructions="never"))
    return plan


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
    if sessions.came_by_letter(database, last["id"]):
        return None
    age = now() - datetime.fromisoformat(last["started_at"])
    return str(last["id"]) if timedelta(0) <= age < RESUMED_WITHIN else None


PLAN_ERRORS = (StoreError, PluginError, ParameterError, Failed)
"""Reasons why an exercise cannot be planned."""
