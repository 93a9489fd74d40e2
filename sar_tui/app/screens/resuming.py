"""Shown while a session is brought back to where it stopped."""

import time
from collections.abc import Callable

from textual.app import ComposeResult
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.tui.paint_now import paint_now
from sar_tui.widgets.language import language_of

_SHOWN_AFTER_S = 1.0
"""A replay that takes longer shows its progress."""
_PAINTED_EVERY_S = 0.1


class ResumingScreen(ModalScreen[None]):
    """Shows nothing at first, and the progress of a replay that takes longer than a moment.

    Args:
        now: returns the time in seconds.
    """

    DEFAULT_CSS = """
    ResumingScreen { align: center middle; background: transparent; }
    ResumingScreen #progress { width: auto; height: 1; min-width: 60; text-align: center; }
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._now = now
        self._next_paint = now() + _SHOWN_AFTER_S

    def compose(self) -> ComposeResult:
        yield Static("", id="progress", markup=False)

    def show(self, done: int, of: int) -> None:
        """Show the progress at once, because nothing else is drawn during the replay."""
        if self._now() < self._next_paint:
            return
        self._next_paint = self._now() + _PAINTED_EVERY_S
        tr = language_of(self.app)
        line = self.query_one("#progress", Static)
        line.update(
            tr(
                "The session goes on where it stopped: {share} %",
                share=str(100 * done // max(1, of)),
            ),
            layout=False,
        )
        paint_now(line, in_place=True)
