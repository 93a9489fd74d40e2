"""Difficulty: when the next attempt is harder or easier."""

import msgspec

from sar_tui.framework.messages import Outcome
from sar_tui.framework.parameters import TaskParameters


class Difficulty(msgspec.Struct, frozen=True):
    """The level now, and how many successes or failures in a row led here without changing it."""

    level: int
    successes: int = 0
    failures: int = 0


def start(parameters: TaskParameters, levels: int) -> Difficulty:
    """Where a session begins: the start level, or the task's last where it has fewer."""
    return Difficulty(level=min(parameters.start_level, levels))


def step(state: Difficulty, outcome: Outcome, parameters: TaskParameters, levels: int) -> Difficulty:
    """The difficulty after one more attempt.

    ``thesis`` (thesis 4.2.1): N consecutive successes raise the level by one, M consecutive failures lower it
    by one, within the bounds; a change, or an outcome of the other kind, begins the count anew. ``fixed``: the
    level stays.

    Args:
        state: before the attempt.
        outcome: of the attempt.
        parameters: the Task Base.
        levels: how many levels the task has.
    """
    if parameters.difficulty_policy == "fixed":
        return state
    if outcome == "success":
        if state.successes + 1 < parameters.consecutive_successes:
            return Difficulty(state.level, successes=state.successes + 1)
        return Difficulty(min(state.level + 1, parameters.max_level, levels))
    if state.failures + 1 < parameters.consecutive_failures:
        return Difficulty(state.level, failures=state.failures + 1)
    return Difficulty(max(state.level - 1, min(parameters.min_level, levels)))
