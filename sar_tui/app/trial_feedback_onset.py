"""Onset of the answer to a trial: the flush of the frame that holds its text."""

from typing import Any, Literal

from textual.screen import Screen

from sar_tui.app.live import LiveSession
from sar_tui.model.messages import TrialFeedback, TrialFeedbackShown
from sar_tui.model.visible_text import visible


def report_trial_feedback(screen: Screen[Any], live: LiveSession, feedback: TrialFeedback) -> None:
    """Report to the session when an answer that is about to be drawn has reached the terminal.

    If flushes cannot be seen (tests, Windows), that is the refresh of the screen, and its source
    says so.
    """

    def report(at: int, source: Literal["flush", "refresh"]) -> None:
        shown = TrialFeedbackShown(
            seat=feedback.seat, attempt=feedback.attempt, trial=feedback.trial, at=at, source=source
        )
        live.screen.trial_feedback_shown(shown)

    app: Any = screen.app
    if getattr(app._driver, "can_stamp_onset", False):
        # in the writing thread
        app.onset_watch.arm(visible(feedback.text), lambda at: report(at, "flush"))
    else:
        screen.call_after_refresh(lambda: report(live.clock.now(), "refresh"))
