"""The thesis' figures as Vega-Lite charts without a remote reference, and in characters."""

from collections.abc import Mapping, Sequence

from sar_tui.reports.charts import (
    ACCENT,
    ALARM,
    DIM,
    INK,
    MARKERS,
    SOFT,
    attempts_figure,
    channel,
    curve,
    mark,
    picture,
)
from sar_tui.validation.report import Row

RESULT = "reaction time (ms)"
_FEEDBACK = {
    "positive": ("triangle-up", "#1f6f3a"),
    "neutral": ("square", "#8a6d08"),
    "negative": ("triangle-down", ALARM),
    "none": ("cross", DIM),
}
_WIDTH = 560
_ATTEMPT = channel("attempt", "ordinal", title="attempt", axis={"labelAngle": 0})


def _times(rows: Sequence[Row], label: str) -> list[Row]:
    """Return the layers of results over attempts, and of the goal."""
    times = channel("reaction_time_ms", title=label, scale={"zero": False})
    return [
        mark("line", {"x": _ATTEMPT, "y": channel("goal_ms")}, color=DIM, strokeDash=[5, 4]),
        mark("line", {"x": _ATTEMPT, "y": times}, color=INK, point={"color": INK}),
    ]


def adaptation(rows: Sequence[Row], label: str = RESULT) -> Row:
    """Chart the results of a session's attempts, and the level below them. ``label``: name and unit
    of the result.
    """
    level = channel("level", title="level", axis={"tickMinStep": 1})
    steps = mark(
        "line",
        {"x": _ATTEMPT, "y": level},
        color=ACCENT,
        interpolate="step",
        point={"color": ACCENT},
    )
    above = {"layer": _times(rows, label), "width": _WIDTH, "height": 170}
    return picture(rows, vconcat=[above, {**steps, "width": _WIDTH, "height": 110}])


def feedback(groups: Sequence[tuple[str, Sequence[Row]]], label: str = RESULT) -> Row:
    """Chart results over attempts with a mark for the feedback on each: one below the other, with
    titles.
    """
    names = list(_FEEDBACK)
    shapes, colours = ([_FEEDBACK[name][index] for name in names] for index in (0, 1))
    kind = channel("feedback", "nominal", title="feedback")
    encoding = {
        "x": _ATTEMPT,
        "y": channel("reaction_time_ms"),
        "shape": {**kind, "scale": {"domain": names, "range": shapes}},
        "color": {**kind, "scale": {"domain": names, "range": colours}},
    }
    marks = mark("point", encoding, filled=True, size=90)
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
    return picture(vconcat=charts)


def angular_velocity(rows: Sequence[Row], title: str) -> Row:
    """Chart the angular velocity about z over time."""
    encoding = {
        "x": channel("time_s", title="time, s"),
        "y": channel("rate_z_rad_s", title="angular velocity about z, rad/s"),
    }
    line = mark("line", encoding, color=INK, strokeWidth=1)
    return picture(rows, title=title, width=_WIDTH, height=220, **line)


def parts(rows: Sequence[Row]) -> Row:
    """Chart the parts of two loops: those of both, and those that one has alone."""
    places = {
        "x": channel("task", "nominal", title=None, axis={"labelAngle": 0, "orient": "top"}),
        "y": channel("part", "nominal", title=None, sort=None, axis={"minExtent": 120}),
    }
    shown = [
        {"part": row["part"], "task": task, "state": row["state"]}
        for row in rows
        for task in ("keyboard", "reaching")
        if row[task]
    ]
    states = {
        "domain": ["the same", "changed", "added", "removed"],
        "range": [SOFT, ACCENT, "#1f6f3a", ALARM],
    }
    colour = channel("state", "nominal", title=None, scale=states, legend=None)
    is_same = {"test": "datum.state == 'the same'", "value": "#111"}
    text = {"text": channel("state", "nominal"), "color": {"condition": is_same, "value": "#fff"}}
    layers = [
        mark("rect", {**places, "color": colour}, stroke="#ffffff"),
        mark("text", {**places, **text}, fontSize=11),
    ]
    return picture(shown, layers, width=260, height={"step": 22})


def sentences(rows: Sequence[Row], kind: str) -> Row:
    """Chart what was said: a line for each text, after the value of the field ``kind``."""
    values = [
        {"line": number, "kind": row[kind] or "", "text": row["text"]}
        for number, row in enumerate(rows)
    ]
    y = channel("line", "ordinal", axis=None)
    layers = [
        mark(
            "text",
            {"x": {"value": x}, "y": y, "text": {"field": field}},
            align="left",
            color=colour,
            fontSize=12,
        )
        for field, x, colour in (("kind", 0, ACCENT), ("text", 90, "#111111"))
    ]
    return picture(values, layers, width=640, height={"step": 20}, view={"stroke": None})


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
    return "\n".join([title, axes, *curve(x, y, _COLUMNS, _CURVE_ROWS)])
