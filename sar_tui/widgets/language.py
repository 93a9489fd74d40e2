"""The language of a widget's texts."""

from typing import Any

from textual.app import App

from sar_tui.model.language import Language


def language_of(app: App[Any]) -> Language:
    """Return the language of the topmost screen that has one (``tr``), else English."""
    spoken = (getattr(screen, "tr", None) for screen in reversed(app.screen_stack))
    return next((tr for tr in spoken if tr is not None), Language())
