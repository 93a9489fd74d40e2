"""Charts of progress, drawn as text for the screen and the terminal, and as pictures for the page."""

from collections.abc import Callable, Sequence
from datetime import date, timedelta
from statistics import fmean
from typing import Any, Literal

import msgspec

from sar_tui.model.language import Language
from sar_tui.model.results_for_people import axis
from sar_tui.reports import charts, progress_words
from sar_tui.reports.charts import (
    ABOVE,
    ACCENT,
    ALARM,
    AREA,
    BAND,
    BELOW,
    EVENT,
    INK,
    POINT,
    RULE,
    SOFT,
    TEN,
    UNKNOWN,
    WIDTH,
    Columns,
    Spec,
    Value,
    channel,
    mark,
    picture,
    round_numbers,
)
from sar_tui.reports.dose import Day
from sar_tui.reports.progress import LineProgress, SessionProgress

_FEWEST_ROWS = 4
_SIDES = {"easier": ABOVE, "harder": BELOW, "": UNKNOWN}
_LEAST_MARGIN = 8
"""Columns for the names of the rows below a chart."""
_HEIGHT, _LOW = 200, 110
"""Heights of pictures in pixels."""
_EDGE = 8
"""Pixels between the ends of the time axis and the first and last session."""
_MOST_QUALITIES = 4


class _Chart(msgspec.Struct, frozen=True, kw_only=True):
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


def _level(line: LineProgress, tr: Language) -> _Chart:
    """Return the level at goal over sessions with its 95 % bands, and the baseline's noise."""
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
    return _Chart(title=unit, values=values, area=area, is_log2=line.axis.is_log2)


def _result(line: LineProgress, tr: Language) -> _Chart:
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
    return _Chart(
        title=f"{label}, {tr('better is up')}" if is_turned else label,
        values=values,
        rule=None if line.goal is None else line.goal * factor,
        is_turned=is_turned,
    )


# --- text
# --------------------------------------------------------------------------------------------------


def level_figure(
    line: LineProgress,
    width: int,
    height: int,
    tr: Language,
    chosen: int | None = None,
    marked: int | None = None,
) -> list[str]:
    """Draw the level at goal over sessions with its 95 % bands, and pain and tiredness on the same
    axis.

    Args:
        line: whose measure is the level at goal.
        width, height: in characters.
        tr: the language.
        chosen: number of the session that has a sign on the axis.
        marked: number of the one that it is compared with, which has another.

    Returns:
        At most ``height`` lines if that is at least 10.
    """
    chart = _level(line, tr)
    low, high = charts.limits(chart.values, chart.area or ())
    low, high = (
        max((place for place in line.places if place <= low), default=low),
        min((place for place in line.places if place >= high), default=high),
    )
    if line.places:
        ticks = [
            (place, f"{level} ({_plain(line, place, tr)})")
            for level, place in enumerate(line.places, 1)
        ]
        heading = f"{tr('level at goal')} ({chart.title})"
    else:
        ticks = [(value, _plain(line, value, tr)) for value in round_numbers(low, high, 5)]
        heading = chart.title
    signs = {BAND: tr("95 % band")}
    if chart.area:
        signs[AREA] = tr("noise and practice")
    return _figure(
        line,
        chart,
        (low, high),
        ticks,
        heading,
        signs,
        (width, height),
        tr,
        chosen=chosen,
        marked=marked,
    )


def result_figure(
    line: LineProgress,
    width: int,
    height: int,
    tr: Language,
    chosen: int | None = None,
    marked: int | None = None,
) -> list[str]:
    """Draw the mean result of each session with one SD to either side, and the goal; otherwise as
    `level_figure`.

    Below are bars for accuracy, and for each measure of how the movements were done.
    """
    chart = _upright(_result(line, tr))
    up = -1 if chart.is_turned else 1
    low, high = charts.limits(chart.values, [] if chart.rule is None else [chart.rule])
    ticks = [(value, tr.figures(f"{up * value:zg}")) for value in round_numbers(low, high, 5)]
    signs = {POINT: tr("mean"), BAND: tr("SD within the session")}
    if chart.rule is not None:
        signs[RULE] = tr("goal")
    return _figure(
        line,
        chart,
        (low, high),
        ticks,
        chart.title,
        signs,
        (width, height),
        tr,
        bars=qualities(line, tr),
        chosen=chosen,
        marked=marked,
    )


def _upright(chart: _Chart) -> _Chart:
    """Return a chart whose greater values are the upper ones."""
    if not chart.is_turned:
        return chart
    values = [
        each if each.value is None else Value(-each.value, -(each.high or 0.0), -(each.low or 0.0))
        for each in chart.values
    ]
    rule = None if chart.rule is None else -chart.rule
    return msgspec.structs.replace(chart, values=values, rule=rule)


def has_levels(line: LineProgress) -> bool:
    """Return True if `level_figure` can draw a line: the level at goal of a session is known."""
    return line.measure == "level" and any(each.at_goal for each in line.sessions)


def has_results(line: LineProgress) -> bool:
    """Return True if `result_figure` can draw a line: an attempt has a result."""
    return any(each.mean is not None for each in line.sessions)


def qualities(line: LineProgress, tr: Language) -> list[tuple[str, list[float | None], str]]:
    """Return the share of right responses, and each measure of how the movements were done: name,
    values, format.
    """
    rows = [
        (
            tr("correct"),
            [each.right / each.trials if each.trials else None for each in line.sessions],
            "{:.0%}",
        )
    ]
    names = dict.fromkeys(name for each in line.sessions for name in each.qualities)
    return rows + [
        (
            progress_words.quality(line, name, tr),
            [each.qualities.get(name) for each in line.sessions],
            progress_words.quality_form(line, name),
        )
        for name in names
    ]


def _figure(
    line: LineProgress,
    chart: _Chart,
    axis: tuple[float, float],
    ticks: Sequence[tuple[float, str]],
    heading: str,
    signs: dict[str, str],
    size: tuple[int, int],
    tr: Language,
    *,
    bars: Sequence[tuple[str, list[float | None], str]] = (),
    chosen: int | None = None,
    marked: int | None = None,
) -> list[str]:
    """Draw a chart with its heading and legend, the dates, and the rows of pain and tiredness."""
    width, height = size
    felt = _felt(line.sessions, tr)
    has_event = [bool(each.events) for each in line.sessions]
    event = [tr("event")] if any(has_event) else []
    names = [*(name for name, *_ in (*felt, *bars)), *event]
    margin = max(
        _LEAST_MARGIN, *(len(label) + 1 for _, label in ticks), *(len(name) + 1 for name in names)
    )
    columns = Columns(len(chart.values), max(10, width - margin))
    below = [
        f"{name:<{margin}}{tr.figures(columns.numbers(numbers, form))}"
        for name, numbers, form in bars
    ]
    below += [f"{name:<{margin}}{columns.figures(numbers)}" for name, numbers in felt]
    below += [f"{name:<{margin}}{columns.signs(has_event, EVENT)}" for name in event]
    notes = (
        [tr("A column holds up to {most} sessions.", most=columns.most)] if columns.most > 1 else []
    )
    if any(TEN in row[margin:] for row in below):
        notes.append(tr("{sign}: 10 of 10.", sign=TEN))
    if notes:
        below.append(" " * margin + " ".join(notes))
    drawn = charts.session_chart(
        chart.values,
        columns,
        axis=axis,
        ticks=ticks,
        rows=max(_FEWEST_ROWS, height - 3 - len(below)),
        margin=margin,
        area=chart.area,
        rule=chart.rule,
        chosen=chosen,
        marked=marked,
    )
    known = {
        ABOVE: tr("all too easy"),
        BELOW: tr("all too hard"),
        UNKNOWN: tr("not known"),
    }
    months = tr("Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec").split()
    used = {value.without for value in chart.values}
    lines = [
        _heading(
            heading, signs | {sign: text for sign, text in known.items() if sign in used}, width
        ),
        *drawn,
    ]
    lines.append(" " * margin + columns.dates([each.began[:10] for each in line.sessions], months))
    return [line.rstrip() for line in (*lines, *below)]


def _felt(sessions: Sequence[SessionProgress], tr: Language) -> list[tuple[str, list[int | None]]]:
    """Return the rows of pain and tiredness, unless nothing was ever said of it."""
    rows = [
        (tr("pain"), [each.pain for each in sessions]),
        (tr("tired"), [each.tiredness for each in sessions]),
    ]
    return [
        (name, numbers) for name, numbers in rows if any(number is not None for number in numbers)
    ]


def _heading(name: str, signs: dict[str, str], width: int) -> str:
    """Return the name of the axis, and at the right as much of the legend as fits."""
    legend = [f"{sign} {text}" for sign, text in signs.items()]
    while legend and len("  ".join([name, *legend])) > width:
        legend.pop()
    return name + "  ".join(legend).rjust(width - len(name))


def _plain(line: LineProgress, difficulty: float, tr: Language) -> str:
    """Return a place on the axis without its unit, and without decimals that are 0."""
    number = line.axis.show(difficulty).removesuffix(line.axis.unit).strip()
    return tr.figures(
        number.removesuffix("0").removesuffix(".") if number.endswith(".0") else number
    )


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
    """Chart the level at goal over sessions, with the 95 % bands, and the baseline's noise in grey.

    A line whose level never changed has no such chart: its results say the same.
    """
    return _picture(line, _level(line, tr)) if line.measure == "level" else None


def result_picture(line: LineProgress, tr: Language) -> Spec | None:
    """Chart the mean result of each session, one SD between its attempts to either side, and the
    goal, dashed.
    """
    return _picture(line, _result(line, tr))


def _picture(line: LineProgress, chart: _Chart) -> Spec | None:
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
    """Chart the worst pain and tiredness of each session, and the adverse events; None if there is
    nothing of them.
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
    if events := [_row(each) for each in line.sessions if each.events]:
        every += events
        sign = {"dx": 6, "dy": 8, "fontSize": 16, "fontWeight": "bold"}
        top = {"y": {"datum": 10, "type": "quantitative", **scale}}
        layers.append(mark("rule", {}, events, color=ALARM))
        layers.append(mark("text", top, events, text=EVENT, color=ALARM, **sign))
    for layer in layers:
        layer["encoding"]["x"] = _x(every, line.sessions)
    return picture(every, layers, height=_LOW) if layers else None


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
