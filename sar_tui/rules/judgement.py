"""Judges attempts: success or failure, and the valence and degree of the feedback."""

from typing import Literal

import msgspec

from sar_tui.model.messages import Degree, Outcome, Valence
from sar_tui.model.trial_types import Metric, Score, Target

Reason = Literal["goal", "missed", "band", "accuracy", "empty", "won", "lost", "drawn"]
RACED = ("won", "lost", "drawn")
"""Reasons given for the result of a race."""
SLIGHT, STRONG = 0.1, 0.25
"""Distances from the goal, as shares of it: below the first, the degree is slight; from the second
on, strong.
"""
ROUNDING = 1e-9
"""Rounding error allowed in comparisons, as a share of the goal: 0.8 lies within 0.1 of 0.7."""


class Judgement(msgspec.Struct, frozen=True):
    """The result of judging an attempt. ``reason`` explains the valence (see
    `messages.Feedback`).
    """

    outcome: Outcome
    valence: Valence
    reason: Reason


class JudgedAttempt(msgspec.Struct, frozen=True):
    """The score of an attempt, its target, and the judgement of the score by the target."""

    score: Score
    target: Target
    judgement: Judgement

    @property
    def outcome(self) -> Outcome:
        """Success or failure."""
        return self.judgement.outcome

    @property
    def has_no_result(self) -> bool:
        """True if too few responses were right, or none could be timed."""
        return self.judgement.reason in ("empty", "accuracy")


def judge(score: Score, metric: Metric, target: Target, min_accuracy: float) -> Judgement:
    """Judge an attempt (thesis 4.2.1, 4.4.2).

    Success: the metric is better than the threshold (equal is not) and the accuracy reaches its
    minimum. Valence: positive on success, negative on failure, neutral within the band (bounds
    included) of the threshold; below the minimum accuracy, or with nothing to average, always
    negative.
    """
    accurate = score.accuracy is None or score.accuracy >= min_accuracy
    if score.metric is None:
        return Judgement("failure", "negative", "empty" if accurate else "accuracy")
    if not accurate:
        return Judgement("failure", "negative", "accuracy")
    success = metric.is_better(score.metric, target.threshold)
    outcome: Outcome = "success" if success else "failure"
    if abs(score.metric - target.threshold) <= target.neutral_band + ROUNDING * abs(
        target.threshold
    ):
        return Judgement(outcome, "neutral", "band")
    return (
        Judgement(outcome, "positive", "goal")
        if success
        else Judgement(outcome, "negative", "missed")
    )


def judge_race(scores: dict[str, Score], judgements: dict[str, Judgement]) -> dict[str, Judgement]:
    """Return the judgements of a race: by the number of trials won, whatever the goal.

    The winner is praised, the loser consoled, and a draw is neutral; the outcomes are those of
    ``judgements``. Without a race, or if nobody won a trial, ``judgements`` are returned.
    """
    won = {seat: score.won for seat, score in scores.items() if score.won is not None}
    most = max(won.values(), default=0)
    if len(won) < 2 or not most:
        return judgements
    is_drawn = min(won.values()) == most
    by_seat: dict[str, tuple[Valence, Reason]] = {
        seat: ("neutral", "drawn")
        if is_drawn
        else ("positive", "won")
        if count == most
        else ("negative", "lost")
        for seat, count in won.items()
    }
    return {seat: Judgement(judgements[seat].outcome, *what) for seat, what in by_seat.items()}


def degree(metric: float | None, target: Target) -> Degree:
    """Return the distance of a result from its goal, relative to the goal, in three degrees."""
    if metric is None or not target.threshold:
        return "clear"
    share = abs(metric - target.threshold) / abs(target.threshold)
    return "slight" if share < SLIGHT else "clear" if share < STRONG else "strong"


def summary(recent: tuple[JudgedAttempt, ...]) -> tuple[Score, Target, int]:
    """Return the means of some attempts (results, accuracies, goals), and how many reached their
    goals.
    """
    measured = [judged for judged in recent if judged.score.metric is not None]
    accuracies = [judged.score.accuracy for judged in recent if judged.score.accuracy is not None]
    accuracy = sum(accuracies) / len(accuracies) if accuracies else None
    reached = sum(judged.outcome == "success" for judged in recent)
    if not measured:
        return (Score(None, accuracy, 0, 0), recent[-1].target, reached)
    mean = sum(judged.score.metric or 0.0 for judged in measured) / len(measured)
    goal = sum(judged.target.threshold for judged in measured) / len(measured)
    band = sum(judged.target.neutral_band for judged in measured) / len(measured)
    return (Score(mean, accuracy, 0, 0), Target(goal, band), reached)


def judge_summary(
    recent: tuple[JudgedAttempt, ...], metric: Metric, min_accuracy: float
) -> tuple[Judgement, Score, Target, int]:
    """Judge some attempts together, by their means.

    The judgement is neutral instead of positive if fewer than half reached their goals, and instead
    of negative if more than half did: a single outlier can move the mean.

    Returns the judgement, the mean score, the mean goal, and how many reached their goals.
    """
    score, target, reached = summary(recent)
    judged = judge(score, metric, target, min_accuracy)
    against = {
        "positive": 2 * reached < len(recent),
        "negative": 2 * reached > len(recent),
        "neutral": False,
    }
    if against[judged.valence]:
        judged = msgspec.structs.replace(judged, valence="neutral")
    return judged, score, target, reached
