"""Charts of progress as plain Vega-Lite specifications (version 5), without a remote reference."""

from collections.abc import Sequence
from typing import Any

from sar_tui.framework.language import Language
from sar_tui.reports.progress import Day, LineProgress, SessionProgress

Spec = dict[str, Any]

_WIDTH, _HEIGHT, _LOW = 620, 200, 110
_INK, _SOFT = "#1f4e79", "#b9c7d6"
_CONFIG: Spec = {
    "aria": False,  # the page names each chart as a whole
    "font": "sans-serif",
    "axis": {"labelFontSize": 11, "titleFontSize": 11, "titleFontWeight": "normal"},
    "axisY": {"format": ".6~r"},
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


def _x(values: Sequence[Spec]) -> Spec:
    """Return the time axis; the days themselves where there are few."""
    few = len({value["date"] for value in values}) <= 8
    shown: Spec = {"format": "%Y-%m-%d", "labelOverlap": True, "title": None}
    return {"field": "at", "type": "temporal", "axis": {**shown, "values": [v["at"] for v in values]} if few else shown}


def _row(session: SessionProgress, **more: float | None) -> Spec:
    return {"at": session.began[:19], "date": session.began[:10], **more}


def measure_chart(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the level at goal over sessions, with the 95 % bands, and the baseline's noise in grey.

    A line whose level never changed has no such chart: its results say the same.
    """

    def place(difficulty: float) -> float:
        return 2**difficulty if line.axis.is_log2 else difficulty

    values = [
        _row(each, value=place(each.at_goal.difficulty), low=place(each.at_goal.low), high=place(each.at_goal.high))
        for each in line.sessions
        if each.at_goal
    ]
    if line.measure != "level" or not values:
        return None
    unit = tr(line.axis.unit or line.axis.name)
    scale: Spec = {"type": "log", "base": 2} if line.axis.is_log2 else {"zero": False}
    y = {"type": "quantitative", "scale": {**scale, "nice": False}, "title": unit}
    layers: list[Spec] = []
    if found := line.baseline:
        noise = {"low": place(found.mean - found.mdc95), "high": place(found.mean + found.mdc95 + found.rise)}
        area = {"y": {"field": "low", **y}, "y2": {"field": "high"}}
        layers.append({"data": {"values": [noise]}, "mark": {"type": "rect", "color": "#eee"}, "encoding": area})
    x = _x(values)
    layers += [
        {"mark": {"type": "line", "color": _INK}, "encoding": {"x": x, "y": {"field": "value", **y}}},
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
    """Chart the mean result of each session, one SD between its attempts to either side, and the goal, dashed."""
    values = [
        _row(each, value=each.mean, low=each.mean - (each.sd or 0.0), high=each.mean + (each.sd or 0.0))
        for each in line.sessions
        if each.mean is not None
    ]
    if not values:
        return None
    y = {"type": "quantitative", "scale": {"zero": False}, "title": tr(line.metric.label)}
    x = _x(values)
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
        layers.append({"data": {"values": [{"goal": line.goal}]}, "mark": dashed, "encoding": goal})
    return _chart(values, layers, _HEIGHT)


def quality_charts(line: LineProgress) -> dict[str, Spec]:
    """Chart the mean of each measure of how the sessions' movements were done, such as smoothness, by its name."""
    names = list(dict.fromkeys(name for each in line.sessions for name in each.qualities))[:_MOST_QUALITIES]
    charts = {}
    for name in names:
        values = [_row(each, value=each.qualities[name]) for each in line.sessions if name in each.qualities]
        y = {"field": "value", "type": "quantitative", "scale": {"zero": False}, "title": name.replace("_", " ")}
        mark = {"type": "line", "color": _INK, "point": {"color": _INK}}
        charts[name] = _chart(values, [{"mark": mark, "encoding": {"x": _x(values), "y": y}}], _LOW)
    return charts


def dose_chart(days: Sequence[Day], tr: Language) -> Spec | None:
    """Chart the repetitions of each day."""
    if not days:
        return None
    values = [{"at": f"{day.date}T00:00:00", "date": day.date, "value": day.repetitions} for day in days]
    y = {"field": "value", "type": "quantitative", "title": tr("repetitions")}
    bar = {"type": "bar", "color": _INK, "width": max(1, min(12, _WIDTH // (2 * len(days))))}
    return _chart(values, [{"mark": bar, "encoding": {"x": _x(values), "y": y}}], _LOW)
