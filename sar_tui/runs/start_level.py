"""The level at which a live session starts: from the last session's estimate, its last level, or as it is set."""

import sqlite3
from collections.abc import Iterable

import msgspec

from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.policies.difficulty import POLICIES
from sar_tui.framework.task import Task
from sar_tui.progress.lines import Point, SessionResults, comparable
from sar_tui.store.results import newest_of

LOOKED_AT = 16
"""Newest sessions that the estimate is made from: the slope that they share hardly changes with more."""


def with_start_level(database: sqlite3.Connection, task: Task, participant: str) -> TaskParameters:
    """Return a task's parameters with the start level of the participant's next session.

    It stays as set if it is fixed, if the policy does not move the level, if two people share the level, or if there
    is no live session with comparable settings.
    """
    if not _moves(task):
        return task.parameters
    return started_after(task, newest_of(database, participant, task.name, LOOKED_AT))


def _moves(task: Task) -> bool:
    given = task.parameters
    is_moved = given.start_from != "fixed" and POLICIES[given.difficulty_policy].moves_level
    return is_moved and len(task.seats) == 1


def started_after(task: Task, sessions: Iterable[SessionResults]) -> TaskParameters:
    """Return the same from a participant's newest sessions of the task, the oldest of them first."""
    given = task.parameters
    line = comparable(sessions, task) if _moves(task) else None
    if line is None:
        return given
    wanted = _level(line.points[-1], task, by_estimate=given.start_from == "estimate")
    level = max(given.min_level, min(wanted, given.max_level, task.levels))
    return msgspec.structs.replace(given, start_level=level)


def _level(last: Point, task: Task, *, by_estimate: bool) -> int:
    """Return the hardest level whose goal the person is expected to reach; without an estimate the last one played."""
    if not by_estimate or last.estimate is None:
        return last.results.results[-1].level
    reached = [level for level in range(1, task.levels + 1) if task.difficulty(level) <= last.estimate.value]
    return max(reached, default=1)
