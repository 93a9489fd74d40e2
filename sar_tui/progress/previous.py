"""A session beside the last one that can be compared with it."""

import statistics
from collections.abc import Iterable, Sequence
from datetime import date

from sar_tui.framework.language import Language
from sar_tui.framework.results_for_people import beside_text, comparison_text, day_text
from sar_tui.framework.task import Task
from sar_tui.progress.lines import SessionResults, is_comparable, settings_of
from sar_tui.progress.task_level import AttemptResult


def previous_session(sessions: Iterable[SessionResults], task: Task, *, before: str = "") -> SessionResults | None:
    """Return the last completed live session that is comparable with one of a task, or None.

    Comparable are sessions of the same task, version, goal, timing and own settings of the task, as on a line of
    progress.

    Args:
        sessions: of one participant, in the order in which they were played.
        task: with the settings of the session that is compared.
        before: id of that session, if it is among the sessions: later ones are not looked at.
    """
    settings, found = settings_of(task), None
    for each in sessions:
        if each.session == before:
            break
        if each.status == "completed" and is_comparable(each, task, settings):
            found = each
    return found


def beside_previous(results: Sequence[AttemptResult], previous: SessionResults, today: date, tr: Language) -> str:
    """Return the mean results of a session and an earlier one in words: "Today 0.48 seconds, Tuesday 0.54 seconds."

    The levels are named if most attempts were at another one. Empty if a session has no timed response.
    """
    now, then = _mean(results), _mean(previous.results)
    if now is None or then is None:
        return ""
    levels = _level(results), _level(previous.results)
    return beside_text(previous.metric, now, then, day_text(previous.began.date(), today, tr), tr, levels)


def kind_word(results: Sequence[AttemptResult], previous: SessionResults, tr: Language) -> str:
    """Return a kind sentence on the comparison, whatever it shows; empty if the levels or the figures say nothing."""
    now, then = _mean(results), _mean(previous.results)
    if now is None or then is None or _level(results) != _level(previous.results):
        return ""
    return comparison_text(previous.metric, now, then, tr)


def _mean(results: Sequence[AttemptResult]) -> float | None:
    values = [result.metric for result in results if result.metric is not None]
    return statistics.fmean(values) if values else None


def _level(results: Sequence[AttemptResult]) -> int:
    """Return the level of most attempts; of several, the one played last."""
    levels = [result.level for result in reversed(results)]
    return statistics.mode(levels)
