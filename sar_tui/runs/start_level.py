"""The level at which a live session starts: from the last session's estimate, its last level, or as
it is set.
"""

import sqlite3
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import msgspec

from sar_tui.loop.task import Task
from sar_tui.progress.lines import Point, SessionResults, comparable
from sar_tui.progress.task_level import AttemptResult
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.store.results import newest_of

LOOKED_AT = 16
"""Newest sessions that the estimate is made from: the slope that they share hardly changes with
more.
"""


class Start(NamedTuple):
    """The level at which a session starts, and why, in words; empty if there is nothing to say.

    ``from_results``: False if it is the start level as it is set.
    """

    level: int
    why: str
    from_results: bool = False


def with_start_level(database: sqlite3.Connection, task: Task, participant: str) -> TaskParameters:
    """Return a task's parameters with the start level of the participant's next session.

    It stays as set if it is fixed, if the policy does not move the level, if two people share the
    level, or if there is no live session with comparable settings.
    """
    if not _moves(task):
        return task.parameters
    return started_after(task, newest_of(database, participant, task.name, LOOKED_AT))


def _moves(task: Task) -> bool:
    given = task.parameters
    is_moved = given.start_from != "fixed" and DIFFICULTY[given.difficulty_policy].moves_level
    return is_moved and len(task.seats) == 1


def started_after(task: Task, sessions: Iterable[SessionResults]) -> TaskParameters:
    """Return the same from a participant's newest sessions of the task, the oldest of them
    first.
    """
    return msgspec.structs.replace(task.parameters, start_level=start_after(task, sessions).level)


def start_after(task: Task, sessions: Iterable[SessionResults]) -> Start:
    """Return the same as a level, and why.

    After a change of the goal alone, the level follows from the same results and the new goal.
    """
    given = task.parameters
    if not _moves(task):
        return Start(given.start_level, "as set" if given.start_from == "fixed" else "")
    played = list(sessions)
    if line := comparable(played, task):
        last, why = line.points[-1], "from the last times"
    elif line := comparable(played, task, at_any_goal=True):
        last, why = _around_goal(line.points, task), "from earlier times and the new goal"
        if last.side == "harder" and given.start_from == "estimate":
            return Start(given.start_level, "no result so far reaches the new goal")
    else:
        return Start(given.start_level, "the first session with these settings" if played else "")
    by_estimate = given.start_from == "estimate" and last.estimate is not None
    level = max(
        given.min_level,
        min(_level(last, task, by_estimate=by_estimate), given.max_level, task.levels),
    )
    return Start(level, why if by_estimate else "as the last one ended", from_results=True)


def _around_goal(points: Sequence[Point], task: Task) -> Point:
    """Return the newest sessions as one: as many as have results on both sides of the goal, or
    all.
    """
    results: list[AttemptResult] = []
    found = points[-1]
    for point in reversed(points):
        results[:0] = point.results.results
        together = msgspec.structs.replace(points[-1].results, results=tuple(results))
        line = comparable([together], task, at_any_goal=True)
        found = line.points[-1] if line else found
        if found.estimate:
            break
    return found


def _level(last: Point, task: Task, *, by_estimate: bool) -> int:
    """Return the hardest level whose goal the person is expected to reach; without an estimate the
    last one played.
    """
    if not by_estimate or last.estimate is None:
        return last.results.results[-1].level
    reached = [
        level
        for level in range(1, task.levels + 1)
        if task.difficulty(level) <= last.estimate.value
    ]
    return max(reached, default=1)
