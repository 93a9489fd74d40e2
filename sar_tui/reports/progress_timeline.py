"""Sessions over their dates as text, for the screen and the terminal: charts, and below them on one
axis the dose, pain and tiredness.
"""

import math
import textwrap
from collections.abc import Sequence
from itertools import pairwise
from statistics import fmean

import msgspec

from sar_tui.model.language import Language
from sar_tui.progress.change import BASELINE as BASELINE_SESSIONS
from sar_tui.progress.change import FAMILIARISATION
from sar_tui.reports import charts, progress_words
from sar_tui.reports.charts import (
    ABOVE,
    BAND,
    BASELINE,
    BELOW,
    EVENT,
    LIMIT,
    POINT,
    RULE,
    TEN,
    UNKNOWN,
    Columns,
    Run,
    SessionChart,
    Value,
    round_numbers,
)
from sar_tui.reports.progress import LineProgress, SessionProgress
from sar_tui.reports.progress_charts import Chart, level_chart, needs_look, result_chart

_FEWEST_ROWS, _MOST_ROWS = 4, 40
"""Rows of a chart, without its heading and axis."""
_FOR_BANDS = 12
"""Rows of a chart on the screen from which sessions have their bands."""
_LEVELS_PER_HALF_ROW = (
    1 / 12,
    1 / 10,
    1 / 8,
    1 / 6,
    1 / 5,
    1 / 4,
    1 / 3,
    1 / 2,
    2 / 3,
    3 / 4,
    1,
    5 / 4,
    3 / 2,
    2,
    5 / 2,
    5,
    10,
)
"""Distances in a chart of levels, so that its labels are at equal distances."""
_FOR_LEGEND = 20
"""Rows of a timeline from which a legend that does not fit beside the heading has its own row."""
_NAMES_SHARE = 4
"""Names of rows take at most this part of the width."""
_LEAST_MARGIN = 8
"""Columns for the names of the rows below a chart."""


class TextRow(msgspec.Struct, frozen=True):
    """A row of a drawing.

    Args:
        text: its characters.
        figure: name of the figure that it shows, as in `progress_glossary`; empty for an axis.
        name: number of columns at the left that hold the name of the figure.
        looks: columns, from and to, with what needs a look.
        runs: parts of a chart that its characters show.
        is_chosen: True for the row of the chosen session in a list.
    """

    text: str
    figure: str = ""
    name: int = 0
    looks: Sequence[tuple[int, int]] = ()
    runs: Sequence[Run] = ()
    is_chosen: bool = False


class _Figure(msgspec.Struct, frozen=True, kw_only=True):
    """A chart with its scale.

    Attributes:
        name: of the figure.
        chart: whose greater values are the upper ones.
        axis: lowest and highest value.
        ticks: values with their labels.
        levels: number of the task's levels, if they are the values.
        heading: name of the axis.
        baseline: value of the line of the baseline.
        names: of the area and the lines.
        point, band: what these show; without ``point``, it is the heading.
    """

    name: str
    chart: Chart
    axis: tuple[float, float]
    ticks: Sequence[tuple[float, str]]
    levels: int = 0
    heading: str
    baseline: float | None = None
    names: dict[str, str]
    point: str = ""
    band: str


def timeline(
    line: LineProgress,
    width: int,
    height: int,
    tr: Language,
    *,
    shown: str = "level",
    chosen: int | None = None,
    marked: int | None = None,
    is_shaded: bool = False,
) -> list[TextRow]:
    """Draw the sessions of a line over their dates: a chart, and below it on the same axis the
    dose, pain and tiredness, and what needs a look.

    Below mean results are rows for accuracy, and for each measure of how the movements were done.

    Args:
        line: the sessions.
        width, height: in characters.
        tr: the language.
        shown: figure to draw as a chart, ``level`` or ``result``. If the line does not have it, the
            other one is drawn.
        chosen: number of the session that has a sign on the axis.
        marked: number of the one that it is compared with, which has another.
        is_shaded: True if colours are shown behind characters.

    Returns:
        At most ``height`` rows if that is at least 14.
    """
    known = charted(line)
    name = shown if shown in known else next(iter(known), "")
    figure = _FIGURES[name](line, tr) if name else None
    bars = qualities(line, tr) if name == "result" else []
    felt = _felt(line.sessions, tr)
    names = [tr("minutes"), tr("look at"), *(name for name, *_ in bars), *felt]
    longest = max(len(label) for label in (*names, "")) + 1
    labels = [len(label) + 1 for _, label in figure.ticks] if figure else []
    margin = max(_LEAST_MARGIN, *labels, min(longest, width // _NAMES_SHARE))
    columns = Columns(len(line.sessions), max(10, width - margin))
    below = [_dose_row(line, columns, margin, tr), *_felt_rows(line, felt, columns, margin, tr)]
    notes = [
        TextRow(" " * margin + text)
        for text in textwrap.wrap(" ".join(_notes(columns, below, line, tr)), columns.width)
    ]
    free = max(0, height - len(below) - 4 - _FEWEST_ROWS)
    bars_drawn = _quality_rows(bars, columns, margin, tr)
    bars_drawn = bars_drawn[: free if shown == "result" else max(0, free - len(notes))]
    below = [*bars_drawn, *below, *notes[: free - len(bars_drawn)]]
    months = tr(progress_words.MONTHS).split()
    dates = columns.dates([each.began[:10] for each in line.sessions], months)
    below = [TextRow((" " * margin + dates).rstrip()), *below]
    if figure is None:
        return [TextRow(charts.foot(columns, margin, chosen, marked)), *below]
    most, headings = 1 + (height >= _FOR_LEGEND), [TextRow("")]
    for _ in range(most):
        rows = max(_FEWEST_ROWS, min(_MOST_ROWS, height - len(below) - len(headings) - 1))
        has_bands = rows >= _FOR_BANDS or chosen is None
        drawn = _chart(figure, columns, rows, margin, chosen, marked, has_bands, is_shaded)
        rows_needed = len(headings)
        headings = _headings(figure, drawn.unnamed, has_bands, is_shaded, width, most, tr)
        if len(headings) == rows_needed:
            break
    charted_rows = [
        TextRow(text, figure.name, runs=runs)
        for text, runs in zip(drawn.rows, drawn.runs, strict=True)
    ]
    return [*headings, *charted_rows, *below]


def charted(line: LineProgress) -> list[str]:
    """Return the figures of a line that can be drawn as charts: the level at goal of a session is
    known, an attempt has a result.
    """
    has_levels = line.measure == "level" and any(each.at_goal for each in line.sessions)
    has_results = any(each.mean is not None for each in line.sessions)
    return ["level"] * has_levels + ["result"] * has_results


def _level_figure(line: LineProgress, tr: Language) -> _Figure:
    """Return the level at goal over sessions with its 95 % ranges, on an axis of levels; on that of
    difficulty if the levels have no place there.
    """
    chart, count = level_chart(line, tr), len(line.places)
    base = line.baseline.mean if line.baseline else None
    if count < 2:
        low, high = charts.limits(chart.values, chart.area or ())
        ticks = [(value, _plain(line, value, tr)) for value in round_numbers(low, high, 5)]
        heading = chart.title
    else:
        chart = _in_levels(chart, line.places)
        limits = [each for each in chart.area or () if 1 <= each <= count]
        known = [*limits, *(each.value for each in chart.values if each.value is not None)]
        low, high = charts.limits(chart.values, limits)
        low, high = max(low, min(1, *known)), min(high, max(count, *known))
        ticks = [(level, str(level)) for level in range(1, count + 1)]
        heading = tr("level at goal")
    return _Figure(
        name="level",
        chart=chart,
        axis=(low, high),
        ticks=ticks,
        levels=count if count > 1 else 0,
        heading=heading,
        baseline=None if base is None else _level(line.places, base) if count > 1 else base,
        names=_level_names(line, tr),
        band=tr("95 % range"),
    )


def _in_levels(chart: Chart, places: Sequence[float]) -> Chart:
    """Return a chart with levels instead of their difficulty."""

    def level(difficulty: float | None) -> float | None:
        return None if difficulty is None else _level(places, difficulty)

    values = [Value(level(v.value), level(v.low), level(v.high), v.without) for v in chart.values]
    area = (_level(places, chart.area[0]), _level(places, chart.area[1])) if chart.area else None
    return msgspec.structs.replace(chart, values=values, area=area)


def _level(places: Sequence[float], difficulty: float) -> float:
    """Return the place between levels. Beyond them, levels go on at the same distance."""
    ends = list(enumerate(pairwise(places), 1))
    number, (easier, harder) = next((each for each in ends if difficulty <= each[1][1]), ends[-1])
    return number + (difficulty - easier) / (harder - easier)


def _level_names(line: LineProgress, tr: Language) -> dict[str, str]:
    """Return the names of the baseline, with its level at goal, and of the area around it."""
    if line.baseline is None:
        return {}
    mean, count = line.baseline.mean, len(line.places)
    value = _plain(line, mean, tr)
    if count > 1:
        value = tr.figures(f"{max(1, min(count, _level(line.places, mean))):.1f}")
    return {
        BASELINE: tr("baseline {value}", value=value),
        LIMIT: tr("noise and practice"),
    }


def _result_figure(line: LineProgress, tr: Language) -> _Figure:
    """Return the mean result of each session with one SD to either side, and the goal."""
    chart = _upright(result_chart(line, tr))
    up = -1 if chart.is_turned else 1
    low, high = charts.limits(chart.values, [] if chart.rule is None else [chart.rule])
    ticks = [(value, tr.figures(f"{up * value:zg}")) for value in round_numbers(low, high, 5)]
    names, baseline = {}, None
    if chart.rule is not None:
        names[RULE] = tr("goal {goal}", goal=progress_words.goal(line, tr))
    if line.baseline and line.measure == "result":
        value = progress_words.figure(line, line.baseline.mean, tr)
        names[BASELINE] = tr("baseline {value}", value=value)
        probes = [chart.values[number].value for number in _baseline(line)]
        baseline = fmean(value for value in probes if value is not None)
    return _Figure(
        name="result",
        chart=chart,
        axis=(low, high),
        ticks=ticks,
        heading=chart.title,
        baseline=baseline,
        names=names,
        point=tr("mean"),
        band=tr("SD within the session"),
    )


_FIGURES = {"level": _level_figure, "result": _result_figure}


def _upright(chart: Chart) -> Chart:
    """Return a chart whose greater values are the upper ones."""
    if not chart.is_turned:
        return chart
    values = [
        each if each.value is None else Value(-each.value, -(each.high or 0.0), -(each.low or 0.0))
        for each in chart.values
    ]
    rule = None if chart.rule is None else -chart.rule
    return msgspec.structs.replace(chart, values=values, rule=rule)


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


def _chart(
    figure: _Figure,
    columns: Columns,
    rows: int,
    margin: int,
    chosen: int | None,
    marked: int | None,
    has_bands: bool,
    is_shaded: bool,
) -> SessionChart:
    """Draw a chart with its axis."""
    chart, axis, ticks = figure.chart, figure.axis, figure.ticks
    if figure.levels:
        used = {value.without for value in chart.values}
        signs = (used & {ABOVE} != set()) + (used & {BELOW, UNKNOWN} != set())
        axis, ticks = _evenly(figure, rows - signs)
    else:
        axis, ticks = _in_rows(axis, ticks, rows)
    values = chart.values
    if not has_bands:
        values = [Value(each.value, without=each.without) for each in values]
    return charts.session_chart(
        values,
        columns,
        axis=axis,
        ticks=ticks,
        rows=rows,
        margin=margin,
        area=chart.area,
        rule=chart.rule,
        baseline=figure.baseline,
        names=figure.names,
        chosen=chosen,
        marked=marked,
        is_shaded=is_shaded,
    )


def _headings(
    figure: _Figure,
    unnamed: Sequence[str],
    has_bands: bool,
    is_shaded: bool,
    width: int,
    most: int,
    tr: Language,
) -> list[TextRow]:
    """Return the name of the axis, and at the right as much of the legend as fits on so many
    rows: of what has no name in the chart.
    """
    known = {ABOVE: tr("all too easy"), BELOW: tr("all too hard"), UNKNOWN: tr("not known")}
    used = {value.without for value in figure.chart.values}
    signs = [f"{POINT} {figure.point}"] if figure.point else []
    signs += [f"{_LEGEND_SIGNS[is_shaded][sign]} {figure.names[sign]}" for sign in unnamed]
    if has_bands:
        signs.append(tr("bar: {band}", band=figure.band) if is_shaded else f"{BAND} {figure.band}")
    signs += [f"{sign} {text}" for sign, text in known.items() if sign in used]
    rows = [figure.heading]
    for sign in signs:
        if len(longer := f"{rows[-1]}  {sign}") <= width:
            rows[-1] = longer
        elif len(rows) < most:
            rows.append(sign)
    name, size = figure.heading, len(figure.heading)
    first = name + rows[0][size:].strip().rjust(width - size)
    made = [TextRow(first.rstrip(), figure.name, size)]
    made += [TextRow(row.rjust(width), figure.name) for row in rows[1:]]
    return [_with_shade(row) for row in made] if is_shaded else made


_SHADE = "░░"
_LEGEND_SIGNS = (
    {BASELINE: BASELINE, RULE: RULE, LIMIT: LIMIT},
    {BASELINE: LIMIT, RULE: RULE, LIMIT: _SHADE},
)
"""Signs of the legend for the lines and the area, without and with a shade."""


def _with_shade(row: TextRow) -> TextRow:
    """Return a row of a legend whose sign for a shade is one."""
    first = row.text.find(_SHADE)
    if first < 0:
        return row
    last = first + len(_SHADE)
    blank = " " * len(_SHADE)
    text = f"{row.text[:first]}{blank}{row.text[last:]}"
    return msgspec.structs.replace(row, text=text, runs=[Run(first, last, "", "area")])


def _evenly(figure: _Figure, rows: int) -> tuple[tuple[float, float], Sequence[tuple[float, str]]]:
    """Return the axis and the ticks of a chart of levels with so many rows, so that its labels are
    at equal distances, each in the middle of its row: what is above it is drawn above it.
    """
    low, high = math.floor(figure.axis[0]), figure.axis[1]

    def needed(levels: float) -> int:
        """Return the rows that it takes if levels are so far from each other."""
        return math.ceil((math.ceil((high - low) / levels) + 1) / 2)

    distances = _LEVELS_PER_HALF_ROW
    levels = next((each for each in distances if needed(each) <= rows), distances[-1])
    ticks = [tick for tick in figure.ticks if _is_whole((tick[0] - low) / (2 * levels))]
    first = low - levels / 2
    return (first, first + levels * (2 * rows - 1)), ticks


def _in_rows(
    axis: tuple[float, float], ticks: Sequence[tuple[float, str]], rows: int
) -> tuple[tuple[float, float], Sequence[tuple[float, str]]]:
    """Return an axis of so many rows that reaches at least as far, and the ticks, all or every other
    one, each in the middle of its row; both as they are if there is no room.
    """
    ways = ((apart / every, every) for every in (1, 2) for apart in range(1, rows))
    for apart, every in sorted(ways, key=lambda way: (-way[0], way[1])):
        shown = ticks[::every]
        if len(shown) < 2:
            continue
        half = (shown[1][0] - shown[0][0]) / (2 * apart * every)
        below = max(0, math.ceil((shown[0][0] - axis[0]) / (2 * half) - 0.5))
        first = shown[0][0] - (2 * below + 0.5) * half
        last = first + (2 * rows - 1) * half
        if last + half / 2 >= axis[1]:
            return (first, last), shown
    return axis, ticks


def _is_whole(number: float) -> bool:
    return math.isclose(number, round(number), abs_tol=1e-6)


def _baseline(line: LineProgress) -> Sequence[int]:
    """Return the numbers of the sessions of the baseline; none if there is no baseline."""
    known = [number for number, each in enumerate(line.sessions) if each.value is not None]
    probes = known[FAMILIARISATION : FAMILIARISATION + BASELINE_SESSIONS]
    return probes if line.baseline else []


def _quality_rows(
    bars: Sequence[tuple[str, list[float | None], str]], columns: Columns, margin: int, tr: Language
) -> list[TextRow]:
    return [
        TextRow(
            f"{_cut(name, margin):<{margin}}{tr.figures(shown)}".rstrip(),
            "quality" if place else "correct",
            min(len(name), margin - 1),
        )
        for place, (name, numbers, form) in enumerate(bars)
        for shown in [columns.numbers(numbers, form) or columns.bars(numbers)]
    ]


def _cut(name: str, margin: int) -> str:
    """Return a name that leaves a blank of a margin."""
    return name if len(name) < margin else f"{name[: margin - 2]}…"


def _dose_row(line: LineProgress, columns: Columns, margin: int, tr: Language) -> TextRow:
    """Return the minutes on task of each session; where there is no room, as bars."""
    minutes, name = [each.time_on_task_s / 60 for each in line.sessions], tr("minutes")
    forms = (_minutes_form(minutes), "{:.0f}")
    shown = next(filter(None, (columns.numbers(minutes, form) for form in forms)), "")
    shown = shown or columns.heights(minutes)
    return TextRow(f"{name:<{margin}}{tr.figures(shown)}".rstrip(), "dose", len(name))


def _minutes_form(minutes: Sequence[float]) -> str:
    return "{:.0f}" if max(minutes) >= 10 else "{:.1f}"


def _felt(
    sessions: Sequence[SessionProgress], tr: Language
) -> dict[str, tuple[str, list[int | None]]]:
    """Return the ratings of pain and tiredness by name, with the figure; none if nothing was ever
    said of it.
    """
    rows = {
        tr("pain"): ("pain", [each.pain for each in sessions]),
        tr("tired"): ("tired", [each.tiredness for each in sessions]),
    }
    return {
        name: (figure, numbers)
        for name, (figure, numbers) in rows.items()
        if any(number is not None for number in numbers)
    }


def _felt_rows(
    line: LineProgress,
    felt: dict[str, tuple[str, list[int | None]]],
    columns: Columns,
    margin: int,
    tr: Language,
) -> list[TextRow]:
    """Return the rows of pain and tiredness, and below them a sign for each session that needs a
    look.
    """
    too_much = [each.felt.is_reason_to_stop for each in line.sessions]
    rows = [
        TextRow(
            f"{name:<{margin}}{columns.figures(numbers)}",
            figure,
            len(name),
            _spans(columns, too_much, margin) if figure == "pain" else (),
        )
        for name, (figure, numbers) in felt.items()
    ]
    looks = [needs_look(each) for each in line.sessions]
    if any(looks):
        name = tr("look at")
        text = f"{name:<{margin}}{columns.signs(looks, EVENT)}"
        rows.append(TextRow(text, "look", len(name), _spans(columns, looks, margin)))
    return rows


def _spans(columns: Columns, marked: Sequence[bool], margin: int) -> list[tuple[int, int]]:
    """Return the columns of the numbers of marked sessions."""
    wide = 2 if columns.step > 2 else 1
    return [
        (margin + column, margin + column + wide)
        for column, sessions in columns.groups()
        if any(marked[session] for session in sessions)
    ]


def _notes(
    columns: Columns, below: Sequence[TextRow], line: LineProgress, tr: Language
) -> list[str]:
    """Return what the reader must know of the rows: sessions that share a column, the scale of the
    bars, and the sign for 10.
    """
    notes = []
    if columns.most > 1:
        notes.append(tr("A column holds up to {most} sessions.", most=columns.most))
    (dose,) = (row.text[row.name :] for row in below if row.figure == "dose")
    longest = max(each.time_on_task_s for each in line.sessions) / 60
    if longest > 0 and not any(character.isdigit() for character in dose):
        minutes = _minutes_form([longest]).format(longest)
        notes.append(tr("The longest session: {minutes} min.", minutes=minutes))
    if any(TEN in row.text[row.name :] for row in below if row.figure in ("pain", "tired")):
        notes.append(tr("{sign}: 10 of 10.", sign=TEN))
    return notes


def _plain(line: LineProgress, difficulty: float, tr: Language) -> str:
    """Return a place on the axis without its unit, and without decimals that are 0."""
    number = line.axis.show(difficulty).removesuffix(line.axis.unit).strip()
    return tr.figures(
        number.removesuffix("0").removesuffix(".") if number.endswith(".0") else number
    )
