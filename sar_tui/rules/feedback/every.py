"""Feedback after every n-th attempt."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy, History, decide_every
from sar_tui.rules.judgement import JudgedAttempt


class EverySettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedules ``every`` and ``summary``."""

    feedback_every: Annotated[
        int,
        meta(
            "Feedback every",
            "attempts",
            "For every and summary: the number of attempts n.",
            ge=1,
            le=100,
            group="Feedback",
        ),
    ] = 1


def decide(history: History, attempt: JudgedAttempt, settings: EverySettings) -> Decision:
    """Return the decision: due if enough attempts have passed since the last feedback."""
    return decide_every(history.since, settings.feedback_every)


POLICY = FeedbackPolicy(decide, EverySettings)
