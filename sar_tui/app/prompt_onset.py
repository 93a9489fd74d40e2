"""A prompt's onset: the flush of the frame that holds its text."""

import asyncio
import functools
from collections.abc import Callable
from typing import Any

from textual.screen import Screen

from sar_tui.app.live import LiveSession
from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import Prompt, Shown

_LOOK_AFTER = 0.03
"""Seconds until the stamp of a prompt is looked at: work before then would delay the prompt's way to the eye."""
_UNSEEN = 2 * SECOND
"""A prompt whose flush has not been seen by then is taken to be up, and marked as less sure."""


def report_onset(screen: Screen[Any], live: LiveSession, prompt: Prompt) -> None:
    """Tell a session when a prompt that is about to be drawn has reached the terminal.

    The writing thread keeps the stamp, and this one stays out of its way until the terminal has read the frame. Where
    no flush can be seen (a test, Windows) the onset is that the frame is painted, and is called so.
    """
    tell = functools.partial(Shown, attempt=prompt.attempt, trial=prompt.trial, presentation=prompt.presentation)
    app: Any = screen.app
    if getattr(app._driver, "can_stamp_onset", False):
        stamps: list[int] = []  # one list a prompt, so that a voided one's stamp is not taken for the next one's
        app.onset_watch.arm(prompt.text, stamps.append)
        unseen_at = live.clock.now() + _UNSEEN
        asyncio.get_running_loop().call_later(_LOOK_AFTER, _look_at_stamp, live, tell, stamps, unseen_at)
    else:
        screen.call_after_refresh(_refreshed, live, tell)


def _look_at_stamp(live: LiveSession, tell: Callable[..., Shown], stamps: list[int], unseen_at: int) -> None:
    now = live.clock.now()
    if stamps:
        live.screen.shown(tell(at=stamps[0], source="flush"))
    elif now < unseen_at:
        asyncio.get_running_loop().call_later(_LOOK_AFTER, _look_at_stamp, live, tell, stamps, unseen_at)
    else:
        live.screen.shown(tell(at=now, source="refresh"))


def _refreshed(live: LiveSession, tell: Callable[..., Shown]) -> None:
    live.screen.shown(tell(at=live.clock.now(), source="refresh"))
