"""Charts of progress: their values, and their pictures for the page."""

from collections.abc import Callable, Sequence
from datetime import date, timedelta
from statistics import fmean
from typing import Any, Literal

import msgspec

from sar_tui.model.language import Language
from sar_tui.model.results_for_people import axis
from sar_tui.reports import progress_words
from sar_tui.reports.charts import (
    ABOVE,
    ACCENT,
    BELOW,
    EVENT,
    INK,
    SOFT,
    UNKNOWN,
    WIDTH,
    Spec,
    Value,
    channel,
    mark,
    picture,
)
from sar_tui.reports.dose import Day
from sar_tui.reports.progress import LineProgress, SessionProgress

_SIDES = {"easier": ABOVE, "harder": BELOW, "": UNKNOWN}
_HEIGHT, _LOW = 200, 110
"""Heights of pictures in pixels."""
LOOK = ACCENT
"""Colour of what needs a look."""
_EDGE = 8
"""Pixels between the ends of the time axis and the first and last session."""
_MOST_QUALITIES = 4


class Chart(msgspec.Struct, frozen=True, kw_only=True):
    """Values over the sessions of a line, however they are drawn.

    Attributes:
        title: name and unit of the axis.
        values: of each session, with their bands.
        area: values between which all is shaded.
        rule: value at which a dashed line is drawn.
        is_log2: the values are logarithms to base 2 of what the axis of a picture says.
        is_turned: lower values are higher up, so that a person who gets better never seems to fall.
    """

    title: str
    values: Sequence[Value]
    area: tuple[float, float] | None = None
    rule: float | None = None
    is_log2: bool = False
    is_turned: bool = False


def level_chart(line: LineProgress, tr: Language) -> Chart:
    """Return the level at goal over sessions with its 95 % ranges, and the baseline's noise."""
    values = []
    for each in line.sessions:
        found = each.at_goal
        values.append(
            Value(found.difficulty, found.low, found.high)
            if found
            else Value(without=_SIDES[each.side])
        )
    area = None
    if base := line.baseline:
        area = (base.mean - base.mdc95, base.mean + base.mdc95 + base.rise)
    unit = tr(line.axis.unit or line.axis.name)
    return Chart(title=unit, values=values, area=area, is_log2=line.axis.is_log2)


def result_chart(line: LineProgress, tr: Language) -> Chart:
    """Return the mean result of each session with one SD to either side, and the goal."""
    label, factor = axis(line.metric, tr)
    values = []
    for each in line.sessions:
        if each.mean is None:
            values.append(Value(without=UNKNOWN))
            continue
        mean, sd = each.mean * factor, (each.sd or 0.0) * factor
        values.append(Value(mean, mean - sd, mean + sd))
    is_turned = line.metric.better == "lower"
    return Chart(
        title=f"{label}, {tr('better is up')}" if is_turned else label,
        values=values,
        rule=None if line.goal is None else line.goal * factor,
        is_turned=is_turned,
    )


def needs_look(session: SessionProgress) -> bool:
    """Return True if pain in a session was above the limits, or an adverse event began."""
    return session.felt.is_reason_to_stop or bool(session.events)


# --- pictures
# --------------------------------------------------------------------------------------------------


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


def level_picture(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the level at goal over sessions, with the 95 % ranges, and the baseline's noise in grey.

    A line whose level never changed has no such chart: its results say the same.
    """
    return _picture(line, level_chart(line, tr)) if line.measure == "level" else None


def result_picture(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the mean result of each session, one SD between its attempts to either side, and the
    goal, dashed.
    """
    return _picture(line, result_chart(line, tr))


def _picture(line: LineProgress, chart: Chart) -> Spec | None:
    """Draw a chart; None if no session has a value."""

    def place(value: float) -> float:
        return 2**value if chart.is_log2 else value

    known = [
        _row(session, value=each.value, low=each.low, high=each.high)
        for session, each in zip(line.sessions, chart.values, strict=True)
        if each.value is not None
    ]
    if not known:
        return None
    values = [
        row | {name: place(row[name]) for name in ("value", "low", "high")}
        for row in grouped(known)
    ]
    scale: Spec = {"type": "log", "base": 2} if chart.is_log2 else {"zero": False}
    scale |= {"nice": False} if chart.area else {}
    scale |= {"reverse": chart.is_turned}
    x = _x(values, line.sessions)
    y = channel("value", scale=scale, title=chart.title)
    band = {"y": y | {"field": "low"}, "y2": {"field": "high"}}
    layers = []
    if chart.area:
        low, high = map(place, chart.area)
        layers.append(mark("rect", band, [{"low": low, "high": high}], color="#eee"))
    layers += [
        mark("rule", {"x": x, **band}, color=SOFT, strokeWidth=3),
        mark("line", {"x": x, "y": y}, color=INK, point={"color": INK}),
    ]
    if chart.rule is not None:
        goal = [{"goal": place(chart.rule)}]
        layers.append(mark("rule", {"y": channel("goal")}, goal, strokeDash=[6, 4], color="#444"))
    return picture(values, layers, height=_HEIGHT)


def quality_pictures(line: LineProgress, tr: Language) -> dict[str, Spec]:
    """Chart the mean of each measure of how the sessions' movements were done, such as smoothness,
    by its name.
    """
    names = dict.fromkeys(name for each in line.sessions for name in each.qualities)
    made = {}
    for name in list(names)[:_MOST_QUALITIES]:
        values = grouped(
            [
                _row(each, value=each.qualities[name])
                for each in line.sessions
                if name in each.qualities
            ]
        )
        title = progress_words.quality(line, name, tr)
        y = channel("value", scale={"zero": False}, title=title)
        encoding = {"x": _x(values, line.sessions), "y": y}
        made[name] = picture(
            values, [mark("line", encoding, color=INK, point={"color": INK})], height=_LOW
        )
    return made


def felt_picture(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the worst pain and tiredness of each session, and mark those that need a look; None if
    there is nothing of them.
    """
    layers: list[Spec] = []
    every: list[Spec] = []
    scale: Spec = {"scale": {"domain": [0, 10]}, "title": f"{tr('pain')}, {tr('tiredness')}"}
    for name, ink, shape, dash in (
        ("pain", INK, "circle", []),
        ("tiredness", ACCENT, "square", [4, 3]),
    ):
        rated = [
            _row(each, value=given)
            for each in line.sessions
            if (given := getattr(each, name)) is not None
        ]
        values = grouped(rated, max)
        if not values:
            continue
        every += values
        point = {"color": ink, "shape": shape, "filled": name == "pain", "size": 40}
        encoding = {"y": channel("value", **scale)}
        layers.append(mark("line", encoding, values, color=ink, strokeDash=dash, point=point))
    if looks := [_row(each) for each in line.sessions if needs_look(each)]:
        every += looks
        sign = {"dx": 6, "dy": 8, "fontSize": 16, "fontWeight": "bold"}
        top = {"y": {"datum": 10, "type": "quantitative", **scale}}
        layers.append(mark("rule", {}, looks, color=LOOK))
        layers.append(mark("text", top, looks, text=EVENT, color=LOOK, **sign))
    for layer in layers:
        layer["encoding"]["x"] = _x(every, line.sessions)
    return picture(every, layers, height=_LOW) if layers else None


def minutes_picture(line: LineProgress, tr: Language) -> Spec:
    """Chart the minutes on task of each session, on the time axis of the others."""
    values = grouped([_row(each, minutes=each.time_on_task_s / 60) for each in line.sessions])
    encoding = {"x": _x(values, line.sessions), "y": channel("minutes", title=tr("minutes"))}
    bars = mark("bar", encoding, color=SOFT, width=_bar_width(values))
    return picture(values, [bars], height=_LOW)


def attempts_picture(days: Sequence[Day], tr: Language) -> Spec | None:
    """Chart the attempts done on each day (or week, or month) as bars, and those planned as a line
    across them.
    """
    if not days:
        return None
    values = summed(days)
    x, title, width = _x(values), tr("attempts"), _bar_width(values)
    done = {"x": x, "y": channel("done", title=title)}
    planned = {"x": x, "y": channel("planned", title=title)}
    layers = [
        mark("bar", done, color=SOFT, width=width),
        mark("tick", planned, color="#111", thickness=2, width=width + 4),
    ]
    return picture(values, layers, height=_LOW)


def dose_picture(days: Sequence[Day], tr: Language) -> Spec | None:
    """Chart the repetitions of each day, or week, or month."""
    if not days:
        return None
    values = summed(days)
    encoding = {"x": _x(values), "y": channel("repetitions", title=tr("repetitions"))}
    bars = mark("bar", encoding, color=INK, width=_bar_width(values))
    return picture(values, [bars], height=_LOW)


def _bar_width(values: Sequence[Spec]) -> int:
    return max(1, min(12, WIDTH // (2 * len(values))))


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
