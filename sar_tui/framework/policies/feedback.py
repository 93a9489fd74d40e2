"""Augmented feedback: what an attempt deserves to hear, and when it is due."""

from typing import Literal

import msgspec

from sar_tui.framework.messages import Outcome, Valence
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.task import Metric, Score, Target

Reason = Literal["goal", "missed", "band", "accuracy", "empty"]


_ROUNDING = 1e-9
"""So much of the goal a sum of fractions may be off: 0.8 lies within 0.1 of 0.7."""


class Judgement(msgspec.Struct, frozen=True):
    """An attempt against its goal. ``reason`` says why the valence is what it is (see `messages.Feedback`)."""

    outcome: Outcome
    valence: Valence
    reason: Reason


def judge(score: Score, metric: Metric, target: Target, min_accuracy: float) -> Judgement:
    """Judge an attempt (thesis 4.2.1, 4.4.2).

    Success: the metric is better than the threshold (equal is not) and the accuracy reaches its minimum.
    Valence: positive on success, negative on failure, neutral within the band (bounds included) of the
    threshold; below the minimum accuracy, or with nothing to average, always negative.
    """
    accurate = score.accuracy is None or score.accuracy >= min_accuracy
    if score.metric is None:
        return Judgement("failure", "negative", "empty" if accurate else "accuracy")
    if not accurate:
        return Judgement("failure", "negative", "accuracy")
    success = metric.is_better(score.metric, target.threshold)
    outcome: Outcome = "success" if success else "failure"
    if abs(score.metric - target.threshold) <= target.neutral_band + _ROUNDING * target.threshold:
        return Judgement(outcome, "neutral", "band")
    return Judgement(outcome, "positive", "goal") if success else Judgement(outcome, "negative", "missed")


def is_due(scored_attempts: int, parameters: TaskParameters) -> bool:
    """Whether the agent answers after so many scored attempts (practice is always answered)."""
    return scored_attempts % parameters.feedback_every == 0
