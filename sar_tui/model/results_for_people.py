"""Results as participants read them: times in seconds, in every text and plot. Data stay in
milliseconds.
"""

from datetime import date

import msgspec

from sar_tui.model.language import Language
from sar_tui.model.trial_types import Metric

_DECIMALS = 2
"""Decimals of a time in seconds: more would be finer than a person can tell."""
_WEEKDAYS = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")


def goal_text(metric: Metric, goal: float, tr: Language) -> str:
    """Return a goal, for participants: "1 second", "0.85 seconds", "12 taps"."""
    return (
        _seconds(f"{round(goal / 1000, 3):.4g}", tr)
        if _is_time(metric)
        else tr.figures(metric.show(goal))
    )


def short_goal(metric: Metric, goal: float) -> str:
    """Return a goal in a few characters: "1.0 s", "0.85 s"."""
    if not _is_time(metric):
        return metric.show(goal)
    figure = f"{goal / 1000:.3f}".rstrip("0")
    return f"{figure}0 s" if figure.endswith(".") else f"{figure} s"


def result_text(metric: Metric, value: float, tr: Language, decimals: int | None = None) -> str:
    """Return a result, for participants: "0.41 seconds", "12 taps". ``decimals``: as `decimals_for`
    returns them.
    """
    if not _is_time(metric):
        return tr.figures(metric.show(value))
    return _seconds(f"{value / 1000:.{_DECIMALS if decimals is None else decimals}f}", tr)


def difference_text(
    metric: Metric, value: float, other: float, tr: Language, decimals: int | None = None
) -> str:
    """Return the distance of two results; empty if they look the same.

    They are rounded first, as people subtract the figures that they see.
    """
    size = 1000 if _is_time(metric) else 1
    shown = (_DECIMALS if decimals is None else decimals) if _is_time(metric) else metric.decimals
    distance = abs(round(value / size, shown) - round(other / size, shown)) * size
    text = result_text(metric, distance, tr, decimals)
    return "" if text == result_text(metric, 0.0, tr, decimals) else text


def beside_text(metric: Metric, now: float, then: float, when: str, tr: Language) -> str:
    """Return two results in words: "Today 0.48 seconds, Tuesday 0.54 seconds."

    ``now`` and ``then`` are of today and of an earlier day, ``when``, as `day_text` returns it.
    """
    today, before = result_text(metric, now, tr), result_text(metric, then, tr)
    return tr("Today {now}, {when} {then}.", now=today, when=when, then=before)


def levels_beside_text(now: float, then: float, when: str, tr: Language) -> str:
    """Return two levels at goal in words ("Level at goal: today 4.6, Tuesday 4.2."), as
    `beside_text` does.
    """
    today, before = (tr.figures(f"{level:.1f}") for level in (now, then))
    return tr("Level at goal: today {now}, {when} {then}.", now=today, when=when, then=before)


def verdict_text(tr: Language, *, is_better: bool) -> str:
    """Return a kind sentence on a session: praise only if it is better by more than noise and
    practice explain.
    """
    if is_better:
        return tr(
            "That is better than your first times, and more than chance and practice. Well done."
        )
    return tr("Some times go better than others, and that is all right.")


def duration_text(seconds: int, tr: Language) -> str:
    """Return a time for people: "45 seconds", "2 minutes 5 seconds"."""
    minutes, left = divmod(seconds, 60)
    texts = []
    if minutes:
        texts.append(tr("1 minute") if minutes == 1 else tr("{count} minutes", count=minutes))
    if left or not minutes:
        texts.append(_seconds(str(left), tr))
    return " ".join(texts)


def day_text(day: date, today: date, tr: Language) -> str:
    """Return an earlier day: "earlier today", "yesterday", "Tuesday", "12 days ago"."""
    days = (today - day).days
    if days < 1:
        return tr("earlier today")
    if days == 1:
        return tr("yesterday")
    if days >= len(_WEEKDAYS):
        return tr("{days} days ago", days=days)
    return tr(_WEEKDAYS[day.weekday()])


def meeting_text(today: date, days: int, tr: Language) -> str:
    """Return when the next session is, as a farewell: in so many days. Empty if that is not known,
    or more than a week away.
    """
    if days == 1:
        return tr("See you tomorrow.")
    if 1 < days < len(_WEEKDAYS):
        weekday = _WEEKDAYS[(today.weekday() + days) % len(_WEEKDAYS)]
        return tr("See you on {day}.", day=tr(weekday))
    return ""


def decimals_for(metric: Metric, value: float, goal: float) -> int | None:
    """Return the decimals with which a time is not shown as its goal, unless it is; None if the
    unit has none.
    """
    if not _is_time(metric):
        return None
    looks_alike = round(value / 1000, _DECIMALS) == round(goal / 1000, _DECIMALS)
    return _DECIMALS + 1 if looks_alike and value != goal else _DECIMALS


def axis(metric: Metric, tr: Language) -> tuple[str, float]:
    """Return the heading of a plot's axis, for participants, and the factor for its values."""
    label = tr(metric.label)
    return (label.replace("(ms)", "(s)"), 0.001) if _is_time(metric) else (label, 1.0)


def metric_for_people(metric: Metric) -> tuple[Metric, float]:
    """Return a metric as tables and figures for people show it, times in seconds, and the factor
    for its values.
    """
    if not _is_time(metric):
        return metric, 1.0
    return msgspec.structs.replace(metric, unit="s", decimals=_DECIMALS), 0.001


def _is_time(metric: Metric) -> bool:
    return metric.unit == "ms"


def _seconds(figure: str, tr: Language) -> str:
    return tr("1 second") if figure == "1" else tr("{count} seconds", count=figure)
