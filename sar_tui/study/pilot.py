"""The numbers of a power analysis, estimated from the sessions of a pilot study."""

import math
import sqlite3
import statistics
from collections.abc import Collection, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import msgspec

from sar_tui.store.counted import COUNTS, KEPT
from sar_tui.store.database import StoreError
from sar_tui.study.outcome import Number, Outcome

LEAST_PEOPLE = 5
"""People with two sessions, without whom nothing is estimated."""

_OF_ATTEMPTS = {
    "metric": "metric",
    "accuracy": "accuracy",
    "level": "level",
    "success_rate": "nullif(outcome, 'none')='success'",
}
_CHOSEN = (
    " FROM sessions JOIN seats ON seats.session=sessions.id"
    " JOIN attempts ON attempts.session=sessions.id AND attempts.seat=seats.seat"
    "{trials} WHERE {which} AND sessions.task IN (SELECT value FROM json_each(:tasks))"
    " AND NOT practice AND {value} IS NOT NULL"
)
_VALUES = "SELECT participant, sessions.id, {value}{chosen} ORDER BY participant, sessions.rowid"
_UNITS = "SELECT DISTINCT metric_unit{chosen}"
_METRICS = (
    "SELECT DISTINCT json_extract(software, '$.task.metric.name') FROM sessions"
    " WHERE task IN (SELECT value FROM json_each(:tasks))"
)
_TRIALS = (
    " JOIN trials ON trials.session=sessions.id AND trials.seat=seats.seat"
    " AND trials.attempt=attempts.attempt AND trials.correct"
)

Sessions = Sequence[Sequence[float]]
"""The values of each session of a person."""


class Pilot(msgspec.Struct, frozen=True):
    """Numbers from a pilot study, and what they rest on.

    ``trials`` counts those of all sessions: right trials of a reaction time, else attempts.
    """

    people: int
    sessions: int
    trials: int
    numbers: dict[str, Number]

    @property
    def sentence(self) -> str:
        """The sentence on what the numbers rest on, and how far off they may be."""
        off = 100 / math.sqrt(2 * (self.people - 1))
        return (
            f"The numbers rest on {self.people} people, {self.sessions} sessions and "
            f"{self.trials:,} trials. So few people make the SD between them uncertain by "
            f"{off:.0f} % or more."
        )


class Moments(NamedTuple):
    """Mean, and the standard deviations between people, of sessions and of trials."""

    mean: float
    person_sd: float
    session_sd: float
    trial_sd: float


def from_pilot(
    database: sqlite3.Connection,
    tasks: Collection[str],
    outcome: Outcome,
    unit: str,
    *,
    simulated: bool = False,
) -> Pilot:
    """Estimate the numbers of a measure from the sessions of some tasks that count.

    Args:
        database: of the pilot study.
        tasks: names.
        outcome: whose measure is estimated.
        unit: of the plan; the metric must have the same.
        simulated: of simulated sessions instead.

    Raises:
        StoreError: too few people, another unit, or the score of a form.
    """
    if outcome.is_form:
        raise StoreError(
            f"A pilot study tells numbers of sessions only: state those of {outcome.measure} in "
            "[power].",
            bad_input=True,
        )
    people = dict(_values(database, tasks, outcome, unit, simulated))
    names = " or ".join(sorted(tasks))
    repeated = sum(len(sessions) >= 2 for sessions in people.values())
    if repeated < LEAST_PEOPLE:
        raise StoreError(
            f"A pilot study needs {LEAST_PEOPLE} people with two sessions of {names}, and this one "
            f"has {repeated}.",
            bad_input=True,
        )
    sessions = [session for each in people.values() for session in each]
    trials = sum(map(len, sessions))
    found = moments(list(people.values()))
    source = f"pilot: {len(people)} people, {len(sessions)} sessions, {trials} trials"
    numbers = {
        name: Number(float(f"{value:.4g}"), source) for name, value in found._asdict().items()
    }
    numbers["trials"] = Number(max(1, round(trials / len(sessions))), source)
    return Pilot(len(people), len(sessions), trials, numbers)


def moments(people: Sequence[Sessions]) -> Moments:
    """Return the parts of the variance by the method of moments for unequal numbers (Searle,
    Casella & McCulloch 1992, Variance Components, chapter 5), with the means of sessions and of
    people weighted alike. A negative part is 0.

    The mean of n trials of a session has the variance session² + trial² / n around the person's
    own; sums of squares around means are set equal to what these parts let expect.

    Args:
        people: some with two sessions.
    """
    sessions = [session for each in people for session in each]
    spare = sum(len(session) - 1 for session in sessions)
    squares = math.fsum(_squares(session) for session in sessions)
    trial = squares / spare if spare else 0.0

    means = [[statistics.fmean(session) for session in each] for each in people]
    shares = [[1 / len(session) for session in each] for each in people]
    among = math.fsum(map(_squares, means))
    of_trials = math.fsum((1 - 1 / len(each)) * sum(each) for each in shares)
    session = max(0.0, (among - trial * of_trials) / sum(len(each) - 1 for each in people))

    own = [statistics.fmean(each) for each in means]
    of_sessions = statistics.fmean(
        sum(session + trial * share for share in each) / len(each) ** 2 for each in shares
    )
    person = max(0.0, statistics.variance(own) - of_sessions)
    return Moments(statistics.fmean(own), math.sqrt(person), math.sqrt(session), math.sqrt(trial))


def _squares(values: Sequence[float]) -> float:
    mean = statistics.fmean(values)
    return math.fsum((value - mean) ** 2 for value in values)


def _values(
    database: sqlite3.Connection,
    tasks: Collection[str],
    outcome: Outcome,
    unit: str,
    simulated: bool,
) -> Iterator[tuple[str, list[list[float]]]]:
    """Yield each participant with the values of their sessions. Raises StoreError."""
    given = {"tasks": msgspec.json.encode(sorted(tasks)).decode()}
    value, trials = _OF_ATTEMPTS[outcome.measure], ""
    if outcome.measure == "metric":
        metrics = {name for (name,) in database.execute(_METRICS, given)}
        if metrics == {"reaction_time"}:
            value, trials = "trials.reaction_time_ms", _TRIALS
    which = f"sessions.mode='simulated' AND {KEPT}" if simulated else COUNTS
    chosen = _CHOSEN.format(trials=trials, which=which, value=value)
    if outcome.measure == "metric":
        units = {stored for (stored,) in database.execute(_UNITS.format(chosen=chosen), given)}
        if units - {unit}:
            raise StoreError(
                f"[power] unit is {unit!r}, and the pilot study's results are in "
                f"{' and '.join(map(repr, sorted(units - {unit})))}.",
                bad_input=True,
            )
    rows = database.execute(_VALUES.format(value=value, chosen=chosen), given)
    for participant, of_person in groupby(rows, key=lambda row: row[0]):
        sessions = groupby(of_person, key=lambda row: row[1])
        yield participant, [[float(row[2]) for row in session] for _, session in sessions]
