"""A stored session by other parameters to its end: as recorded up to the first other prompt, then
modelled.
"""

import math
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded
from sar_tui.plugins import Catalogue
from sar_tui.replay.played_again import Responses, play, read_responses
from sar_tui.replay.replay import check_whole
from sar_tui.replay.rescore import changes_only_scores
from sar_tui.replay.response_model import (
    FEWEST_ATTEMPTS,
    FEWEST_RESPONSES,
    Counts,
    Fit,
    Floats,
    Response,
    ResponseModel,
)
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Failed, without_outputs
from sar_tui.store import sessions

RUNS = 200
COVERAGE = 0.9
"""Least share of the runs that lie in the interval."""
_SCORES_TOO = ("attempts",)
"""Settings that change no recorded prompt beside those that change only scores."""


class Summary(msgspec.Struct, frozen=True):
    """A session in numbers. Practice does not count.

    Attributes:
        attempts: number of attempts.
        final_level: level of the last one.
        mean_level: mean of the attempts' levels.
        mean_metric: mean of the attempts' results.
        accuracy: share of correct trials.
        successes: share of attempts that reached their goal.
        positive_feedbacks: number of attempts with positive feedback.
    """

    attempts: int
    final_level: int
    mean_level: float
    mean_metric: float | None
    accuracy: float | None
    successes: float
    positive_feedbacks: int


class Forecast(msgspec.Struct, frozen=True):
    """One number of the session: as recorded, and in the runs. None: there is no such number.

    ``share``: of the runs from ``low`` to ``high``; more than the `COVERAGE` if the number has few
    values.
    """

    name: str
    recorded: float | None
    median: float | None
    low: float | None
    high: float | None
    share: float | None


class Forked(msgspec.Struct, frozen=True):
    """A session by other parameters to its end: a model, not data.

    Attributes:
        session: its id.
        what_if: the changed parameters.
        record_ends_at_attempt: the attempt with the first prompt that would have been another: from
            there on, responses are drawn from the model. None if all prompts are those of the
            record, so that nothing is modelled.
        runs: number of runs; 1 if nothing is modelled.
        seed: of the first run; the others have the numbers after it.
        coverage: least share of the runs in each interval.
        model: the model and its fit; None if nothing is modelled.
        numbers: each with its interval.
    """

    session: str
    what_if: dict[str, Any]
    record_ends_at_attempt: int | None
    runs: int
    seed: int
    coverage: float
    model: Fit | None
    numbers: tuple[Forecast, ...]


def fork(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    row: sessions.Row,
    changed: Mapping[str, object],
    runs: int = RUNS,
    progress: Callable[[int], None] = lambda done: None,
) -> Forked:
    """Run a stored session by other parameters, often, with a model of its participant from the
    first other prompt on.

    Args:
        database: only read.
        folder: the data folder.
        catalogue: where the task is found.
        row: of the session, from `store.sessions.find`.
        changed: parameters, typed or as text.
        runs: number of runs.
        progress: called with the number of runs done.

    Raises:
        StoreError, PluginError: as `replay.replay`.
        ParameterError: a parameter is unknown or out of bounds.
        Failed: the session cannot be modelled: the message says why.
    """
    check_whole(database, folder, row)
    kind = catalogue.task(row["task"])
    before = without_outputs(kind, build(kind.Parameters, row["parameters"]))
    after = build(kind.Parameters, {**row["parameters"], **changed})
    _check_kind(row, before)
    record = read_responses(database, row)
    same = play(kind, before.parameters, record, row["seed"], record, None)
    if same.forked_at is not None or _scores(same.ended) != _scores(record.ended):
        raise Failed(
            f"The session {row['id']} does not come out as recorded from its responses alone: "
            "perhaps something acted "
            "on it, or the task has changed since. It cannot be forked."
        )
    model = None
    is_exact = all(changes_only_scores(kind, name) or name in _SCORES_TOO for name in changed)
    kept = record if is_exact else None
    seed = int(row["seed"])
    first = play(kind, after, record, seed, kept, None)
    if first.forked_at is None:
        ended = [first.ended]
    else:
        model = _fit(row, record)
        ended = []
        for number in range(runs):
            ended.append(
                play(
                    kind, after, record, seed, kept, model.draw(seed + number), seed + number
                ).ended
            )
            progress(number + 1)
    what_if = msgspec.to_builtins(after)
    return Forked(
        session=row["id"],
        what_if={name: what_if[name] for name in changed},
        record_ends_at_attempt=first.forked_at,
        runs=len(ended),
        seed=seed,
        coverage=COVERAGE,
        model=model.fit if model else None,
        numbers=forecasts(summary(record.ended), [summary(one) for one in ended]),
    )


def _check_kind(row: sessions.Row, task: Task) -> None:
    """Raise Failed if the people who do such sessions cannot be modelled."""
    if row["status"] != "completed":
        raise Failed(
            f"The session {row['id']} was not completed. Only a completed session can be forked."
        )
    if len(task.seats) > 1:
        raise Failed(
            "A session of two cannot be forked: how one responds depends on the other, which is "
            "not modelled."
        )
    if task.sensor_seats(task.parameters) or task.start_key:
        raise Failed(
            f"A session of {task.name} cannot be forked: there is a model of key presses only, "
            "not of movements."
        )


def _fit(row: sessions.Row, record: Responses) -> ResponseModel:
    """Fit the model to all trials of the record. Raises Failed if there are too few."""
    responses = [
        Response(key[0], record.prompts[key].choices, trial.reaction_time_ms)
        for key, trial in record.trials.items()
        if trial.correct
        and trial.reaction_time_ms is not None
        and "anticipation" not in trial.timing.flags
    ]
    attempts = {one.attempt for one in responses}
    if len(responses) < FEWEST_RESPONSES or len(attempts) < FEWEST_ATTEMPTS:
        raise Failed(
            f"The session {row['id']} has {len(responses)} correct responses in {len(attempts)} "
            "attempts: too few for "
            f"a model, which needs {FEWEST_RESPONSES} in {FEWEST_ATTEMPTS}."
        )
    missed = sum(trial.response is None for trial in record.trials.values())
    wrong = sum(
        trial.response is not None and not trial.correct for trial in record.trials.values()
    )
    counts = Counts(
        len(record.trials), missed, wrong, len(record.offered), len(record.asked & record.offered)
    )
    return ResponseModel(responses, counts)


def _scores(ended: Sequence[AttemptEnded]) -> list[tuple[object, ...]]:
    return [
        (one.attempt, one.level, one.metric, one.accuracy, one.outcome, one.feedback)
        for one in ended
    ]


def summary(ended: Sequence[AttemptEnded]) -> Summary:
    """Return a session's attempts in numbers."""
    scored = [one for one in ended if not one.practice]
    if not scored:
        return Summary(0, 0, 0.0, None, None, 0.0, 0)
    metrics = [one.metric for one in scored if one.metric is not None]
    trials = sum(one.trials for one in scored)
    return Summary(
        attempts=len(scored),
        final_level=scored[-1].level,
        mean_level=sum(one.level for one in scored) / len(scored),
        mean_metric=sum(metrics) / len(metrics) if metrics else None,
        accuracy=sum(one.correct for one in scored) / trials if trials else None,
        successes=sum(one.outcome == "success" for one in scored) / len(scored),
        positive_feedbacks=sum(one.feedback == "positive" for one in scored),
    )


def forecasts(recorded: Summary, runs: Sequence[Summary]) -> tuple[Forecast, ...]:
    """Return each number with its median and its interval over the runs."""
    return tuple(_forecast(name, recorded, runs) for name in Summary.__struct_fields__)


def _forecast(name: str, recorded: Summary, runs: Sequence[Summary]) -> Forecast:
    values = np.sort([value for one in runs if (value := getattr(one, name)) is not None])
    if not len(values):
        return Forecast(name, getattr(recorded, name), None, None, None, None)
    low, high = _shortest_interval(values)
    share = float(np.mean((values >= low) & (values <= high)))
    return Forecast(name, getattr(recorded, name), float(np.median(values)), low, high, share)


def _shortest_interval(values: Floats) -> tuple[float, float]:
    """Return the shortest interval with `COVERAGE` of sorted values, and of equally short ones that
    with most.

    A number with few values, such as a level, gets no more of them than it needs: quantiles would
    hold too many.
    """
    count = math.ceil(COVERAGE * len(values))
    lows, highs = values[: len(values) - count + 1], values[count - 1 :]
    shortest = np.flatnonzero(highs - lows <= (highs - lows).min() + 1e-12)
    held = np.searchsorted(values, highs[shortest], "right") - np.searchsorted(
        values, lows[shortest], "left"
    )
    best = shortest[np.argmax(held)]
    return float(lows[best]), float(highs[best])
