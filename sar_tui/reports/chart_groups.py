"""Sessions and days that share a mark of a chart: with a mark for each of a thousand, a page would
open slowly.

A printed chart has room for little more than a hundred marks beside each other anyway.
"""

from collections.abc import Callable, Sequence
from datetime import date, timedelta
from statistics import fmean
from typing import Any, Literal

from sar_tui.reports.dose import Day

MOST = 120
"""Marks of a chart."""

Span = Literal["day", "week", "month"]
Row = dict[str, Any]


def sessions_of_a_mark(sessions: int) -> int:
    """Return how many sessions, one after the other, share a mark."""
    return -(-sessions // MOST)


def grouped(rows: Sequence[Row], combine: Callable[[Sequence[float]], float] = fmean) -> list[Row]:
    """Return rows of which neighbours are combined, number by number, at the time of the middle
    one.
    """
    step = sessions_of_a_mark(len(rows))
    if step <= 1:
        return list(rows)
    found = []
    for first in range(0, len(rows), step):
        own = rows[first : first + step]
        middle = own[len(own) // 2]
        found.append(
            {name: value if isinstance(value, str) else combine([row[name] for row in own])
             for name, value in middle.items()}
        )  # fmt: skip
    return found


def span_of(days: Sequence[Day]) -> Span:
    """Return the time that shares a mark in charts of the dose: the shortest that has no more marks
    than fit.
    """
    if len(days) <= MOST:
        return "day"
    return "week" if len({_begin(day, "week") for day in days}) <= MOST else "month"


def summed(days: Sequence[Day]) -> list[Row]:
    """Return what was done and planned in each time with sessions, at its first day."""
    span = span_of(days)
    found: dict[str, Row] = {}
    for day in days:
        at = _begin(day, span)
        row = found.setdefault(
            at, {"at": f"{at}T00:00:00", "date": at, "done": 0, "planned": 0, "repetitions": 0}
        )
        row["done"] += day.done
        row["planned"] += day.planned
        row["repetitions"] += day.repetitions
    return list(found.values())


def _begin(day: Day, span: Span) -> str:
    """Return the first day of the week, from Monday, or of the month."""
    at = date.fromisoformat(day.date)
    if span == "week":
        at -= timedelta(days=at.weekday())
    return at.replace(day=1).isoformat() if span == "month" else at.isoformat()
