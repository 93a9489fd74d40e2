"""Feedback that becomes rarer as successes outnumber failures."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy, History, decide_every
from sar_tui.rules.judgement import JudgedAttempt

RAREST = 10
"""The longest interval, in attempts."""


class FadedSettings(Settings, frozen=True, kw_only=True):
    """Settings of the schedule ``faded``."""

    feedback_fade: Annotated[
        int,
        meta(
            "Fading",
            "successes",
            "For faded: each time successes outnumber failures by this many more, feedback is "
            "rarer by one attempt.",
            ge=1,
            le=50,
            group="Feedback",
        ),
    ] = 2


def decide(history: History, attempt: JudgedAttempt, settings: FadedSettings) -> Decision:
    """Return the decision: due if enough attempts have passed for the skill shown so far.

    A success lengthens the interval only after the next feedback; a failure shortens it at once.
    """
    ahead = min(history.paced_by, history.skill)
    note = (
        f"Successes outnumber failures by {history.skill}, at the last feedback by "
        f"{history.paced_by}."
    )
    return decide_every(history.since, min(RAREST, 1 + ahead // settings.feedback_fade), note)


POLICY = FeedbackPolicy(decide, FadedSettings)
