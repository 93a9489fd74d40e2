"""Finds neighbouring levels that are far apart: a person surely succeeds at one, and surely fails
at the next.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import fmean, pvariance

from sar_tui.loop.task import Task
from sar_tui.rules.parameters import TaskParameters, build, changed, fields
from sar_tui.store import sessions

MOST_REPEATS, FEWEST_REPEATS = 8, 3
"""Attempts at each level; a task with so many levels that there are fewer is not examined."""
MOST_ATTEMPTS = 160
FARTHEST = 1.0
"""Largest distance of neighbouring levels, in standard deviations of an attempt's result."""


def warning(
    kind: type[Task],
    parameters: TaskParameters,
    run: Callable[[TaskParameters], Sequence[sessions.Row]],
) -> str:
    """Return which levels are farther apart than one standard deviation of an attempt's result;
    empty for none.

    Args:
        kind: the task.
        parameters: with which it is checked.
        run: returns the attempts of a session with some parameters.
    """
    levels = range(parameters.min_level, min(kind(parameters).levels, parameters.max_level) + 1)
    most = next(field.le for field in fields(type(parameters)) if field.name == "attempts")
    repeats = min(
        MOST_REPEATS, int(min(MOST_ATTEMPTS, most or MOST_ATTEMPTS)) // max(1, len(levels))
    )
    if len(levels) < 2 or repeats < FEWEST_REPEATS:
        return ""
    listed = [level for level in levels for _ in range(repeats)]
    settings: dict[str, object] = {
        **changed(parameters),
        "difficulty_policy": "sequence",
        "level_sequence": listed,
        "attempts": len(listed),
        "practice_attempts": 0,
    }
    return far_apart(run(build(type(parameters), settings)), kind.metric.better == "lower")


def far_apart(attempts: Sequence[sessions.Row], lower_is_better: bool) -> str:
    """Return a sentence on the neighbouring levels that are surely too far apart; empty for none.

    What counts is the distance from the goal, which may differ by level. Few attempts leave the
    difference of two levels uncertain by its standard error: a distance counts from two of them
    beyond the largest.
    """
    sign = 1 if lower_is_better else -1
    found: dict[int, list[float]] = {}
    for row in attempts:
        if row["metric"] is not None and row["goal"] is not None:
            found.setdefault(row["level"], []).append(sign * (row["metric"] - row["goal"]))
    results = {
        level: values for level, values in sorted(found.items()) if len(values) >= FEWEST_REPEATS
    }
    if not results:
        return ""
    # a population variance of few values is too small by (n - 1) / n
    sd = (
        fmean(pvariance(values) * len(values) / (len(values) - 1) for values in results.values())
        ** 0.5
    )
    far = []
    for (easier, before), (harder, after) in pairwise(results.items()):
        surely = FARTHEST + 2 * (1 / len(before) + 1 / len(after)) ** 0.5
        if (
            sd
            and harder == easier + 1
            and (distance := (fmean(after) - fmean(before)) / sd) > surely
        ):
            far.append(f"{easier} and {harder} ({distance:.1f})")
    if not far:
        return ""
    return (
        "These levels are more than one standard deviation of an attempt's result apart: "
        f"{', '.join(far)}. A person "
        "may succeed at each attempt at one level and at none at the next."
    )
