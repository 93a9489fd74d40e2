"""Estimates of one task: its results on its axis of difficulty, and back to its levels."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import msgspec

from sar_tui.loop.task import Task
from sar_tui.progress.level_estimate import Attempt
from sar_tui.rules.parameters import TaskParameters, fields

_COMMON = {field.name for field in fields(TaskParameters)}
_MEASURING = {
    "threshold",
    *(field.name for field in fields(TaskParameters) if field.group == "Timing"),
}
"""Common settings that a result, or its distance from the goal, depends on."""


class AttemptResult(msgspec.Struct, frozen=True):
    """The result of an attempt, as it is stored. ``metric`` is None without a timed response."""

    level: int
    metric: float | None
    correct: int


@cache
def compared_settings(kind: type[TaskParameters]) -> dict[str, Any]:
    """Return the parameters that two sessions must share to be compared, with their defaults as
    they are stored.

    They are the task's own, the goal, and the timing.
    """
    compared = [
        field for field in fields(kind) if field.name not in _COMMON or field.name in _MEASURING
    ]
    return {
        field.name: msgspec.json.decode(msgspec.json.encode(field.default)) for field in compared
    }


def on_axis(task: Task, results: Sequence[AttemptResult]) -> list[Attempt]:
    """Return the attempts that have a result and a goal, with their distance from the goal of their
    level.
    """
    sign = 1 if task.metric.better == "lower" else -1
    levels = {result.level for result in results if 1 <= result.level <= task.levels}
    goals = {level: goal for level in levels if (goal := task.goal_value(level)) is not None}
    places = {level: task.difficulty(level) for level in goals}
    return [
        Attempt(
            places[result.level],
            float(max(1, result.correct)),
            sign * (result.metric - goals[result.level]),
        )
        for result in results
        if result.metric is not None and result.level in goals
    ]


def places(task: Task) -> list[float]:
    """Return the places of the task's levels on its axis; empty if they do not rise from level to
    level.
    """
    found = [task.difficulty(level) for level in range(1, task.levels + 1)]
    return found if all(easier < harder for easier, harder in pairwise(found)) else []


def to_level(rising: Sequence[float], difficulty: float) -> float | None:
    """Return the place between levels, such as 4.6; None if it is outside of them.

    Args:
        rising: of the levels, as `places` returns them.
        difficulty: on the same axis.
    """
    if not rising or not rising[0] <= difficulty <= rising[-1]:
        return None
    for level, (easier, harder) in enumerate(pairwise(rising), 1):
        if difficulty <= harder:
            return level + (difficulty - easier) / (harder - easier)
    return 1.0
