"""Augmented feedback: what an attempt deserves to hear, and when it is due."""

from typing import Literal

import msgspec

from sar_tui.framework.messages import Degree, FeedbackChoice, Outcome, Valence
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.trial_types import Metric, Score, Target

Reason = Literal["goal", "missed", "band", "accuracy", "empty", "won", "lost", "drawn"]
RACED = ("won", "lost", "drawn")
"""The reasons that a race gives."""
Content = Literal["results", "performance", "both"]

RAREST = 10
"""Faded feedback never becomes rarer than every so many attempts."""
SLIGHT, STRONG = 0.1, 0.25
"""A result that is off the goal by less than the first share of it lies slightly off; by the second, strongly."""
_ROUNDING = 1e-9
"""So much of the goal a sum of fractions may be off: 0.8 lies within 0.1 of 0.7."""


class Judgement(msgspec.Struct, frozen=True):
    """An attempt against its goal. ``reason`` says why the valence is what it is (see `messages.Feedback`)."""

    outcome: Outcome
    valence: Valence
    reason: Reason


class Judged(msgspec.Struct, frozen=True):
    """An attempt with what it was held against and what came of it."""

    score: Score
    target: Target
    outcome: Outcome


class History(msgspec.Struct, frozen=True):
    """What the schedules keep of the scored attempts.

    ``since``: how many there were since the last answer. ``skill``: by how many the successes outnumber the failures,
    never below 0; ``paced_by``: what it was at the last answer. ``recent``: the last attempts, oldest
    first, as many as a summary takes.
    """

    since: int = 0
    skill: int = 0
    paced_by: int = 0
    recent: tuple[Judged, ...] = ()


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
    if abs(score.metric - target.threshold) <= target.neutral_band + _ROUNDING * abs(target.threshold):
        return Judgement(outcome, "neutral", "band")
    return Judgement(outcome, "positive", "goal") if success else Judgement(outcome, "negative", "missed")


def judge_race(scores: dict[str, Score], verdicts: dict[str, Judgement]) -> dict[str, Judgement]:
    """What to tell those who raced: how often each was the first, whatever they reached.

    Who was more often is praised, who was less often consoled; a draw is neutral. Whether the goal was reached, as
    ``verdicts`` has it, stands; it is also what is told without a race, or where nobody won anything.
    """
    won = {seat: score.won for seat, score in scores.items() if score.won is not None}
    most = max(won.values(), default=0)
    if len(won) < 2 or not most:
        return verdicts
    is_drawn = min(won.values()) == most
    told: dict[str, tuple[Valence, Reason]] = {
        seat: ("neutral", "drawn") if is_drawn else ("positive", "won") if count == most else ("negative", "lost")
        for seat, count in won.items()
    }
    return {seat: Judgement(verdicts[seat].outcome, *what) for seat, what in told.items()}


def degree(metric: float | None, target: Target) -> Degree:
    """How far a result lies from its goal, as a share of that: how warm praise or consolation is."""
    if metric is None or not target.threshold:
        return "clear"
    share = abs(metric - target.threshold) / abs(target.threshold)
    return "slight" if share < SLIGHT else "clear" if share < STRONG else "strong"


def remember(history: History, judged: Judged, parameters: TaskParameters) -> History:
    """The history with one more scored attempt."""
    kept = parameters.feedback_every if parameters.feedback_schedule == "summary" else 1
    return History(
        since=history.since + 1,
        skill=max(0, history.skill + (1 if judged.outcome == "success" else -1)),
        paced_by=history.paced_by,
        recent=(*history.recent, judged)[-kept:],
    )


def choose(
    history: History, judged: Judged, parameters: TaskParameters, content: Content, *, practice: bool = False
) -> FeedbackChoice:
    """Whether an attempt is answered, and why.

    Schedules (after Schmidt & Lee, Motor Control and Learning, on augmented feedback): ``every`` n attempts; ``faded``,
    rarer as successes outnumber failures; ``bandwidth``, only outside a tolerance about the goal; ``summary`` of the
    last n; on ``request`` of the participant; ``none``. Practice is answered each time, but for the last two.

    Args:
        history: of the scored attempts, this one included (see ``remember``); an attempt of practice is not.
        judged: the attempt.
        parameters: the Task Base.
        content: what the task answers.
        practice: whether the attempt is for practice.
    """
    schedule = parameters.feedback_schedule
    interval = _interval(history, parameters)
    tolerance = None
    match schedule:
        case "none":
            due, why = False, "No feedback is given."
        case "request":
            due, why = False, "Feedback is given when the participant asks for it."
        case _ if practice:
            due, why = True, "Practice is answered each time."
        case "bandwidth":
            tolerance = abs(judged.target.threshold) * parameters.feedback_tolerance / 100
            due, why = _outside(judged, tolerance, parameters)
        case _:
            assert interval is not None
            due = history.since >= interval
            why = f"Due every {interval} attempts" if interval > 1 else "Due after every attempt"
            why += f"; {history.since} since the last." if interval > 1 else "."
            if schedule == "faded":
                why += f" Successes outnumber failures by {history.skill}, at the last answer by {history.paced_by}."
    return FeedbackChoice(
        schedule=schedule,
        due=due,
        why=why,
        content=content,
        form=parameters.feedback_form,
        compared_with=parameters.feedback_compared_with,
        degree="clear" if _has_failed(judged.score, parameters) else degree(judged.score.metric, judged.target),
        delay_ms=0 if schedule == "request" else parameters.feedback_delay_ms,
        since=history.since,
        interval=interval,
        tolerance=tolerance,
        attempts=len(history.recent) if schedule == "summary" and due and not practice else 1,
    )


def answered(history: History) -> History:
    """The history once an answer has been given."""
    return msgspec.structs.replace(history, since=0, paced_by=history.skill)


def summary(recent: tuple[Judged, ...]) -> tuple[Score, Target, int]:
    """Some attempts as one: the means of their results, accuracies and goals, and how many reached theirs."""
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
    recent: tuple[Judged, ...], metric: Metric, min_accuracy: float
) -> tuple[Judgement, Score, Target, int]:
    """Judge some attempts as one, as ``judge`` does; but no praise where fewer than half reached their goal, and no
    consolation where more than half did, whatever the mean: one very fast or slow attempt is not the rest.

    Returns the judgement, the mean score, the mean goal, and how many reached theirs.
    """
    score, target, reached = summary(recent)
    judged = judge(score, metric, target, min_accuracy)
    against = {"positive": 2 * reached < len(recent), "negative": 2 * reached > len(recent), "neutral": False}
    if against[judged.valence]:
        judged = msgspec.structs.replace(judged, valence="neutral")
    return judged, score, target, reached


def _interval(history: History, parameters: TaskParameters) -> int | None:
    match parameters.feedback_schedule:
        case "every" | "summary":
            return parameters.feedback_every
        case "faded":
            ahead = min(history.paced_by, history.skill)  # success counts from the next answer on, failure at once
            return min(RAREST, 1 + ahead // parameters.feedback_fade)
    return None


def _has_failed(score: Score, parameters: TaskParameters) -> bool:
    """Whether there is no result to speak of: too few responses were right, or none could be timed."""
    return score.metric is None or (score.accuracy is not None and score.accuracy < parameters.min_accuracy)


def _outside(judged: Judged, tolerance: float, parameters: TaskParameters) -> tuple[bool, str]:
    score, goal = judged.score, judged.target.threshold
    if score.metric is None or _has_failed(score, parameters):
        return True, "Too few responses were right, or none could be timed."
    off = abs(score.metric - goal)
    due = off > tolerance + _ROUNDING * abs(goal)
    return due, f"{off:.4g} off the goal, {'more than' if due else 'within'} the tolerance of {tolerance:.4g}."
