"""Progress of a participant over sessions: lines of comparable sessions, the dose, and other
instruments.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import date
from statistics import fmean, stdev
from typing import Any, Literal

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.measure import Measure
from sar_tui.model.trial_types import Axis, Metric
from sar_tui.progress import change
from sar_tui.progress.change import Baseline, Verdict
from sar_tui.progress.level_estimate import Estimate
from sar_tui.progress.lines import Line, Point, SessionResults, Side, lines
from sar_tui.progress.scores import InstrumentChange, Score, changes
from sar_tui.progress.task_level import compared_settings, places, to_level
from sar_tui.records.kind import Kind, kinds
from sar_tui.reports.dose import Day, Dose, days_of, planned_attempts, recent
from sar_tui.rules.parameters import fields
from sar_tui.rules.wellbeing import SessionRatings, TellReason, tell_therapist
from sar_tui.store.records import Record


class AtGoal(msgspec.Struct, frozen=True):
    """The level at goal of a session with its 95 % range, on the axis of difficulty and in levels.

    A level is None where the axis goes beyond the task's levels. ``borrowed``: the slope is that of
    other sessions.
    """

    difficulty: float
    low: float
    high: float
    borrowed: bool
    level: float | None
    level_low: float | None
    level_high: float | None


class SessionProgress(msgspec.Struct, frozen=True):
    """A session on a line. ``value`` is what the line's verdicts compare: more is better.

    ``level_means``: the mean result at each level that was played.
    ``pain``, ``tiredness``: the worst that was said, 0 to 10; None if nothing is known. ``events``:
    ids of the adverse events that began in it, or after it and before the participant's next
    session.
    """

    session: str
    began: str
    status: str
    attempts: int
    planned: int
    reached: int | None
    trials: int
    right: int
    time_on_task_s: float
    first_level: int
    last_level: int
    mean: float | None
    sd: float | None
    level_means: dict[int, float]
    qualities: dict[str, float]
    at_goal: AtGoal | None
    side: Side
    value: float | None
    felt: SessionRatings
    pain: int | None
    tiredness: int | None
    events: list[str]


class LineProgress(msgspec.Struct, frozen=True):
    """Comparable sessions, and what can be said of them.

    Args:
        goal: of all levels; None if it differs between levels.
        measure: ``level`` (level at goal), ``result`` (mean result, where the level never changed),
            or empty.
        settings: what the sessions have in common, where it differs from the defaults.
        titles: of these settings, for people.
        places: of the levels on the axis of difficulty; empty if they do not rise from level to
            level.
        between_sd: SD of the sessions' means.
        baseline: None before it has enough sessions.
        verdict: on the last session whose value is known, against the baseline; ``judged``: its id.
        measured: the measures of attempts that the task declares.
        study: names of the study and of its condition; empty if the sessions are of none.
    """

    task: str
    title: str
    seat: str
    mode: str
    metric: Metric
    axis: Axis
    places: list[float]
    goal: float | None
    measure: Literal["level", "result", ""]
    settings: dict[str, Any]
    titles: dict[str, str]
    sessions: list[SessionProgress]
    between_sd: float | None
    baseline: Baseline | None
    verdict: Verdict
    judged: str | None
    measured: tuple[Measure, ...]
    study: str = ""


class Progress(msgspec.Struct, frozen=True):
    """Progress of a participant until a day.

    Args:
        lines: the one with the newest session last.
        days: with live sessions; ``recent`` is their sum over the last four weeks.
        tell: reasons to tell the therapist of pain or tiredness, from all live sessions.
        events: adverse events of the participant; ``records``: all that was entered by hand.
    """

    participant: str
    today: str
    lines: list[LineProgress]
    days: list[Day]
    recent: Dose
    tell: tuple[TellReason, ...]
    events: list[Record]
    records: list[Record]
    instruments: list[InstrumentChange]


def progress(
    participant: str,
    sessions: Iterable[SessionResults],
    find_task: Callable[[str], type[Task] | None],
    records: Sequence[Record] = (),
    today: date | None = None,
    ratings: Sequence[SessionRatings] = (),
) -> Progress:
    """Return the progress of a participant, from the results of their sessions in the order they
    were played.

    Args:
        participant: the code.
        sessions: of one task, or of all.
        find_task: returns an installed task by name.
        records: of the participant, as they are known now.
        today: day until which the dose is counted.
        ratings: of pain and tiredness in all live sessions, in their order.
    """
    played, day = list(sessions), today or date.today()
    declared = kinds()
    events = [each for each in records if _group(declared, each) == "event"]
    days, began_in = days_of(played), _began_in(played, events)
    return Progress(
        participant=participant,
        today=day.isoformat(),
        lines=[_line(line, began_in) for line in lines(played, find_task)],
        days=days,
        recent=recent(days, day),
        tell=tell_therapist(ratings),
        events=events,
        records=[each for each in records if _is_listed(declared, each)],
        instruments=changes(declared.values(), scores_of(declared, records)),
    )


def _group(declared: Mapping[str, Kind], record: Record) -> str:
    return declared[record.kind].group if record.kind in declared else ""


def _is_listed(declared: Mapping[str, Kind], record: Record) -> bool:
    """Return True if a record was entered by hand, or is a form: of any kind, also one not declared
    here.
    """
    kind = declared.get(record.kind)
    return kind is None or kind.form is not None or kind.entered_by == "therapist"


def scores_of(declared: Mapping[str, Kind], records: Sequence[Record]) -> list[Score]:
    """Return the scores among some records, in their order."""
    found = []
    for record in records:
        field = declared[record.kind].score if record.kind in declared else None
        if field and field.name in record.content:
            note = str(record.content.get("note", ""))
            score = float(record.content[field.name])
            found.append(Score(record.id, record.kind, record.day, score, note))
    return found


def _began_in(played: Sequence[SessionResults], events: Sequence[Record]) -> dict[str, list[str]]:
    """Return the adverse events of sessions: the session that an event names, or else the last one
    before it.
    """
    shown = [each for each in played if each.results]
    known = {each.session for each in shown}
    found: dict[str, list[str]] = {}
    for event in events:
        before = [
            each for each in shown if f"{each.began:%Y-%m-%d %H:%M}"[: len(event.at)] <= event.at
        ]
        if event.session in known:
            found.setdefault(event.session, []).append(event.id)
        elif before:
            found.setdefault(max(before, key=lambda each: each.began).session, []).append(event.id)
    return found


def _line(line: Line, began_in: Mapping[str, list[str]]) -> LineProgress:
    last = line.last
    rising = places(line.task) if line.task else []
    means = [point.mean for point in line.points if point.mean is not None]
    return LineProgress(
        task=last.task,
        title=line.task.tr(line.task.title) if line.task else last.title,
        seat=last.seat,
        mode=last.mode,
        metric=last.metric,
        axis=line.task.axis if line.task else Axis(),
        places=rising,
        goal=_goal(line.task) if line.task else last.parameters.get("threshold"),
        measure=line.measure,
        settings=(settings := _differing(line)),
        titles=_titles(line.task, settings) if line.task else {},
        study=line.study,
        sessions=[_session(line, point, rising, began_in) for point in line.points],
        between_sd=stdev(means) if len(means) > 1 else None,
        baseline=line.baseline,
        verdict=line.verdict,
        judged=None if line.judged is None else line.points[line.judged].results.session,
        measured=line.task.measured if line.task else (),
    )


def _goal(task: Task) -> float | None:
    goals = {task.goal_value(level) for level in range(1, task.levels + 1)}
    return goals.pop() if len(goals) == 1 else None


def _differing(line: Line) -> dict[str, Any]:
    """Return the shared settings that differ from the defaults; none if the task is not there."""
    if line.task is None:
        return {}
    defaults = compared_settings(type(line.task.parameters))
    return {name: value for name, value in line.settings.items() if value != defaults[name]}


def _titles(task: Task, names: Iterable[str]) -> dict[str, str]:
    titles = {field.name: field.title for field in fields(type(task.parameters))}
    return {name: titles[name] for name in names}


def _session(
    line: Line, point: Point, rising: Sequence[float], began_in: Mapping[str, list[str]]
) -> SessionProgress:
    results = point.results
    levels = [result.level for result in results.results]
    return SessionProgress(
        session=results.session,
        began=results.began.isoformat(timespec="seconds"),
        status=results.status,
        attempts=len(results.results),
        planned=planned_attempts(results),
        reached=results.reached,
        trials=results.trials,
        right=results.right,
        time_on_task_s=results.seconds,
        first_level=levels[0],
        last_level=levels[-1],
        mean=point.mean,
        sd=point.sd,
        level_means=_level_means(results),
        qualities=dict(results.qualities),
        at_goal=_at_goal(rising, point.estimate) if point.estimate else None,
        side=point.side,
        value=line.value(point),
        felt=results.felt,
        pain=results.felt.pain,
        tiredness=results.felt.fatigue,
        events=began_in.get(results.session, []),
    )


def _level_means(results: SessionResults) -> dict[int, float]:
    found: dict[int, list[float]] = {}
    for each in results.results:
        if each.metric is not None:
            found.setdefault(each.level, []).append(each.metric)
    return {level: fmean(found[level]) for level in sorted(found)}


def _at_goal(rising: Sequence[float], estimate: Estimate) -> AtGoal:
    return AtGoal(
        difficulty=estimate.value,
        low=estimate.low,
        high=estimate.high,
        borrowed=estimate.borrowed,
        level=to_level(rising, estimate.value),
        level_low=to_level(rising, estimate.low),
        level_high=to_level(rising, estimate.high),
    )


class Comparison(msgspec.Struct, frozen=True):
    """Two sessions side by side.

    ``comparable``: they are on one line. ``difference``: later minus earlier value of the line's
    measure; more is better. ``verdict``: against the MDC95 of the line's baseline, ``mdc95``; None
    if it is not yet known, or there is no difference. ``shared_levels``: played in both sessions,
    with a
    result; ``earlier_mean`` and ``later_mean`` are the means of these levels' means, each level
    counting the same.
    """

    earlier: SessionProgress
    later: SessionProgress
    comparable: bool
    difference: float | None
    verdict: Verdict
    mdc95: float | None
    shared_levels: list[int]
    earlier_mean: float | None
    later_mean: float | None


def compare(found: Progress, one: str, other: str) -> Comparison | None:
    """Compare two sessions of a participant, in the order they were played; None if one has no
    finished attempt.
    """
    places = {
        session.session: (session.began, line, session)
        for line in found.lines
        for session in line.sessions
    }
    if one not in places or other not in places:
        return None
    (_, line, earlier), (_, other_line, later) = sorted(
        (places[one], places[other]), key=lambda place: place[0]
    )
    comparable = line is other_line
    shared = sorted(earlier.level_means.keys() & later.level_means.keys()) if comparable else []
    earlier_mean, later_mean = (
        fmean(each.level_means[level] for level in shared) if shared else None
        for each in (earlier, later)
    )
    difference: float | None = None
    verdict: Verdict = "not yet known"
    mdc95: float | None = None
    if comparable and earlier.value is not None and later.value is not None:
        difference = later.value - earlier.value
        verdict = change.difference(later.value, earlier.value, line.baseline)
        mdc95 = line.baseline.mdc95 if line.baseline else None
    return Comparison(
        earlier, later, comparable, difference, verdict, mdc95, shared, earlier_mean, later_mean
    )
