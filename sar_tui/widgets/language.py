"""The language of a widget's texts."""

from typing import Any

from textual.app import App

from sar_tui.model.language import Language


def language_of(app: App[Any]) -> Language:
    """Return the language of the topmost screen that has one, else of the app (``tr``), else English."""
    spoken = (getattr(each, "tr", None) for each in (*reversed(app.screen_stack), app))
    return next((tr for tr in spoken if tr is not None), Language())
