"""Onset of a prompt, of each of its frames, and of the answer to a trial: the flush of its text."""

import asyncio
from typing import Any, Literal

from textual.screen import Screen

from sar_tui.app.live import LiveSession
from sar_tui.model.messages import Prompt, Shown, TrialFeedback, TrialFeedbackShown
from sar_tui.model.units import SECOND
from sar_tui.model.visible_text import visible
from sar_tui.widgets.prompt_pictures import Way

_READ_AFTER = 0.03
"""Seconds until a prompt's time stamp is read: work before then would delay the drawing of the
prompt.
"""
_UNSEEN = 2 * SECOND
"""A prompt whose flush was not seen by then counts as shown, with the less certain source
``refresh``.
"""


def report_onset(
    screen: Screen[Any], live: LiveSession, prompt: Prompt, frame: int = 0, due: int = 0
) -> "Onset":
    """Report to the session when a prompt, or a frame of it, that is about to be drawn has reached
    the terminal.

    The writing thread takes the time stamp, and this thread does nothing until the terminal has
    read what was flushed; of a prompt with frames the stamp is reported at once, as the next frame
    may be due soon. If flushes cannot be seen (tests, Windows), the onset is the refresh of the
    screen, and its source says so. A later frame is flushed when it is ``due`` (ns), not before.

    Returns the onset, which the caller tells how the picture is drawn.
    """
    onset = Onset(live, prompt, frame)
    app: Any = screen.app
    if getattr(app._driver, "can_stamp_onset", False):
        app.onset_watch.arm(visible(prompt.shown(frame).text), onset.flushed, due)
        asyncio.get_running_loop().call_later(_READ_AFTER, onset.read)
    else:
        screen.call_after_refresh(onset.refreshed)
    return onset


class Onset:
    """An onset that is awaited. Each has its own stamp, so that a voided prompt's is not taken for
    the next one's.

    Attributes:
        picture: how the picture is drawn, which is in the same flush.
    """

    def __init__(self, live: LiveSession, prompt: Prompt, frame: int) -> None:
        self._live = live
        self._prompt, self._frame = prompt, frame
        self.picture: Way | Literal["", "none"] = ""
        self._at: int | None = None
        self._unseen_at = live.clock.now() + _UNSEEN

    def flushed(self, at: int) -> None:
        """Keep the stamp, and have its marker sent. Called from the writing thread."""
        if self._live.markers:
            self._live.markers.shown(self._shown(at, "flush"))
        self._at = at
        if self._prompt.frames:
            self._live.screen.shown(self._shown(at, "flush"))

    def read(self) -> None:
        """Report the stamp, unless it was reported at once; look again as long as there is none."""
        if self._at is None and self._live.clock.now() >= self._unseen_at:
            self.refreshed()
        elif self._at is None:
            asyncio.get_running_loop().call_later(_READ_AFTER, self.read)
        elif not self._prompt.frames:
            self._live.screen.shown(self._shown(self._at, "flush"))

    def refreshed(self) -> None:
        """Report the present time."""
        self._live.screen.shown(self._shown(self._live.clock.now(), "refresh"))

    def _shown(self, at: int, source: Literal["flush", "refresh"]) -> Shown:
        prompt = self._prompt
        return Shown(
            attempt=prompt.attempt,
            trial=prompt.trial,
            presentation=prompt.presentation,
            at=at,
            source=source,
            frame=self._frame,
            picture=self.picture,
        )


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
