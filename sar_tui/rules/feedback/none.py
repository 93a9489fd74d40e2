"""No feedback."""

from sar_tui.rules.declaration import Settings
from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy, History
from sar_tui.rules.judgement import JudgedAttempt


def decide(history: History, attempt: JudgedAttempt, settings: Settings) -> Decision:
    """Return the decision: never due."""
    return Decision(False, "No feedback is given.")


POLICY = FeedbackPolicy(decide, feedback_on_practice=False)
