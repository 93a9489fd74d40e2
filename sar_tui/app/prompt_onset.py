"""Onset of a prompt: the flush of the frame that holds its text."""

import asyncio
import functools
from collections.abc import Callable
from typing import Any

from textual.screen import Screen

from sar_tui.app.live import LiveSession
from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import Prompt, Shown
from sar_tui.framework.visible_text import visible

_READ_AFTER = 0.03
"""Seconds until a prompt's time stamp is read: work before then would delay the drawing of the prompt."""
_UNSEEN = 2 * SECOND
"""A prompt whose flush was not seen by then counts as shown, with the less certain source ``refresh``."""


def report_onset(screen: Screen[Any], live: LiveSession, prompt: Prompt) -> None:
    """Report to the session when a prompt that is about to be drawn has reached the terminal.

    The writing thread takes the time stamp, and this thread does nothing until the terminal has read the frame. If
    flushes cannot be seen (tests, Windows), the onset is the refresh of the screen, and its source says so.
    """
    shown = functools.partial(Shown, attempt=prompt.attempt, trial=prompt.trial, presentation=prompt.presentation)
    app: Any = screen.app
    if getattr(app._driver, "can_stamp_onset", False):
        stamps: list[int] = []  # a new list, so that a voided prompt's stamp is not taken for the next one's
        app.onset_watch.arm(visible(prompt.text), functools.partial(_stamped, live, shown, stamps))
        unseen_at = live.clock.now() + _UNSEEN
        asyncio.get_running_loop().call_later(_READ_AFTER, _read_stamp, live, shown, stamps, unseen_at)
    else:
        screen.call_after_refresh(_refreshed, live, shown)


def _stamped(live: LiveSession, shown: Callable[..., Shown], stamps: list[int], at: int) -> None:
    """Keep the stamp of a flush, and have its marker sent. Called from the writing thread."""
    if live.markers:
        live.markers.shown(shown(at=at, source="flush"))
    stamps.append(at)


def _read_stamp(live: LiveSession, shown: Callable[..., Shown], stamps: list[int], unseen_at: int) -> None:
    now = live.clock.now()
    if stamps:
        live.screen.shown(shown(at=stamps[0], source="flush"))
    elif now < unseen_at:
        asyncio.get_running_loop().call_later(_READ_AFTER, _read_stamp, live, shown, stamps, unseen_at)
    else:
        live.screen.shown(shown(at=now, source="refresh"))


def _refreshed(live: LiveSession, shown: Callable[..., Shown]) -> None:
    live.screen.shown(shown(at=live.clock.now(), source="refresh"))
