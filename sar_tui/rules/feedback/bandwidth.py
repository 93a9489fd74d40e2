"""Feedback only on results outside a tolerance band around the goal."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy, History
from sar_tui.rules.judgement import ROUNDING, JudgedAttempt


class BandwidthSettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedule ``bandwidth``."""

    feedback_tolerance: Annotated[
        float,
        meta(
            "Bandwidth",
            "% of the goal",
            "For bandwidth: no feedback on results within this distance of the goal.",
            ge=0,
            le=100,
            group="Feedback",
        ),
    ] = 10.0


def decide(history: History, attempt: JudgedAttempt, settings: BandwidthSettings) -> Decision:
    """Return the decision: due if the result is farther from the goal than the tolerance, or if
    there is none.
    """
    goal, metric = attempt.target.threshold, attempt.score.metric
    tolerance = abs(goal) * settings.feedback_tolerance / 100
    if attempt.has_no_result or metric is None:
        return Decision(
            True, "Too few responses were right, or none could be timed.", tolerance=tolerance
        )
    off = abs(metric - goal)
    due = off > tolerance + ROUNDING * abs(goal)
    why = (
        f"{off:.4g} off the goal, {'more than' if due else 'within'} the tolerance of "
        f"{tolerance:.4g}."
    )
    return Decision(due, why, tolerance=tolerance)


POLICY = FeedbackPolicy(decide, BandwidthSettings)
