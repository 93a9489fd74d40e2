"""The thesis' figures as Vega-Lite charts without a remote reference, and in characters."""

from collections.abc import Mapping, Sequence

from sar_tui.reports.attempts_plot import MARKERS, attempts_figure
from sar_tui.validation.report import Row

RESULT = "reaction time (ms)"
_INK, _SOFT, _GOAL = "#1f4e79", "#8a4b08", "#777777"
_FEEDBACK = {
    "positive": ("triangle-up", "#1f6f3a"),
    "neutral": ("square", "#8a6d08"),
    "negative": ("triangle-down", "#a01010"),
    "none": ("cross", "#777777"),
}
_CONFIG: Row = {
    "aria": False,  # the page names each chart as a whole
    "font": "sans-serif",
    "axis": {"labelFontSize": 11, "titleFontSize": 11, "titleFontWeight": "normal"},
    "view": {"stroke": "#ccc"},
}
_WIDTH = 560
_ATTEMPT: Row = {
    "field": "attempt",
    "type": "ordinal",
    "title": "attempt",
    "axis": {"labelAngle": 0},
}


def _whole(**parts: object) -> Row:
    return {
        "$schema": "https://vega.github.io/schema/vega-lite/v5.json",
        "config": _CONFIG,
        **parts,
    }


def _times(rows: Sequence[Row], label: str) -> list[Row]:
    """Return the layers of results over attempts, and of the goal."""
    times: Row = {
        "field": "reaction_time_ms",
        "type": "quantitative",
        "title": label,
        "scale": {"zero": False},
    }
    goal: Row = {"field": "goal_ms", "type": "quantitative"}
    return [
        {
            "mark": {"type": "line", "color": _GOAL, "strokeDash": [5, 4]},
            "encoding": {"x": _ATTEMPT, "y": goal},
        },
        {
            "mark": {"type": "line", "color": _INK, "point": {"color": _INK}},
            "encoding": {"x": _ATTEMPT, "y": times},
        },
    ]


def adaptation(rows: Sequence[Row], label: str = RESULT) -> Row:
    """Chart the results of a session's attempts, and the level below them. ``label``: name and unit
    of the result.
    """
    level: Row = {
        "field": "level",
        "type": "quantitative",
        "title": "level",
        "axis": {"tickMinStep": 1},
    }
    steps = {
        "mark": {"type": "line", "color": _SOFT, "interpolate": "step", "point": {"color": _SOFT}},
        "encoding": {"x": _ATTEMPT, "y": level},
        "width": _WIDTH,
        "height": 110,
    }
    above = {"layer": _times(rows, label), "width": _WIDTH, "height": 170}
    return _whole(data={"values": list(rows)}, vconcat=[above, steps])


def feedback(groups: Sequence[tuple[str, Sequence[Row]]], label: str = RESULT) -> Row:
    """Chart results over attempts with a mark for the feedback on each: one below the other, with
    titles.
    """
    names = list(_FEEDBACK)
    scale = {"domain": names, "range": [_FEEDBACK[name][0] for name in names]}
    colours = {"domain": names, "range": [_FEEDBACK[name][1] for name in names]}
    kind: Row = {"field": "feedback", "type": "nominal", "title": "feedback"}
    marks = {
        "mark": {"type": "point", "filled": True, "size": 90},
        "encoding": {
            "x": _ATTEMPT,
            "y": {"field": "reaction_time_ms", "type": "quantitative"},
            "shape": {**kind, "scale": scale},
            "color": {**kind, "scale": colours},
        },
    }
    charts = [
        {
            "title": title,
            "data": {"values": list(rows)},
            "layer": [*_times(rows, label), marks],
            "width": _WIDTH,
            "height": 180,
        }
        for title, rows in groups
    ]
    return _whole(vconcat=charts)


def angular_velocity(rows: Sequence[Row], title: str) -> Row:
    """Chart the angular velocity about z over time."""
    encoding = {
        "x": {"field": "time_s", "type": "quantitative", "title": "time, s"},
        "y": {
            "field": "rate_z_rad_s",
            "type": "quantitative",
            "title": "angular velocity about z, rad/s",
        },
    }
    return _whole(
        data={"values": list(rows)},
        title=title,
        mark={"type": "line", "color": _INK, "strokeWidth": 1},
        encoding=encoding,
        width=_WIDTH,
        height=220,
    )


def parts(rows: Sequence[Row]) -> Row:
    """Chart the parts of two loops: those of both, and those that one has alone."""
    marks = {
        "x": {
            "field": "task",
            "type": "nominal",
            "title": None,
            "axis": {"labelAngle": 0, "orient": "top"},
        },
        "y": {
            "field": "part",
            "type": "nominal",
            "title": None,
            "sort": None,
            "axis": {"minExtent": 120},
        },
    }
    shown = [
        {"part": row["part"], "task": task, "state": row["state"]}
        for row in rows
        for task in ("keyboard", "reaching")
        if row[task]
    ]
    colour = {
        "field": "state",
        "type": "nominal",
        "title": None,
        "scale": {
            "domain": ["the same", "changed", "added", "removed"],
            "range": ["#b9c7d6", "#8a4b08", "#1f6f3a", "#a01010"],
        },
    }
    return _whole(
        data={"values": shown},
        layer=[
            {
                "mark": {"type": "rect", "stroke": "#ffffff"},
                "encoding": {**marks, "color": {**colour, "legend": None}},
            },
            {
                "mark": {"type": "text", "fontSize": 11},
                "encoding": {
                    **marks,
                    "text": {"field": "state", "type": "nominal"},
                    "color": {
                        "condition": {"test": "datum.state == 'the same'", "value": "#111"},
                        "value": "#fff",
                    },
                },
            },
        ],
        width=260,
        height={"step": 22},
    )


def sentences(rows: Sequence[Row], kind: str) -> Row:
    """Chart what was said: a line for each text, after the value of the field ``kind``."""
    values = [
        {"line": number, "kind": row[kind] or "", "text": row["text"]}
        for number, row in enumerate(rows)
    ]
    y: Row = {"field": "line", "type": "ordinal", "axis": None}
    layers = [
        {"mark": {"type": "text", "align": "left", "color": colour, "fontSize": 12},
         "encoding": {"x": {"value": x}, "y": y, "text": {"field": field}}}
        for field, x, colour in (("kind", 0, _SOFT), ("text", 90, "#111111"))
    ]  # fmt: skip
    return _whole(
        data={"values": values}, layer=layers, width=640, height={"step": 20}, view={"stroke": None}
    )


_COLUMNS, _ROWS, _CURVE_ROWS = 78, 20, 14
MARKS = {"positive": "▲", "neutral": "■", "negative": "▼", "none": "·"}
"""Marks for the feedback on an attempt."""


def draw_levels(rows: Sequence[Row], title: str, label: str = RESULT) -> str:
    """Draw results over attempts with the goal, and the level of each attempt below them.

    Args:
        rows: one per attempt, in order: ``reaction_time_ms`` (None without one), ``goal_ms``,
            ``level``, ``outcome``.
        title: text above the drawing.
        label: name and unit of the result.
    """
    names = ["reached" if row["outcome"] == "success" else "missed" for row in rows]
    return _attempts(rows, title, label, names, MARKERS)


def draw_feedback(rows: Sequence[Row], title: str, label: str = RESULT) -> str:
    """Draw results as `draw_levels` does, with a mark for the feedback on each attempt.

    Args:
        rows: one per attempt, in order: ``reaction_time_ms`` (None without one), ``goal_ms``,
            ``level``, ``feedback``.
        title, label: as there.
    """
    return _attempts(rows, title, label, [row["feedback"] for row in rows], MARKS)


def _attempts(
    rows: Sequence[Row], title: str, label: str, names: Sequence[str], markers: Mapping[str, str]
) -> str:
    times = [row["reaction_time_ms"] for row in rows]
    drawn = attempts_figure(
        [row["level"] for row in rows],
        times,
        metric=label,
        goals=[row["goal_ms"] for row in rows],
        width=_COLUMNS,
        height=_ROWS,
        color=False,
        results=[
            "no result" if time is None else name for time, name in zip(times, names, strict=True)
        ],
        markers=markers,
    )
    return f"{title}\n{drawn}"


def draw_curve(x: Sequence[float], y: Sequence[float], title: str, axes: str) -> str:
    """Draw a curve. ``axes``: says what is drawn over what."""
    import plotext

    plotext.clear_figure()
    try:
        plotext.limit_size(False, False)
        plotext.theme("clear")
        plotext.plotsize(_COLUMNS, _CURVE_ROWS)
        plotext.xlim(min(x), max(x))
        plotext.plot(list(x), list(y), marker="braille")
        body = plotext.uncolorize(str(plotext.build()))
    finally:
        plotext.clear_figure()
    lines = [line.rstrip() for line in body.rstrip("\n").split("\n")]
    return "\n".join([title, axes, *lines])
