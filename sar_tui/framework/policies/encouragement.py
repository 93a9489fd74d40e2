"""When a kind word helps before an attempt, and when a rest is due."""

from collections.abc import Sequence

from sar_tui.framework.messages import AttemptEnded


def is_hard(attempts: Sequence[AttemptEnded], level: int) -> bool:
    """Whether the next attempt is a hard one: at a level higher than any before, or after two failures in a row.

    Args:
        attempts: those scored so far, oldest first.
        level: of the next one.
    """
    if not attempts:
        return False
    failing = [attempt.outcome for attempt in attempts[-2:]] == ["failure", "failure"]
    return failing or level > max(attempt.level for attempt in attempts)


def rest_due(attempts: int, every: int) -> bool:
    """Whether to remind of rest after so many attempts; ``every`` 0 is never."""
    return bool(every) and attempts > 0 and attempts % every == 0
