"""Charts of progress as plain Vega-Lite specifications (version 5), without a remote reference."""

from collections.abc import Callable, Sequence
from datetime import date, timedelta
from statistics import fmean
from typing import Any, Literal

from sar_tui.model.language import Language
from sar_tui.model.results_for_people import axis
from sar_tui.reports import progress_words
from sar_tui.reports.dose import Day
from sar_tui.reports.progress import LineProgress, SessionProgress
from sar_tui.reports.session_chart import EVENT

Spec = dict[str, Any]

_WIDTH, _HEIGHT, _LOW = 620, 200, 110
_EDGE = 8
"""Pixels between the ends of the time axis and the first and last session."""
_INK, _SOFT, _OTHER, _EVENT = "#1f4e79", "#b9c7d6", "#8a4b08", "#a01010"
_CONFIG: Spec = {
    "aria": False,  # the page names each chart as a whole
    "font": "sans-serif",
    "axis": {"labelFontSize": 11, "titleFontSize": 11, "titleFontWeight": "normal"},
    "axisY": {"format": ".6~r", "minExtent": 40},
    "view": {"stroke": "#ccc"},
}
_MOST_QUALITIES = 4


def _chart(values: Sequence[Spec], layers: Sequence[Spec], height: int) -> Spec:
    return {
        "$schema": "https://vega.github.io/schema/vega-lite/v5.json",
        "width": _WIDTH,
        "height": height,
        "data": {"values": list(values)},
        "layer": list(layers),
        "config": _CONFIG,
    }


def _x(values: Sequence[Spec], sessions: Sequence[SessionProgress] = ()) -> Spec:
    """Return the time axis, the same for all charts of the sessions; the days themselves where
    there are few.
    """
    few = len({value["date"] for value in values}) <= 8
    shown: Spec = {"format": "%Y-%m-%d", "labelOverlap": True, "title": None}
    axis = {**shown, "values": [v["at"] for v in values]} if few else shown
    found: Spec = {"field": "at", "type": "temporal", "axis": axis}
    if sessions and (first := sessions[0].began[:19]) != (last := sessions[-1].began[:19]):
        found["scale"] = {"domain": [first, last], "nice": False, "padding": _EDGE}
    return found


def _row(session: SessionProgress, **more: float | None) -> Spec:
    return {"at": session.began[:19], "date": session.began[:10], **more}


def measure_chart(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the level at goal over sessions, with the 95 % bands, and the baseline's noise in grey.

    A line whose level never changed has no such chart: its results say the same.
    """

    def place(difficulty: float) -> float:
        return 2**difficulty if line.axis.is_log2 else difficulty

    known = [
        _row(each, value=each.at_goal.difficulty, low=each.at_goal.low, high=each.at_goal.high)
        for each in line.sessions
        if each.at_goal
    ]
    values = [
        row | {name: place(row[name]) for name in ("value", "low", "high")}
        for row in grouped(known)
    ]
    if line.measure != "level" or not values:
        return None
    unit = tr(line.axis.unit or line.axis.name)
    scale: Spec = {"type": "log", "base": 2} if line.axis.is_log2 else {"zero": False}
    y = {"type": "quantitative", "scale": {**scale, "nice": False}, "title": unit}
    layers: list[Spec] = []
    if found := line.baseline:
        noise = {
            "low": place(found.mean - found.mdc95),
            "high": place(found.mean + found.mdc95 + found.rise),
        }
        area = {"y": {"field": "low", **y}, "y2": {"field": "high"}}
        layers.append(
            {
                "data": {"values": [noise]},
                "mark": {"type": "rect", "color": "#eee"},
                "encoding": area,
            }
        )
    x = _x(values, line.sessions)
    layers += [
        {
            "mark": {"type": "line", "color": _INK},
            "encoding": {"x": x, "y": {"field": "value", **y}},
        },
        {
            "mark": {"type": "rule", "color": _INK, "strokeWidth": 1.5},
            "encoding": {"x": x, "y": {"field": "low", **y}, "y2": {"field": "high"}},
        },
        {
            "mark": {"type": "point", "color": _INK, "filled": True, "size": 40},
            "encoding": {"x": x, "y": {"field": "value", **y}},
        },
    ]
    return _chart(values, layers, _HEIGHT)


def result_chart(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the mean result of each session, one SD between its attempts to either side, and the
    goal, dashed.
    """
    label, factor = axis(line.metric, tr)
    values = [
        _row(
            each,
            value=each.mean * factor,
            low=(each.mean - (each.sd or 0.0)) * factor,
            high=(each.mean + (each.sd or 0.0)) * factor,
        )
        for each in line.sessions
        if each.mean is not None
    ]
    if not values:
        return None
    values = grouped(values)
    is_turned = line.metric.better == "lower"  # better results are higher up
    title = f"{label}, {tr('better is up')}" if is_turned else label
    y = {"type": "quantitative", "scale": {"zero": False, "reverse": is_turned}, "title": title}
    x = _x(values, line.sessions)
    layers: list[Spec] = [
        {
            "mark": {"type": "rule", "color": _SOFT, "strokeWidth": 3},
            "encoding": {"x": x, "y": {"field": "low", **y}, "y2": {"field": "high"}},
        },
        {
            "mark": {"type": "line", "color": _INK, "point": {"color": _INK}},
            "encoding": {"x": x, "y": {"field": "value", **y}},
        },
    ]
    if line.goal is not None:
        dashed = {"type": "rule", "strokeDash": [6, 4], "color": "#444"}
        goal = {"y": {"field": "goal", "type": "quantitative"}}
        layers.append(
            {"data": {"values": [{"goal": line.goal * factor}]}, "mark": dashed, "encoding": goal}
        )
    return _chart(values, layers, _HEIGHT)


def quality_charts(line: LineProgress, tr: Language) -> dict[str, Spec]:
    """Chart the mean of each measure of how the sessions' movements were done, such as smoothness,
    by its name.
    """
    names = list(dict.fromkeys(name for each in line.sessions for name in each.qualities))[
        :_MOST_QUALITIES
    ]
    charts = {}
    for name in names:
        values = grouped(
            [
                _row(each, value=each.qualities[name])
                for each in line.sessions
                if name in each.qualities
            ]
        )
        y = {
            "field": "value",
            "type": "quantitative",
            "scale": {"zero": False},
            "title": progress_words.quality(line, name, tr),
        }
        mark = {"type": "line", "color": _INK, "point": {"color": _INK}}
        charts[name] = _chart(
            values, [{"mark": mark, "encoding": {"x": _x(values, line.sessions), "y": y}}], _LOW
        )
    return charts


def felt_chart(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the worst pain and tiredness of each session, and the adverse events; None if there is
    nothing of them.
    """
    layers: list[Spec] = []
    every: list[Spec] = []
    scale: Spec = {
        "type": "quantitative",
        "scale": {"domain": [0, 10]},
        "title": f"{tr('pain')}, {tr('tiredness')}",
    }
    for name, shape, dash in (("pain", "circle", []), ("tiredness", "square", [4, 3])):
        rated = [
            _row(each, value=given)
            for each in line.sessions
            if (given := getattr(each, name)) is not None
        ]
        values = grouped(rated, max)
        if not values:
            continue
        every += values
        ink = _INK if name == "pain" else _OTHER
        point = {"color": ink, "shape": shape, "filled": name == "pain", "size": 40}
        mark = {"type": "line", "color": ink, "strokeDash": dash, "point": point}
        layers.append(
            {
                "data": {"values": values},
                "mark": mark,
                "encoding": {"y": {"field": "value", **scale}},
            }
        )
    if events := [_row(each) for each in line.sessions if each.events]:
        every += events
        text = {
            "type": "text",
            "text": EVENT,
            "color": _EVENT,
            "dx": 6,
            "dy": 8,
            "fontSize": 16,
            "fontWeight": "bold",
        }
        layers.append(
            {"data": {"values": events}, "mark": {"type": "rule", "color": _EVENT}, "encoding": {}}
        )
        layers.append(
            {"data": {"values": events}, "mark": text, "encoding": {"y": {"datum": 10, **scale}}}
        )
    for layer in layers:
        layer["encoding"]["x"] = _x(every, line.sessions)
    return _chart(every, layers, _LOW) if layers else None


def attempts_chart(days: Sequence[Day], tr: Language) -> Spec | None:
    """Chart the attempts done on each day (or week, or month) as bars, and those planned as a line
    across them.
    """
    if not days:
        return None
    values = summed(days)
    title = tr("attempts")
    width = max(1, min(12, _WIDTH // (2 * len(values))))
    x = _x(values)
    layers: list[Spec] = [
        {
            "mark": {"type": "bar", "color": _SOFT, "width": width},
            "encoding": {"x": x, "y": {"field": "done", "type": "quantitative", "title": title}},
        },
        {
            "mark": {"type": "tick", "color": "#111", "thickness": 2, "width": width + 4},
            "encoding": {"x": x, "y": {"field": "planned", "type": "quantitative", "title": title}},
        },
    ]
    return _chart(values, layers, _LOW)


def dose_chart(days: Sequence[Day], tr: Language) -> Spec | None:
    """Chart the repetitions of each day, or week, or month."""
    if not days:
        return None
    values = summed(days)
    y = {"field": "repetitions", "type": "quantitative", "title": tr("repetitions")}
    bar = {"type": "bar", "color": _INK, "width": max(1, min(12, _WIDTH // (2 * len(values))))}
    return _chart(values, [{"mark": bar, "encoding": {"x": _x(values), "y": y}}], _LOW)


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
