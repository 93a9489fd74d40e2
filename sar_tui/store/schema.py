"""Tables and views of a new database, and the upgrade of one that an earlier release wrote.

The tables are made from `store.tables`. The views are of messages, of the newest settings, and for
any program that reads SQLite (3.34 or newer) of attempts, trials and reaches, a row each. Columns of
both are a contract: see docs/data-dictionary.md.
"""

import sqlite3
from typing import TYPE_CHECKING

from sar_tui.store import tables

if TYPE_CHECKING:
    import sqlite_utils


def create(database: sqlite3.Connection) -> None:
    """Give an empty database all tables and views."""
    db = _utils(database)
    with db.atomic():
        for table in tables.TABLES.values():
            _create(database, table)
        database.execute(_TOPIC_OF_PRESENCE)
        _create_views(db)
        database.execute(f"PRAGMA user_version={tables.VERSION}")


def upgrade(database: sqlite3.Connection, version: int) -> None:
    """Add what later versions of the data declare to a database of an earlier one."""
    db = _utils(database)
    with db.atomic():
        for table in tables.TABLES.values():
            if table.since > version:
                _create(database, table)
                continue
            for column in table.columns:
                if column.since > version:
                    database.execute(f"ALTER TABLE {table.name} ADD COLUMN {column.definition}")
        _create_views(db)
        database.execute(f"PRAGMA user_version={tables.VERSION}")


def _utils(database: sqlite3.Connection) -> "sqlite_utils.Database":
    import sqlite_utils  # loads slowly, and is needed only here

    return sqlite_utils.Database(database)


def _create(database: sqlite3.Connection, table: tables.Table) -> None:
    for statement in (table.create, *table.indexes):
        database.execute(statement)


def _create_views(db: "sqlite_utils.Database") -> None:
    for name, query in VIEWS.items():
        db.create_view(name, query, replace=True)


_TOPIC_OF_PRESENCE = "INSERT INTO topics (id, name, fields) VALUES (1, 'operator/presence', '')"
"""Its number is a literal in an index."""


# --- views

_VALUE = "substr({pair}, 2, length({pair}) - 7)"
"""A value in a JSON array as it is written there, from the array of it and null: SQLite's ``->`` is
not everywhere.
"""
_STORED = _VALUE.format(pair="json_extract(messages.message, '$[' || field.key || ']', '$.none')")
_DEFAULT = _VALUE.format(pair="json_extract(field.value, '$[1]', '$.none')")

_EVENTS = f"""
SELECT session_numbers.id AS session, messages.seq, messages.run, messages.at_ns,
    topics.name AS topic,
    CASE topics.fields WHEN '' THEN messages.message ELSE (
        SELECT json_group_object(json_extract(field.value, '$[0]'),
            json(CASE WHEN field.key < json_array_length(messages.message) THEN {_STORED} ELSE {_DEFAULT} END))
        FROM json_each(topics.fields) AS field
    ) END AS message
FROM session_numbers
JOIN messages ON messages.session_number=session_numbers.number
JOIN topics ON topics.id=messages.topic"""
_SETTINGS = (
    "SELECT participant, task, parameters, theme, created_at AS updated_at"
    " FROM programmes AS saved WHERE version="
    "(SELECT max(version) FROM programmes WHERE participant=saved.participant AND task=saved.task)"
)

_REACH = {
    "text": ("closed", "mark", "hand", "detector", "detector_version"),
    "measures": (
        "marker_cm", "reach_time_ms", "orientation_reach_time_ms", "single_axis_reach_time_ms",
        "fixed_threshold_reach_time_ms",
        "out_ms", "dwell_ms", "back_ms", "turn_after_ms", "peak_extension_rad_s", "peak_return_rad_s",
        "time_to_peak_ms", "time_to_peak_share", "movement_units_out", "movement_units_back", "movement_units",
        "sparc_out", "sparc_back", "sparc", "ldlj_out", "ldlj_back", "excursion_deg", "straightness",
        "return_error_deg", "inclination_rest_deg", "inclination_target_deg", "trunk_excursion_deg",
        "compensation_share", "tremor_index", "tremor_rest_hz", "tremor_rest_rad_s", "tremor_action_rad_s", "reaches",
        "samples", "rate_hz", "measures_version",
    ),
}  # fmt: skip
"""Fields of ``trials.details`` that are columns of the view of reaches."""

SITE = "coalesce(nullif({column}, ''), (SELECT code FROM site), '')"
"""The site of a row in words: an empty one is the database's own, which may have no code yet."""
_WHO = (
    "(SELECT participant FROM seats WHERE seats.session={row}.session AND seats.seat={row}.seat) "
    "AS participant, "
    + SITE.format(column="sessions.site")
    + " AS site, {row}.session, task, mode, sessions.status AS session_status, "
    + ", ".join(
        f"json_extract(sessions.study, '$.{part}') AS {name}"
        for part, name in (
            ("study", "study"),
            ("visit", "visit"),
            ("block", "block"),
            ("condition", "study_condition"),
            ("position", "order_position"),
        )
    )
    + ", {row}.attempt"
)
_TIME = (
    "(SELECT strftime('%Y-%m-%dT%H:%M:%f+00:00', json_extract(clock_anchor, '$.utc'),"
    " printf('%+.3f seconds', ({at} - json_extract(clock_anchor, '$.clock_ns')) / 1e9))"
    " FROM runs WHERE runs.session={row}.session AND runs.run={run}) AS started_at"
)
"""A moment of a run by the time of day (UTC), from its steady clock."""
_ATTEMPT = "practice, level, condition, goal, metric_unit, outcome"
_OF_TRIALS = (
    "FROM trials JOIN sessions ON sessions.id=trials.session LEFT JOIN attempts ON "
    "attempts.session=trials.session"
    " AND attempts.attempt=trials.attempt AND attempts.seat=trials.seat"
)
_ONSET = _TIME.format(row="trials", at="trials.onset_ns", run="trials.run")
_FLAGS = "json_extract(timing, '$.flags') AS flags"

_ATTEMPTS = f"""
SELECT {_WHO.format(row="attempts")}, attempts.seat, {_ATTEMPT},
    metric, accuracy, correct, trials, feedback,
    {
    _TIME.format(
        row="attempts",
        at="attempts.started_ns",
        run="coalesce((SELECT min(trials.run) FROM trials WHERE trials.session=attempts.session"
        " AND trials.attempt=attempts.attempt), attempts.run)",
    )
},
    (SELECT avg(reaction_time_ms) FROM trials WHERE trials.session=attempts.session
        AND trials.attempt=attempts.attempt AND trials.seat=attempts.seat AND trials.correct) AS reaction_time_ms
FROM attempts JOIN sessions ON sessions.id=attempts.session"""

_TRIALS = f"""
SELECT {_WHO.format(row="trials")}, trials.trial, trials.seat, {_ATTEMPT}, stimulus, response, trials.correct,
    reaction_time_ms, {_ONSET}, {_FLAGS}
{_OF_TRIALS}"""

_REACHES = f"""
SELECT {_WHO.format(row="trials")}, trials.trial, trials.seat, {_ATTEMPT}, trials.correct, reaction_time_ms, {_ONSET},
    {", ".join(f"json_extract(details, '$.{name}') AS {name}" for names in _REACH.values() for name in names)}, {_FLAGS}
{_OF_TRIALS}
WHERE json_extract(details, '$.reach_time_ms') IS NOT NULL"""

VIEWS = {
    "events": _EVENTS,
    "settings": _SETTINGS,
    "v_attempts": _ATTEMPTS,
    "v_trials": _TRIALS,
    "v_reaches": _REACHES,
}
"""The query of each view, by name."""
