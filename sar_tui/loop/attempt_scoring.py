"""Scores an attempt for each seat: the row to store, and the feedback on it. Pure."""

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import TypeVar

import msgspec
from msgspec.structs import replace

from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Feedback, FeedbackChoice, Outcome, Spread
from sar_tui.model.trial_types import DOUBTFUL, UNSURE, PastAttempt, Result, Score, Target
from sar_tui.model.units import MS
from sar_tui.rules import feedback_choice
from sar_tui.rules.feedback import History
from sar_tui.rules.judgement import (
    RACED,
    JudgedAttempt,
    Judgement,
    degree,
    judge,
    judge_race,
    judge_summary,
)

_T = TypeVar("_T", bound=msgspec.Struct)
Histories = Mapping[str, History]
"""The feedback history of each seat."""
_FAILURE_FIRST: tuple[Outcome, ...] = ("failure", "success")


class AttemptFacts(msgspec.Struct, frozen=True):
    """The attempt that is scored, and when it ran (ns)."""

    attempt: int
    practice: bool
    level: int
    started: int
    ended: int
    condition: str = ""


class SeatScore(msgspec.Struct, frozen=True):
    """An attempt's row and feedback for one seat.

    The feedback is built whether or not it is due, because the participant may request it; None
    without a goal.
    """

    ended: AttemptEnded
    feedback: Feedback | None

    @property
    def is_feedback_due(self) -> bool:
        """True if the feedback is given now."""
        return self.ended.feedback != "none"


class ScoredSeats(msgspec.Struct, frozen=True):
    """Scores and new histories by seat, and what counts for the level: the worst of the seats.

    Attributes:
        seats, histories: by seat.
        outcome: a success if every seat reached the goal.
        result: the worst of the results; None if a seat has none, or too few right responses.
        reached: prompts answered right and better than the goal, of the seat with the smallest
            share.
        prompts: all prompts of that seat.
        past: the attempt as a later one sees it, by seat.
    """

    seats: dict[str, SeatScore]
    histories: Histories
    outcome: Outcome
    result: float | None
    reached: int
    prompts: int
    past: Mapping[str, PastAttempt] = {}


def score_seats(
    task: Task,
    attempt: AttemptFacts,
    results: Mapping[str, Sequence[Result]],
    histories: Histories,
    scored: Sequence[Mapping[str, PastAttempt]] = (),
) -> ScoredSeats:
    """Score an attempt for each seat that has results.

    The level is shared: the attempt counts as a success only if every seat reached the goal. In a
    race the feedback says who won; this does not affect the outcome. An attempt of a seat whose
    trials are all unsure is not judged. ``scored``: the earlier attempts, by seat, oldest first.
    """
    done = {seat: results[seat] for seat in task.seats if results.get(seat)}
    scores = {seat: _score(task, mine) for seat, mine in done.items()}
    declared = None if task.metric.is_none else task.target(attempt.level)
    if declared is None or not all(map(_sure, done.values())):
        return _not_judged(task, attempt, scores, results, histories, scored)
    target = _checked(declared, Target)
    enough = task.parameters.min_accuracy
    judgements = {seat: judge(score, task.metric, target, enough) for seat, score in scores.items()}
    reported = judge_race(scores, judgements)
    seats, updated, past = {}, dict(histories), {}
    for seat, score in scores.items():
        judged = JudgedAttempt(score, target, judgements[seat])
        earlier = [each[seat] for each in scored if seat in each]
        past[seat] = _past(task, attempt, score, results[seat], earlier)
        seats[seat], updated[seat] = _score_seat(
            task,
            attempt,
            seat,
            results[seat],
            judged,
            reported[seat],
            histories[seat],
            past[seat].measures,
        )
    outcome = min(
        (judgement.outcome for judgement in judgements.values()), key=_FAILURE_FIRST.index
    )
    judged_seats = [
        JudgedAttempt(score, target, judgements[seat]) for seat, score in scores.items()
    ]
    reached, prompts = min(
        (_reached(task, target, _sure(mine)) for mine in done.values()), key=_share
    )
    return ScoredSeats(seats, updated, outcome, _worst(task, judged_seats), reached, prompts, past)


def _sure(results: Sequence[Result]) -> list[Result]:
    """Return the results that are scored."""
    return [result for result in results if UNSURE not in result.flags]


def _not_judged(
    task: Task,
    attempt: AttemptFacts,
    scores: Mapping[str, Score],
    results: Mapping[str, Sequence[Result]],
    histories: Histories,
    scored: Sequence[Mapping[str, PastAttempt]],
) -> ScoredSeats:
    """Score an attempt that is not judged: it gets no feedback, and the level does not follow from
    it.
    """
    seats, past = {}, {}
    for seat, score in scores.items():
        past[seat] = _past(
            task, attempt, score, results[seat], [each[seat] for each in scored if seat in each]
        )
        ended = AttemptEnded(
            seat=seat,
            attempt=attempt.attempt,
            practice=attempt.practice,
            level=attempt.level,
            metric=score.metric,
            metric_unit=task.metric.unit,
            accuracy=score.accuracy,
            correct=score.correct,
            trials=score.trials,
            outcome="none",
            feedback="none",
            qualities=past[seat].measures,
            spreads=_spreads(task, score, results[seat]),
            started=attempt.started,
            ended=attempt.ended,
            condition=attempt.condition,
        )
        seats[seat] = SeatScore(ended, None)
    prompts = max((score.trials for score in scores.values()), default=0)
    return ScoredSeats(seats, histories, "none", None, 0, prompts, past)


def _past(
    task: Task,
    attempt: AttemptFacts,
    score: Score,
    results: Sequence[Result],
    earlier: Sequence[PastAttempt],
) -> PastAttempt:
    """Return the attempt as later ones see it, with the measures of the task and those that compare
    it with them.
    """
    sure = _sure(results)
    measures = _mean_qualities(task, results)
    if sure:
        measures |= _checked_measures(task.measures(sure), "measures")
    past = PastAttempt(
        attempt.attempt, attempt.practice, attempt.level, score, measures, attempt.condition
    )
    return replace(
        past, measures=measures | _checked_measures(task.learning(past, earlier), "learning")
    )


def _checked_measures(measures: object, method: str) -> dict[str, float]:
    """Return what a method of a task measured. Raises TypeError if it is not finite numbers by
    name.
    """
    if not isinstance(measures, dict) or not all(isinstance(name, str) for name in measures):
        raise TypeError(f"{method}() returned {measures!r:.60}, not numbers by name")
    for name, value in measures.items():
        if not (isinstance(value, int | float) and math.isfinite(value)):
            raise TypeError(
                f"{method}() returned {value!r:.60} for {name}, not a finite number: leave it out"
            )
    return measures


def _worst(task: Task, attempts: Sequence[JudgedAttempt]) -> float | None:
    """Return the worst result of the seats; None if one has none."""
    found = [None if judged.has_no_result else judged.score.metric for judged in attempts]
    values = [value for value in found if value is not None]
    if len(values) < len(found):
        return None
    return max(values) if task.metric.better == "lower" else min(values)


def _reached(task: Task, target: Target, results: Sequence[Result]) -> tuple[int, int]:
    """Return how many prompts were answered right and better than the goal, and the number of
    all.
    """
    reached = [
        result.counts
        and result.value is not None
        and task.metric.is_better(result.value, target.threshold)
        for result in results
    ]
    return sum(reached), len(reached)


def _share(counted: tuple[int, int]) -> float:
    return counted[0] / counted[1]


def _score(task: Task, results: Sequence[Result]) -> Score:
    """Return the task's score of an attempt. Raises an error if it cannot be one."""
    if not (sure := _sure(results)):
        return Score(None, None, 0, len(results))
    score = _checked(task.score(sure), Score)
    score = replace(score, trials=score.trials + len(results) - len(sure))
    if task.metric.is_none:
        score = replace(score, metric=None)
    if not 0 <= score.correct <= score.trials:
        raise ValueError(
            f"the score of an attempt has {score.correct} right responses of {score.trials}"
        )
    if score.accuracy is not None and not 0 <= score.accuracy <= 1:
        raise ValueError(
            f"the score of an attempt has an accuracy of {score.accuracy:g}; it goes from 0 to 1"
        )
    return score


def _checked(value: _T, kind: type[_T]) -> _T:
    """Return a value of a task if it has the types that are declared, and finite numbers. Raises
    TypeError if not.
    """
    if not isinstance(value, kind):
        raise TypeError(f"{value!r:.60} is not a {kind.__name__}")
    fields = msgspec.structs.asdict(value)
    try:
        msgspec.convert(fields, kind)
    except msgspec.ValidationError as error:
        raise TypeError(f"the {kind.__name__} of an attempt cannot be stored: {error}") from error
    if not all(math.isfinite(number) for number in fields.values() if isinstance(number, float)):
        raise TypeError(
            f"the {kind.__name__} of an attempt cannot be stored: a number in it is not finite"
        )
    return value


def _score_seat(
    task: Task,
    attempt: AttemptFacts,
    seat: str,
    results: Sequence[Result],
    judged: JudgedAttempt,
    judgement: Judgement,
    history: History,
    measures: dict[str, float],
) -> tuple[SeatScore, History]:
    """Score an attempt for one seat. Returns the score and the seat's new history."""
    if not attempt.practice:
        history = feedback_choice.remember(history, judged, task.parameters)
    choice = feedback_choice.choose(
        history, judged, task.parameters, task.feedback_on, practice=attempt.practice
    )
    if judgement.reason in RACED:
        choice = replace(choice, degree="clear")
    message = _feedback(
        task,
        attempt,
        seat,
        results,
        judged.score,
        judgement,
        judged.target,
        choice,
        history,
        measures,
    )
    ended = AttemptEnded(
        seat=seat,
        attempt=attempt.attempt,
        practice=attempt.practice,
        level=attempt.level,
        metric=judged.score.metric,
        metric_unit=task.metric.unit,
        accuracy=judged.score.accuracy,
        correct=judged.score.correct,
        trials=judged.score.trials,
        goal=judged.target.threshold,
        outcome=judgement.outcome,
        feedback=message.valence if choice.due else "none",
        qualities=message.qualities,
        spreads=_spreads(task, judged.score, results),
        choice=message.choice,
        started=attempt.started,
        ended=attempt.ended,
        condition=attempt.condition,
    )
    if choice.due and not attempt.practice:
        history = feedback_choice.given(history)
    return SeatScore(ended, message), history


def _feedback(
    task: Task,
    attempt: AttemptFacts,
    seat: str,
    results: Sequence[Result],
    score: Score,
    judgement: Judgement,
    target: Target,
    choice: FeedbackChoice,
    history: History,
    measures: dict[str, float],
) -> Feedback:
    """Build the feedback on the attempt, or on the last few if the schedule summarises them."""
    reached = int(judgement.outcome == "success")
    if choice.attempts > 1:
        enough = task.parameters.min_accuracy
        judgement, mean, target, reached = judge_summary(history.recent, task.metric, enough)
        choice = replace(choice, degree=degree(mean.metric, target))
        score = replace(score, metric=mean.metric)
    return Feedback(
        seat=seat,
        attempt=attempt.attempt,
        level=attempt.level,
        valence=judgement.valence,
        reason=judgement.reason,
        metric=score.metric,
        goal=target.threshold,
        accuracy=score.accuracy,
        correct=score.correct,
        trials=score.trials,
        reached=reached,
        won=score.won,
        qualities=measures,
        remark=task.tr(next((result.remark for result in reversed(results) if result.remark), "")),
        due=attempt.ended + choice.delay_ms * MS if choice.due else 0,
        choice=choice,
        advice=task.when_to_respond() if _is_unanswered(judgement, results) else "",
        correction=task.tr(
            next((result.correction for result in reversed(results) if result.correction), "")
        ),
        condition=attempt.condition,
    )


def _is_unanswered(judgement: Judgement, results: Sequence[Result]) -> bool:
    """Return True if an attempt has no result because prompts stayed unanswered, rather than by
    wrong responses.
    """
    wrong = [result for result in results if not result.correct and "skipped" not in result.flags]
    unanswered = sum(not result.response for result in wrong)
    return (
        judgement.reason in ("accuracy", "empty")
        and unanswered > 0
        and 2 * unanswered >= len(wrong)
    )


def _mean_qualities(task: Task, results: Sequence[Result]) -> dict[str, float]:
    """Return the mean of each of the task's qualities over the correct trials that have it."""
    return {field: sum(values) / len(values) for field, values in _qualities(task, results).items()}


def _qualities(task: Task, results: Sequence[Result]) -> dict[str, list[float]]:
    """Return the values of each of the task's qualities in the correct trials; only those that were
    measured.
    """
    measured = {}
    sound = [result for result in _sure(results) if DOUBTFUL not in result.flags]
    for quality in task.qualities:
        found = [result.details.get(quality.field) for result in sound if result.correct]
        if values := [float(value) for value in found if isinstance(value, int | float)]:
            measured[quality.field] = values
    return measured


def _spreads(task: Task, score: Score, results: Sequence[Result]) -> dict[str, Spread]:
    """Return the spread of the trials behind the metric, if it is their mean, and behind each
    quality.
    """
    spreads = {name: _spread(values) for name, values in _qualities(task, results).items()}
    timed = [result for result in results if result.counts and result.value is not None]
    values = [result.value for result in timed if result.value is not None]
    if values and score.metric is not None and math.isclose(score.metric, statistics.fmean(values)):
        is_doubtful = any(DOUBTFUL in result.flags for result in timed)
        spreads[task.metric.name] = Spread(0, 0.0) if is_doubtful else _spread(values)
    return spreads


def _spread(values: Sequence[float]) -> Spread:
    return Spread(len(values), statistics.stdev(values) if len(values) > 1 else 0.0)
