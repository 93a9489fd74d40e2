"""A session beside the last one that can be compared with it."""

import statistics
from collections.abc import Iterable, Sequence
from datetime import date
from itertools import takewhile

from sar_tui.framework.language import Language
from sar_tui.framework.policies.real_change import Sample, judge, spread_of
from sar_tui.framework.results_for_people import beside_text, comparison_text, day_text
from sar_tui.framework.task import Task
from sar_tui.progress.lines import SessionResults, is_comparable, settings_of
from sar_tui.progress.task_level import AttemptResult


def earlier_sessions(sessions: Iterable[SessionResults], task: Task, *, before: str = "") -> list[SessionResults]:
    """Return the completed live sessions that are comparable with one of a task, oldest first.

    Comparable are sessions of the same task, version, goal, timing and own settings of the task, as on a line of
    progress.

    Args:
        sessions: of one participant, in the order in which they were played.
        task: with the settings of the session that is compared.
        before: id of that session, if it is among the sessions: later ones are not looked at.
    """
    settings = settings_of(task)
    until = takewhile(lambda each: each.session != before, sessions)
    return [each for each in until if each.status == "completed" and is_comparable(each, task, settings)]


def beside_previous(results: Sequence[AttemptResult], previous: SessionResults, today: date, tr: Language) -> str:
    """Return the mean results of a session and an earlier one in words: "Today 0.48 seconds, Tuesday 0.54 seconds."

    The levels are named if most attempts were at another one. Empty if a session has no timed response.
    """
    now, then = _mean(results), _mean(previous.results)
    if now is None or then is None:
        return ""
    levels = _level(results), _level(previous.results)
    return beside_text(previous.metric, now, then, day_text(previous.began.date(), today, tr), tr, levels)


def kind_word(results: Sequence[AttemptResult], earlier: Sequence[SessionResults], tr: Language) -> str:
    """Return a kind sentence on the comparison with the last session; empty if the levels or the figures say nothing.

    It praises a change only if it is more than the noise between the earlier sessions at this level.

    Args:
        results: of the session.
        earlier: comparable sessions, oldest first; at least one.
        tr: the language.
    """
    now, then = _sample(results), _sample(earlier[-1].results)
    if now is None or then is None or _level(results) != _level(earlier[-1].results):
        return ""
    alike = [each.results for each in earlier if each.results and _level(each.results) == _level(results)]
    change = judge(now, then, [found for each in alike if (found := _sample(each))], earlier[-1].metric.better)
    return comparison_text(now.mean, then.mean, tr, is_better=change is not None and change.verdict == "better")


def _sample(results: Sequence[AttemptResult]) -> Sample | None:
    """Return the mean of a session's results, as a sample of its attempts; None without any."""
    values = [result.metric for result in results if result.metric is not None]
    return Sample(statistics.fmean(values), len(values), spread_of(values)) if values else None


def _mean(results: Sequence[AttemptResult]) -> float | None:
    values = [result.metric for result in results if result.metric is not None]
    return statistics.fmean(values) if values else None


def _level(results: Sequence[AttemptResult]) -> int:
    """Return the level of most attempts; of several, the one played last."""
    levels = [result.level for result in reversed(results)]
    return statistics.mode(levels)
