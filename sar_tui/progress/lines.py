"""Lines of comparable sessions. Sessions with other settings, seats or versions of the task, and of
other conditions of a study, never share a line.
"""

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from functools import cached_property
from typing import Any, Literal

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.session_mode import is_personal
from sar_tui.model.trial_types import Metric
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.progress import change
from sar_tui.progress.change import Baseline, Verdict
from sar_tui.progress.level_estimate import (
    Attempt,
    Estimate,
    Slope,
    brackets_goal,
    level_at_goal,
    shared_slope,
    slope_of,
)
from sar_tui.progress.task_level import AttemptResult, compared_settings, on_axis, places
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build
from sar_tui.rules.wellbeing import SessionRatings

Side = Literal["", "easier", "harder"]


class SessionResults(msgspec.Struct, frozen=True):
    """The results of a participant in a session; practice attempts are left out.

    Args:
        began: in the local time of the place where it was played.
        ended: False if it was left before its end.
        task_version: version of the task that made them.
        title: of the task.
        parameters: as stored.
        results: of its attempts, in order.
        reached: number of attempts that reached the goal; None if none of them had a goal.
        trials: number of prompts or reaches.
        right: number of right responses.
        seconds: time on the task, without the time between attempts.
        qualities: means of the measures of how it was done, by name.
        felt: what the participant said of pain and tiredness.
        study: names of the study and of its condition; empty if it is of none.
    """

    session: str
    began: datetime
    task: str
    title: str
    task_version: str
    seat: str
    mode: str
    status: str
    metric: Metric
    parameters: Mapping[str, Any]
    results: Sequence[AttemptResult]
    reached: int | None
    trials: int
    right: int
    seconds: float
    qualities: Mapping[str, float]
    felt: SessionRatings = SessionRatings()
    study: str = ""


class Point(msgspec.Struct, frozen=True):
    """A session on a line.

    Args:
        results: of the session.
        mean, sd: of the results of its attempts; None without any, or with one.
        estimate: its level at goal; None if it is not known.
        side: ``easier`` if all attempts reached the goal, so that the levels played were all too
            easy; ``harder`` if no result was better than it.
    """

    results: SessionResults
    mean: float | None
    sd: float | None
    estimate: Estimate | None
    side: Side = ""


class Line(msgspec.Struct, frozen=True, dict=True):
    """Comparable sessions, first to last.

    ``settings``: what they have in common. ``task``: with these settings; None if it is not
    installed, or no longer accepts them.
    """

    settings: Mapping[str, Any]
    task: Task | None
    points: Sequence[Point]

    @property
    def last(self) -> SessionResults:
        """The results of the last session."""
        return self.points[-1].results

    @property
    def study(self) -> str:
        """The study and its condition that all are of; empty if they are of none."""
        return self.last.study

    @property
    def fixed_level(self) -> int | None:
        """The level of all attempts, if there was only one."""
        levels = {result.level for point in self.points for result in point.results.results}
        return levels.pop() if len(levels) == 1 else None

    @property
    def measure(self) -> Literal["level", "result", ""]:
        """The measure of progress: the level at goal, or the mean result where the level never
        changed.
        """
        if any(point.estimate for point in self.points):
            return "level"
        return "result" if self.fixed_level is not None else ""

    def value(self, point: Point) -> float | None:
        """Return the measure of a session, so that more is better; None if it is not known."""
        if self.measure == "level":
            return point.estimate.value if point.estimate else None
        if self.measure == "result" and point.mean is not None:
            return point.mean if point.results.metric.better == "higher" else -point.mean
        return None

    @cached_property
    def judged(self) -> int | None:
        """Number of the session that the verdict is on: the last one whose measure is known; None
        without any.
        """
        known = [
            number for number, point in enumerate(self.points) if self.value(point) is not None
        ]
        return known[-1] if known else None

    @cached_property
    def baseline(self) -> Baseline | None:
        """The baseline; None before there are enough sessions whose measure is known."""
        return change.baseline(self._values)

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict on the person, for every screen and report that says how they are doing.

        It is not yet known if a later session, whose measure is not known, speaks against it: all
        its results were better than the goal although the last known session was worse than the
        baseline, or the other way round.
        """
        if self.judged is None:
            return "not yet known"
        found = change.verdict(self._values[-1], self.baseline)
        later = {point.side for point in self.points[self.judged + 1 :]}
        is_contradicted = (found == "less" and "easier" in later) or (
            found == "more" and "harder" in later
        )
        return "not yet known" if is_contradicted else found

    @cached_property
    def _values(self) -> list[float]:
        """The values of the sessions whose measure is known, first to last."""
        return [value for point in self.points if (value := self.value(point)) is not None]


def lines(
    sessions: Iterable[SessionResults], find_task: Callable[[str], type[Task] | None]
) -> list[Line]:
    """Return the lines of a participant's sessions, the one with the newest session last.

    Args:
        sessions: in the order in which they were played; those without a finished attempt are left
            out.
        find_task: returns an installed task by name.
    """
    grouped: dict[bytes, tuple[type[Task] | None, dict[str, Any], list[SessionResults]]] = {}
    for each in sessions:
        if not each.results:
            continue
        kind = find_task(each.task)
        kind = kind if kind and kind.version == each.task_version else None
        settings = _compared(kind, each.parameters)
        key = msgspec.json.encode(
            (each.task, each.task_version, each.seat, each.mode, each.metric, each.study, settings)
        )
        members = grouped.pop(key, (kind, settings, []))
        members[2].append(each)
        grouped[key] = members
    return [_line(*members) for members in grouped.values()]


def comparable(
    sessions: Iterable[SessionResults], task: Task, *, at_any_goal: bool = False
) -> Line | None:
    """Return the line that a live session of a task, with its settings and one participant, would
    join; or None.

    Args:
        sessions: in the order in which they were played.
        task: with its settings.
        at_any_goal: look also at sessions that differ in the goal alone. Their results are set
            against that of ``task``, as results do not depend on the goal.
    """
    settings = settings_of(task)
    members = [
        each
        for each in sessions
        if is_comparable(_at_goal(each, task) if at_any_goal else each, task, settings)
    ]
    return _line(type(task), settings, members) if members else None


def _at_goal(session: SessionResults, task: Task) -> SessionResults:
    """Return a session with the goal of a task in place of its own."""
    return msgspec.structs.replace(
        session, parameters={**session.parameters, "threshold": task.parameters.threshold}
    )


def settings_of(task: Task) -> dict[str, Any]:
    """Return the settings of a task that comparable sessions share."""
    return _compared(type(task), msgspec.json.decode(msgspec.json.encode(task.parameters)))


def is_comparable(session: SessionResults, task: Task, settings: Mapping[str, Any]) -> bool:
    """Return True for a live session of one participant with results, of a task with these shared
    settings, and of no study: nothing is carried over from its conditions.
    """
    kind = type(task)
    return (
        (session.task, session.task_version, session.seat) == (kind.name, kind.version, "A")
        and is_personal(session.mode)
        and not session.study
        and bool(session.results)
        and _compared(kind, session.parameters) == settings
    )


def _compared(kind: type[Task] | None, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that comparable sessions share; all of them if the task that declares
    them is not there.
    """
    if kind is None:
        return dict(sorted(parameters.items()))
    return {
        name: parameters.get(name, default)
        for name, default in compared_settings(kind.Parameters).items()
    }


def _line(
    kind: type[Task] | None, settings: Mapping[str, Any], members: Sequence[SessionResults]
) -> Line:
    task = _set_up(kind, settings) if kind else None
    attempts = [on_axis(task, each.results) if task else [] for each in members]
    slopes = [slope_of(each) for each in attempts]
    shared = shared_slope([slope for slope in slopes if slope])
    points = [_point(each, found, shared) for each, found in zip(members, attempts, strict=True)]
    return Line(settings, task, points)


def _set_up(kind: type[Task], settings: Mapping[str, Any]) -> Task | None:
    """Return the task with its settings; None if it does not accept them, or its levels cannot be
    placed.
    """
    try:
        task = kind(build(kind.Parameters, settings))
        places(task)
        for level in range(1, task.levels + 1):
            float(task.goal_value(level) or 0.0)
    except (ParameterError, *PLUGIN_ERRORS):
        return None
    return task


def _point(results: SessionResults, attempts: Sequence[Attempt], shared: Slope | None) -> Point:
    values = [result.metric for result in results.results if result.metric is not None]
    side: Side = ""
    if attempts and not brackets_goal(attempts):
        # of errors, if not of time
        is_missed = results.reached is not None and results.reached < len(results.results)
        if attempts[0].distance >= 0:
            side = "harder"
        elif not is_missed:
            side = "easier"
    mean = statistics.fmean(values) if values else None
    return Point(
        results=results,
        mean=mean,
        sd=math.dist(values, [mean] * len(values)) / math.sqrt(len(values) - 1)
        if mean is not None and len(values) > 1
        else None,
        estimate=level_at_goal(attempts, shared) if attempts else None,
        side=side,
    )
