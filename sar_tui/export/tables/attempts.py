"""Attempts: a row for each seat that took part."""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import msgspec

from sar_tui.export.columns import (
    MODE,
    PARTICIPANT,
    SEAT,
    SESSION,
    TASK,
    TO_SESSION,
    Column,
    Table,
    Values,
    as_bool,
    finite,
)
from sar_tui.export.columns import stored as _stored
from sar_tui.export.damage import Damage
from sar_tui.export.json_columns import columns, value_for
from sar_tui.export.run_numbers import runs_of_starts
from sar_tui.export.seats import codes_by_seat
from sar_tui.rules.feedback import POLICIES

_CHOICE = {
    "schedule": _stored(
        "attempts.choice.schedule",
        "string",
        "The rule that decides when feedback is due.",
        levels=tuple(POLICIES),
    ),
    "due": _stored("attempts.choice.due", "boolean", "True if feedback was due."),
    "why": _stored("attempts.choice.why", "string", "The reason, in a sentence."),
    "since": _stored(
        "attempts.choice.since",
        "integer",
        "Scored attempts since the last feedback, including this one.",
    ),
    "interval": _stored(
        "attempts.choice.interval", "integer", "Attempts after which feedback is due."
    ),
    "tolerance": _stored(
        "attempts.choice.tolerance",
        "number",
        "Largest distance from the goal without feedback, in the metric's unit.",
    ),
    "attempts": _stored(
        "attempts.choice.attempts", "integer", "Number of attempts that the feedback sums up."
    ),
    "content": _stored(
        "attempts.choice.content", "string", "Feedback is about results, performance, or both."
    ),
    "form": _stored(
        "attempts.choice.form", "string", "Feedback is qualitative, quantitative, or both."
    ),
    "compared_with": _stored(
        "attempts.choice.compared_with", "string", "What the result is compared with."
    ),
    "degree": _stored("attempts.choice.degree", "string", "Distance of the result from the goal."),
    "delay_ms": _stored(
        "attempts.choice.delay_ms",
        "number",
        "From the end of the attempt to its feedback.",
        unit="ms",
    ),
}
_PLAIN = (
    SESSION,
    MODE,
    TASK,
    PARTICIPANT,
    _stored(
        "attempts.attempt",
        "integer",
        "Number of the attempt in the session, from 1.",
        required=True,
    ),
    SEAT,
    _stored("attempts.run", "integer", "The run of the program in which it ended.", required=True),
    _stored("attempts.practice", "boolean", "True for practice, which never changes the level."),
    _stored("attempts.level", "integer", "The level it was done at."),
    _stored("attempts.condition", "string", "Its condition; empty in a task without conditions."),
    _stored(
        "attempts.metric",
        "number",
        "The result; missing without a metric, or if no response could be timed.",
    ),
    _stored(
        "attempts.metric_unit", "string", "The unit of the result, the goal and the tolerance."
    ),
    _stored("attempts.goal", "number", "The goal of the metric; missing if it had none."),
    _stored("attempts.accuracy", "number", "Share of right responses, 0 to 1."),
    _stored("attempts.correct", "integer", "Number of right responses."),
    _stored("attempts.trials", "integer", "Number of prompts."),
    _stored(
        "attempts.outcome",
        "string",
        "Success: better than the goal, and accurate enough. None: it had no goal.",
        levels=("success", "failure", "none"),
    ),
    _stored(
        "attempts.feedback",
        "string",
        "The feedback that followed; none if none was due or asked for.",
        levels=("positive", "neutral", "negative", "none"),
    ),
    _stored(
        "messages.run",
        "integer",
        "The run of the program in which it began; another one than that of its end if it was "
        "interrupted.",
        name="started_run",
    ),
    _stored(
        "attempts.started_ns", "integer", "When it began, steady clock of started_run.", unit="ns"
    ),
    _stored(
        "attempts.ended_ns", "integer", "Its last response, steady clock of its run.", unit="ns"
    ),
)


def attempts(database: sqlite3.Connection, sessions: Sequence[str], damage: Damage) -> Table:
    """Return the table of the attempts of these sessions, with a column for each of their
    qualities.
    """
    qualities = columns(database, sessions, "attempts", "qualities", {})
    named = {
        key: msgspec.structs.replace(each, meaning="Mean over the right trials, or another measure of the attempt.")
        for key, each in qualities.items()
    }  # fmt: skip
    choice = [msgspec.structs.replace(each, name=f"choice_{key}") for key, each in _CHOICE.items()]
    return Table(
        name="attempts",
        title="An attempt at a seat",
        columns=(*_PLAIN, *choice, *named.values()),
        key=("session", "attempt", "seat"),
        rows=partial(_rows, named, damage),
        references=(TO_SESSION,),
    )


def _rows(
    qualities: Mapping[str, Column], damage: Damage, database: sqlite3.Connection, session: str
) -> Iterator[Values]:
    codes = codes_by_seat(database, session)
    started_run = runs_of_starts(database, session, damage)
    for (
        id,
        mode,
        task,
        attempt,
        seat,
        run,
        practice,
        level,
        condition,
        metric,
        *rest,
        began,
        ended,
        chosen,
        measured,
    ) in database.execute(
        "SELECT sessions.id, mode, task, attempt, seat, run, practice, level, condition, metric, "
        "metric_unit, goal,"
        " accuracy, correct, trials, outcome, feedback, started_ns, ended_ns, choice, qualities"
        " FROM attempts JOIN sessions ON sessions.id=session WHERE session=? ORDER BY attempt, "
        "seat",
        (session,),
    ):
        decided, found = damage.object_of("choice", chosen), damage.object_of("qualities", measured)
        yield (
            id, mode, task, codes.get(seat), attempt, seat, run, as_bool(practice), level, condition,
            finite(metric), *rest, started_run(attempt), began, ended,
            *(decided.get(key) for key in _CHOICE),
            *(value_for(column, found.get(key)) for key, column in qualities.items()),
        )  # fmt: skip
