"""Feedback after every n-th attempt, on the last n together."""

from sar_tui.rules.feedback.every import EverySettings
from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy, History, decide_every
from sar_tui.rules.judgement import JudgedAttempt


def decide(history: History, attempt: JudgedAttempt, settings: EverySettings) -> Decision:
    """Return the decision: due if enough attempts have passed to summarise them."""
    decision = decide_every(history.since, settings.feedback_every)
    return decision._replace(attempts=len(history.recent)) if decision.due else decision


POLICY = FeedbackPolicy(decide, EverySettings, recent=lambda settings: settings.feedback_every)
