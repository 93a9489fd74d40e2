"""Encouragement before a hard attempt, and reminders of rest."""

from collections.abc import Sequence

from sar_tui.framework.messages import AttemptEnded


def is_hard(attempts: Sequence[AttemptEnded], level: int) -> bool:
    """Return True if the next attempt is hard: at a new highest level, or after two failures in a row.

    Args:
        attempts: scored so far, oldest first.
        level: of the next attempt.
    """
    if not attempts:
        return False
    failing = [attempt.outcome for attempt in attempts[-2:]] == ["failure", "failure"]
    return failing or level > max(attempt.level for attempt in attempts)


def rest_due(attempts: int, every: int) -> bool:
    """Return True if a reminder of rest is due after ``attempts`` attempts; with ``every`` 0, never."""
    return bool(every) and attempts > 0 and attempts % every == 0
