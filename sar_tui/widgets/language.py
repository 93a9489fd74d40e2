"""Where a widget finds the language that it has to speak."""

from typing import Any

from textual.app import App

from sar_tui.framework.language import Language


def language_of(app: App[Any]) -> Language:
    """The language of what an app shows: that of the topmost screen that has one (``tr``), else English."""
    spoken = (getattr(screen, "tr", None) for screen in reversed(app.screen_stack))
    return next((tr for tr in spoken if tr is not None), Language())
