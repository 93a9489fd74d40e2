"""Feedback when the participant asks for it."""

from sar_tui.framework.declaration import Settings
from sar_tui.framework.policies.feedback.policy import Decision, FeedbackPolicy, History
from sar_tui.framework.policies.judgement import JudgedAttempt


def decide(history: History, attempt: JudgedAttempt, settings: Settings) -> Decision:
    """Return the decision: never due."""
    return Decision(False, "Feedback is given when the participant asks for it.")


POLICY = FeedbackPolicy(decide, feedback_on_practice=False)
