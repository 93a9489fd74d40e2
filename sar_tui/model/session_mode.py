"""Modes of sessions: who played them."""

from typing import Literal

SessionMode = Literal["live", "simulated", "replayed", "demonstration"]
"""``live``: a person. ``simulated``: a simulated one. ``replayed``: nobody, from a record.
``demonstration``: an invented person, simulated, in a data folder that shows what the program does.
"""
PERSONAL: tuple[SessionMode, ...] = ("live", "demonstration")
"""Modes of sessions that belong to somebody's course, and have dose, progress and pain."""


def is_personal(mode: str) -> bool:
    """Return True for a mode of sessions that belong to somebody's course."""
    return mode in PERSONAL
