"""An attempt compared with earlier ones, for the feedback on it: which, and what of the change is
real. Pure.
"""

import math
from typing import Literal, NamedTuple

from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Feedback, RecalledAttempts, Spread
from sar_tui.model.results_for_people import metric_for_people
from sar_tui.model.trial_types import Metric, Quality
from sar_tui.rules.decline import Decline, decline
from sar_tui.rules.real_change import Change, Sample, judge

ALIKE = 0.2
"""Largest relative difference of results whose performance is compared."""
_ONE = Spread(1, 0.0)
"""Spread of a result that is not the mean of its trials: the attempt counts as one."""


class QualityChange(NamedTuple):
    """The change of a quality since an earlier attempt.

    ``size``: the improvement as a multiple of its MDC95; negative if it is worse. ``is_real``: it
    is more than the person's noise.
    """

    quality: Quality
    size: float
    is_real: bool
    judged: Change


class QualityDecline(NamedTuple):
    """A quality, and how much worse it got."""

    quality: Quality
    decline: Decline


def attempts_before(feedback: Feedback, recalled: RecalledAttempts) -> list[AttemptEnded]:
    """Return the earlier attempts at the level, oldest first."""
    return [attempt for attempt in recalled.attempts if attempt.attempt < feedback.attempt]


def comparable_attempts(feedback: Feedback, recalled: RecalledAttempts) -> list[AttemptEnded]:
    """Return the earlier attempts with nearly the same result: the qualities depend on speed."""
    tolerance = math.inf if feedback.metric is None else ALIKE * abs(feedback.metric)
    return [
        attempt
        for attempt in attempts_before(feedback, recalled)
        if attempt.metric is not None
        and abs(attempt.metric - (feedback.metric or 0.0)) <= tolerance
    ]


def judge_result(
    task: Task, feedback: Feedback, recalled: RecalledAttempts, before: float
) -> Change | None:
    """Judge the change of the result from a reference; None if the earlier attempts are too few.

    Args:
        task: has the metric.
        feedback: on the attempt.
        recalled: attempts at its level.
        before: the reference: the result of one earlier attempt, or the mean of all.
    """
    name, present = task.metric.name, _present(feedback, recalled)
    found = [
        _sample(attempt, name, attempt.metric)
        for attempt in attempts_before(feedback, recalled)
        if attempt.metric is not None
    ]
    earlier = [each for each in found if each.n]
    if present is None or feedback.metric is None or not earlier:
        return None
    now = _sample(present, name, feedback.metric)
    if not now.n or any(each.mean == before and not each.n for each in found):
        return None  # one of the two is doubtful
    is_mean = feedback.choice.compared_with == "session's mean"
    trials = sum(each.n for each in earlier) if is_mean else earlier[-1].n
    reference = Sample(before, trials, attempts=len(earlier) if is_mean else 1)
    return judge(now, reference, earlier, task.metric.better)


def measured_qualities(task: Task, feedback: Feedback) -> list[Quality]:
    """Return the qualities that feedback on an attempt can be about."""
    return [each for each in task.qualities if each.field in feedback.qualities and each.praised]


def quality_changes(
    task: Task, feedback: Feedback, recalled: RecalledAttempts, before: AttemptEnded
) -> list[QualityChange]:
    """Return the changes of the qualities that were measured in two attempts; none if they cannot
    be told from noise.

    Args:
        task: has the qualities.
        feedback: on the later attempt.
        recalled: attempts at its level.
        before: the earlier one.
    """
    both = [each for each in measured_qualities(task, feedback) if each.field in before.qualities]
    judged = [(each, _judge_quality(each, feedback, recalled, before, len(both))) for each in both]
    return [
        QualityChange(each, _size(change, each.better), change.verdict != "chance", change)
        for each, change in judged
        if change
    ]


def worst_decline(
    task: Task, feedback: Feedback, recalled: RecalledAttempts
) -> QualityDecline | None:
    """Return the quality that got worse by most, beyond this person's own noise; None if none did.

    Attempts of which a quality is doubtful do not count for it.
    """
    present = _present(feedback, recalled)
    if present is None:
        return None
    comparable = (*comparable_attempts(feedback, recalled), present)
    measured = measured_qualities(task, feedback)
    declines = []
    for quality in measured:
        sure = [attempt for attempt in comparable if _is_sure(attempt, quality.field)]
        if present in sure:
            values = [attempt.qualities[quality.field] for attempt in sure]
            found = decline(values, quality.better, least=quality.margin, measures=len(measured))
            declines += [QualityDecline(quality, found)] if found else []
    return max(declines, key=lambda each: each.decline.size, default=None)


def _is_sure(attempt: AttemptEnded, quality: str) -> bool:
    return quality in attempt.qualities and attempt.spreads.get(quality, _ONE).n > 0


def _size(change: Change, better: Literal["lower", "higher"]) -> float:
    """Return an improvement as a multiple of its MDC95; negative if it is worse."""
    improvement = -change.by if better == "lower" else change.by
    if not change.mdc95:
        return math.copysign(math.inf, improvement) if improvement else 0.0
    return improvement / change.mdc95


def _judge_quality(
    quality: Quality,
    feedback: Feedback,
    recalled: RecalledAttempts,
    before: AttemptEnded,
    measures: int,
) -> Change | None:
    name, present = quality.field, _present(feedback, recalled)
    if present is None:
        return None
    earlier = [
        _sample(attempt, name, attempt.qualities[name])
        for attempt in comparable_attempts(feedback, recalled)
        if name in attempt.qualities
    ]
    return judge(
        _sample(present, name, feedback.qualities[name]),
        _sample(before, name, before.qualities[name]),
        earlier,
        quality.better,
        least=quality.margin,
        measures=measures,
    )


def _present(feedback: Feedback, recalled: RecalledAttempts) -> AttemptEnded | None:
    """Return the attempt that the feedback is on; None for practice, which is not recalled."""
    return next(
        (attempt for attempt in recalled.attempts if attempt.attempt == feedback.attempt), None
    )


def _sample(attempt: AttemptEnded, name: str, mean: float) -> Sample:
    spread = attempt.spreads.get(name, _ONE)
    return Sample(mean, spread.n, spread.sd)


def result_evidence(metric: Metric, change: Change) -> str:
    """Return a change of the result beside its MDC95, for the therapist: "reach time -0.421 s
    (MDC95 0.380 s)".

    A time has one decimal more than a result, so that the two don't look equal.
    """
    shown, factor = metric_for_people(metric)
    decimals = shown.decimals + (factor != 1)
    by, mdc95 = f"{change.by * factor:+.{decimals}f}", f"{change.mdc95 * factor:.{decimals}f}"
    unit = f" {shown.unit}" if shown.unit else ""
    return f"{metric.name.replace('_', ' ')} {by}{unit} (MDC95 {mdc95}{unit})"


def quality_evidence(quality: Quality, change: Change | Decline) -> str:
    """Return a change of a quality beside its MDC95, for the therapist: "sparc +0.31 (MDC95
    0.22)".
    """
    return f"{quality.field.replace('_', ' ')} {change.by:+.2g} (MDC95 {change.mdc95:.2g})"
