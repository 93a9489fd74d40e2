"""The language of a widget's texts: those of the app, in its two files for each language."""

from pathlib import Path
from typing import Any

from textual.app import App

from sar_tui.model.language import Language, language

_PARTICIPANTS = Path(__file__).parents[1] / "app"
_THERAPISTS = _PARTICIPANTS / "therapist"
_SETTINGS = Path(__file__).parents[1] / "rules"


def language_of(app: App[Any]) -> Language:
    """Return the language of the topmost screen that has one, else of the app (``tr``), else English."""
    spoken = (getattr(each, "tr", None) for each in (*reversed(app.screen_stack), app))
    return next((tr for tr in spoken if tr is not None), Language())


def app_texts(code: str) -> Language:
    """Return the texts of settings, and of the app's screens: for therapists and participants."""
    return language(code, _SETTINGS, _THERAPISTS, _PARTICIPANTS)
