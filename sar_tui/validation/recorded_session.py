"""The thesis' figures of a recorded session, as far as it has what they show."""

import sqlite3
from collections.abc import Callable, Mapping
from typing import Any

from sar_tui.model.trial_types import Metric
from sar_tui.store import imu, provenance, sessions
from sar_tui.validation import charts
from sar_tui.validation.charts import draw_feedback, draw_levels
from sar_tui.validation.report import Column, Report, Row

TITLES = {
    "figure-4.4": "Figure 4.4 of this session: result and level of each attempt",
    "figure-4.8": "Figure 4.8 of this session: angular velocity about z",
    "figure-4.11": "Figure 4.11 of this session: the feedback on each attempt",
    "figure-4.13": "Figure 4.13 of this session: what was said",
    "table-4.1": "Table 4.1 of this session: reach times and amplitudes",
}
_LISTED = 30
"""Sentences in the figure; the file has all."""
_WHY_NOT = {
    "figure-4.4": "it has no finished attempt whose result could be timed",
    "figure-4.8": "it has no samples of a motion sensor",
    "figure-4.11": "it has no finished attempt whose result could be timed",
    "figure-4.13": "no feedback was given in it",
    "table-4.1": "no reach was found in it",
}

_NOT_OF_A_SESSION = (
    "figure-4.9, figure-4.10: as figure-4.4, of other people. figure-4.12: as figure-4.11.",
    "figure-4.14: compares two settings; a session has one.",
    "figure-4.15, table-4.2: are about the program, not about a session.",
)


def reports(
    database: sqlite3.Connection, row: Mapping[str, Any]
) -> tuple[dict[str, Report], list[str]]:
    """Return the figures that a session has, by name, and a sentence on each that it has not.

    Args:
        database: only read.
        row: of the session, from `store.sessions.find`.
    """
    made: dict[str, Callable[[], Report | None]] = {
        "figure-4.4": lambda: _levels(database, row),
        "figure-4.8": lambda: _velocity(database, row),
        "figure-4.11": lambda: _feedback(database, row),
        "figure-4.13": lambda: _said(database, row),
        "table-4.1": lambda: _reaches(database, row),
    }
    found = {name: report for name, make in made.items() if (report := make()) is not None}
    return found, [
        *(f"{name}: {_WHY_NOT[name]}." for name in made if name not in found),
        *_NOT_OF_A_SESSION,
    ]


def _attempts(database: sqlite3.Connection, row: Mapping[str, Any]) -> list[Row]:
    """Return a row for each attempt at seat A, practice left out. Drawings know the result as
    ``reaction_time_ms``.
    """
    return [
        {
            "attempt": attempt["attempt"],
            "level": attempt["level"],
            "reaction_time_ms": attempt["metric"],
            "goal_ms": attempt["goal"],
            "accuracy": attempt["accuracy"],
            "outcome": attempt["outcome"],
            "feedback": attempt["feedback"],
        }
        for attempt in sessions.rows(database, "attempts", row["id"])
        if attempt["seat"] == "A" and not attempt["practice"]
    ]


def _timed(database: sqlite3.Connection, row: Mapping[str, Any]) -> list[Row]:
    rows = _attempts(database, row)
    has_result = any(each["reaction_time_ms"] is not None for each in rows)
    return rows if has_result and all(each["goal_ms"] is not None for each in rows) else []


def _title(row: Mapping[str, Any]) -> str:
    metric = _metric(row)
    return (
        f"Session {row['id']}: {row['task']}, {row['participant']}; "
        f"{metric.name.replace('_', ' ')} ({metric.unit})"
    )


def _levels(database: sqlite3.Connection, row: Mapping[str, Any]) -> Report | None:
    if not (rows := _timed(database, row)):
        return None
    label = _metric(row).label
    return Report(
        _named(rows, row),
        [],
        [],
        [draw_levels(rows, _title(row), label)],
        chart=charts.adaptation(rows, label),
    )


def _feedback(database: sqlite3.Connection, row: Mapping[str, Any]) -> Report | None:
    if not (rows := _timed(database, row)):
        return None
    label, title = _metric(row).label, _title(row)
    chart = charts.feedback([(title, rows)], label)
    return Report(_named(rows, row), [], [], [draw_feedback(rows, title, label)], chart=chart)


def _metric(row: Mapping[str, Any]) -> Metric:
    found: Metric = provenance.metric(row["software"])
    return found


def _named(rows: list[Row], row: Mapping[str, Any]) -> list[Row]:
    """Return the rows with the result under the name and unit of the task's metric, as
    ``reach_time_ms``.
    """
    metric = _metric(row)
    names = {
        "reaction_time_ms": f"{metric.name}_{metric.unit}".rstrip("_"),
        "goal_ms": f"goal_{metric.unit}".rstrip("_"),
    }
    return [{names.get(name, name): value for name, value in each.items()} for each in rows]


def _said(database: sqlite3.Connection, row: Mapping[str, Any]) -> Report | None:
    rows = [
        {name: action["final"].get(name) for name in ("attempt", "valence", "text")}
        for action in sessions.rows(database, "actions", row["id"])
        if action["kind"] == "feedback" and action["final"] and action["final"].get("text")
    ]
    return (
        Report(rows, [_SAID], [], chart=charts.sentences(rows[:_LISTED], "valence"))
        if rows
        else None
    )


def _velocity(database: sqlite3.Connection, row: Mapping[str, Any]) -> Report | None:
    from sar_tui.validation.table_4_1 import velocity_figure, velocity_rows

    (run,) = database.execute(
        "SELECT min(run) FROM imu_streams WHERE session=?", (row["id"],)
    ).fetchone()
    samples = imu.samples(database, row["id"], run=run)  # stamps of another run may overlap
    if not len(samples):
        return None
    times = (samples["at"] - samples["at"][0]) / 1e9
    return velocity_figure(velocity_rows(times, samples["rate"][:, 2]), _title(row), [])


def _reaches(database: sqlite3.Connection, row: Mapping[str, Any]) -> Report | None:
    rows = [
        {
            "attempt": trial["attempt"],
            "reach": trial["trial"],
            "reach_time_s": details["reach_time_ms"] / 1000,
            "peak_extension_rad_s": details.get("peak_extension_rad_s"),
            "peak_return_rad_s": details.get("peak_return_rad_s"),
        }
        for trial in sessions.rows(database, "trials", row["id"])
        if (details := trial["details"] or {}).get("reach_time_ms") is not None
    ]
    return Report(rows, [_REACHES], []) if rows else None


def _number(name: str, form: str) -> Callable[[Row], str | None]:
    return lambda row: None if row[name] is None else format(row[name], form)


_SAID = (
    Column("attempt", lambda row: str(row["attempt"])),
    Column("valence", lambda row: row["valence"], is_number=False),
    Column("what was said", lambda row: str(row["text"]), is_number=False),
)
_REACHES = (
    Column("attempt", lambda row: str(row["attempt"])),
    Column("reach", lambda row: str(row["reach"])),
    Column("reach time, s", _number("reach_time_s", ".4f")),
    Column("extension, rad/s", _number("peak_extension_rad_s", ".4f")),
    Column("return, rad/s", _number("peak_return_rad_s", ".4f")),
)
