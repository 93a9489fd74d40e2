"""Attempts and trials: a row for each seat that took part, with what their tasks measure as
columns.
"""

import sqlite3
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import msgspec

from sar_tui.export.columns import (
    MODE,
    PARTICIPANT,
    TASK,
    TO_SESSION,
    Column,
    Row,
    Rows,
    Stored,
    Table,
    as_bool,
    codes_by_seat,
    in_order,
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.json_columns import Declared, columns, value_for
from sar_tui.export.log import runs_of_starts
from sar_tui.rules.parameters import TaskParameters, fields
from sar_tui.store import tables
from sar_tui.store.tables import ATTEMPTS, TRIALS

_SCHEDULES = next(
    tuple(sorted(field.choices))
    for field in fields(TaskParameters)
    if field.name == "feedback_schedule"
)
_ATTEMPTS = Stored(
    ATTEMPTS, objects=("qualities",), changed={"choice_schedule": {"levels": _SCHEDULES}}
)
_TRIALS = Stored(TRIALS, objects=("details", "data"))
_OF_SESSION = (MODE, TASK, PARTICIPANT)
_STARTED_RUN = stored(
    "messages.run",
    name="started_run",
    meaning="The run of the program in which it began; another one than that of its end if it was "
    "interrupted.",
    required=False,
)
_OF_ATTEMPT = (
    stored("attempts.practice", meaning="True for practice; missing if the attempt was cut off."),
    stored(
        "attempts.level", meaning="The level of the attempt; missing if the attempt was cut off."
    ),
)


def attempts(database: sqlite3.Connection, sessions: Sequence[str], damage: Damage) -> Table:
    """Return the table of the attempts of these sessions, with a column for each of their
    qualities.
    """
    found = columns(database, sessions, "attempts", "qualities", {})
    meaning = ATTEMPTS["qualities"].meaning
    qualities = {
        key: msgspec.structs.replace(column, meaning=meaning) for key, column in found.items()
    }
    plain = with_others(_ATTEMPTS.columns, {"session": _OF_SESSION, "feedback": [_STARTED_RUN]})

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        started_run = runs_of_starts(database, session, damage)
        of_seat = _seats(database, session)
        for row in _ATTEMPTS.rows(database, session, damage):
            row.update(of_seat[row["seat"]])
            row["started_run"] = started_run(row["attempt"])
            row.update(_measured(qualities, row["qualities"]))
            yield row

    return _table(ATTEMPTS, (*plain, *qualities.values()), rows)


def trials(
    database: sqlite3.Connection,
    sessions: Sequence[str],
    declared: Mapping[str, Declared],
    damage: Damage,
    not_loaded: Collection[str] = (),
) -> Table:
    """Return the table of the trials of these sessions.

    Args:
        declared: the details that the tasks of these sessions declare, by name.
        not_loaded: tasks that cannot be loaded, so that what they declare is not known.
    """
    details = columns(database, sessions, "trials", "details", declared, not_loaded=not_loaded)
    data = columns(
        database, sessions, "trials", "data", {}, other="Kept with the prompt by its task."
    )
    plain = with_others(_TRIALS.columns, {"session": _OF_SESSION, "run": _OF_ATTEMPT})

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        of_seat = _seats(database, session)
        of_attempt = _practice_and_level(database, session)
        for row in _TRIALS.rows(database, session, damage):
            row.update(of_seat[row["seat"]])
            row.update(of_attempt.get((row["attempt"], row["seat"]), {}))
            row.update(_measured(details, row["details"]))
            row.update(_measured(data, row["data"]))
            yield row

    return _table(TRIALS, (*plain, *details.values(), *data.values()), rows)


def _table(of: tables.Table, columns: tuple[Column, ...], rows: Rows) -> Table:
    return Table(
        name=of.name,
        title=of.row,
        columns=columns,
        key=of.key,
        rows=in_order(columns, rows),
        references=(TO_SESSION,),
    )


def _seats(database: sqlite3.Connection, session: str) -> defaultdict[str, Row]:
    """Return mode, task and participant by seat."""
    (mode, task) = database.execute(
        "SELECT mode, task FROM sessions WHERE id=?", (session,)
    ).fetchone()
    of_session = {"mode": mode, "task": task}
    found: defaultdict[str, Row] = defaultdict(lambda: of_session)
    for seat, code in codes_by_seat(database, session).items():
        found[seat] = {**of_session, "participant": code}
    return found


def _practice_and_level(database: sqlite3.Connection, session: str) -> dict[tuple[int, str], Row]:
    found = database.execute(
        "SELECT attempt, seat, practice, level FROM attempts WHERE session=?", (session,)
    )
    return {
        (attempt, seat): {"practice": as_bool(practice), "level": level}
        for attempt, seat, practice, level in found
    }


def _measured(columns: Mapping[str, Column], found: Mapping[str, Any]) -> Row:
    """Return the values of a task's own columns by their names."""
    return {column.name: value_for(column, found.get(key)) for key, column in columns.items()}
