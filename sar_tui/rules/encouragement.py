"""Encouragement before a hard attempt, and reminders of rest."""

from collections.abc import Sequence
from typing import Literal

from sar_tui.model.messages import AttemptEnded


def why_hard(attempts: Sequence[AttemptEnded], level: int) -> Literal["", "failures", "new level"]:
    """Return why the next attempt is hard: after two failures in a row, or at a new highest level;
    empty if it is not.

    Args:
        attempts: scored so far, oldest first.
        level: of the next attempt.
    """
    if [attempt.outcome for attempt in attempts[-2:]] == ["failure", "failure"]:
        return "failures"
    if attempts and level > max(attempt.level for attempt in attempts):
        return "new level"
    return ""


def rest_due(attempts: int, every: int) -> bool:
    """Return True if a reminder of rest is due after ``attempts`` attempts; with ``every`` 0,
    never.
    """
    return bool(every) and attempts > 0 and attempts % every == 0
