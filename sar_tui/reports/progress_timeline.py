"""Sessions over their dates as text, for the screen and the terminal: charts, and below them on one
axis the dose, pain and tiredness.
"""

import textwrap
from collections.abc import Sequence

import msgspec

from sar_tui.model.language import Language
from sar_tui.reports import charts, progress_words
from sar_tui.reports.charts import (
    ABOVE,
    AREA,
    BAND,
    BELOW,
    EVENT,
    POINT,
    RULE,
    TEN,
    UNKNOWN,
    Columns,
    Value,
    round_numbers,
)
from sar_tui.reports.progress import LineProgress, SessionProgress
from sar_tui.reports.progress_charts import Chart, level_chart, needs_look, result_chart

_FEWEST_ROWS, _MOST_ROWS = 4, 20
"""Rows of a chart, without its heading and axis."""
_TALL_DOSE = (22, 34)
"""Rows of a timeline from which the bars of the dose have one row more."""
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
    """

    text: str
    figure: str = ""
    name: int = 0
    looks: Sequence[tuple[int, int]] = ()


class _Figure(msgspec.Struct, frozen=True, kw_only=True):
    """A chart with its scale.

    Attributes:
        name: of the figure.
        chart: whose greater values are the upper ones.
        axis: lowest and highest value.
        ticks: values with their labels.
        heading: name of the axis.
        signs: legend.
    """

    name: str
    chart: Chart
    axis: tuple[float, float]
    ticks: Sequence[tuple[float, str]]
    heading: str
    signs: dict[str, str]


def timeline(
    line: LineProgress,
    width: int,
    height: int,
    tr: Language,
    *,
    shown: Sequence[str] = (),
    chosen: int | None = None,
    marked: int | None = None,
) -> list[TextRow]:
    """Draw the sessions of a line over their dates: charts, and below them on the same axis the
    dose, pain and tiredness, and what needs a look.

    Below mean results are bars for accuracy, and for each measure of how the movements were done.

    Args:
        line: the sessions.
        width, height: in characters.
        tr: the language.
        shown: figures to draw as charts, ``level`` and ``result``; those that the line does not
            have are left out. Empty: the level at goal, or results where no level is known.
        chosen: number of the session that has a sign on the axis.
        marked: number of the one that it is compared with, which has another.

    Returns:
        At most ``height`` rows if that is at least 14.
    """
    known = charted(line)
    drawn = [_FIGURES[name](line, tr) for name in known if name in shown]
    drawn = drawn or [_FIGURES[name](line, tr) for name in known[:1]]
    has_results = any(figure.name == "result" for figure in drawn)
    bars = qualities(line, tr) if has_results else []
    felt = _felt(line.sessions, tr)
    names = [tr("minutes"), tr("look at"), *(name for name, *_ in bars), *felt]
    longest = max(len(label) for label in (*names, "")) + 1
    labels = [len(label) + 1 for figure in drawn for _, label in figure.ticks]
    margin = max(_LEAST_MARGIN, *labels, min(longest, width // _NAMES_SHARE))
    columns = Columns(len(line.sessions), max(10, width - margin))
    below = [
        *_dose_rows(line, columns, margin, 1 + sum(height >= tall for tall in _TALL_DOSE), tr),
        *_felt_rows(line, felt, columns, margin, tr),
    ]
    notes = [
        TextRow(" " * margin + text)
        for text in textwrap.wrap(" ".join(_notes(columns, below, line, tr)), columns.width)
    ]
    free = max(0, height - len(below) - 1 - (3 + _FEWEST_ROWS) * len(drawn))
    bars_drawn = _quality_rows(bars, columns, margin, tr)
    bars_drawn = bars_drawn[: free if "result" in shown else max(0, free - len(notes))]
    below = [*bars_drawn, *below, *notes[: free - len(bars_drawn)]]
    months = tr("Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec").split()
    dates = columns.dates([each.began[:10] for each in line.sessions], months)
    room = height - len(below) - 3 * max(1, len(drawn))
    rows = max(_FEWEST_ROWS, min(_MOST_ROWS, room // max(1, len(drawn))))
    found: list[TextRow] = []
    for figure in drawn:
        found += [TextRow("")] if found else []
        found += _chart_rows(figure, columns, rows, margin, width, tr, chosen, marked)
    if not drawn:
        found.append(TextRow(charts.foot(columns, margin, chosen, marked)))
    return [*found, TextRow((" " * margin + dates).rstrip()), *below]


def charted(line: LineProgress) -> list[str]:
    """Return the figures of a line that can be drawn as charts: the level at goal of a session is
    known, an attempt has a result.
    """
    has_levels = line.measure == "level" and any(each.at_goal for each in line.sessions)
    has_results = any(each.mean is not None for each in line.sessions)
    return ["level"] * has_levels + ["result"] * has_results


def _level_figure(line: LineProgress, tr: Language) -> _Figure:
    """Return the level at goal over sessions with its 95 % bands, on an axis of levels."""
    chart = level_chart(line, tr)
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
    return _Figure(
        name="level", chart=chart, axis=(low, high), ticks=ticks, heading=heading, signs=signs
    )


def _result_figure(line: LineProgress, tr: Language) -> _Figure:
    """Return the mean result of each session with one SD to either side, and the goal."""
    chart = _upright(result_chart(line, tr))
    up = -1 if chart.is_turned else 1
    low, high = charts.limits(chart.values, [] if chart.rule is None else [chart.rule])
    ticks = [(value, tr.figures(f"{up * value:zg}")) for value in round_numbers(low, high, 5)]
    signs = {POINT: tr("mean"), BAND: tr("SD within the session")}
    if chart.rule is not None:
        signs[RULE] = tr("goal")
    return _Figure(
        name="result", chart=chart, axis=(low, high), ticks=ticks, heading=chart.title, signs=signs
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


def _chart_rows(
    figure: _Figure,
    columns: Columns,
    rows: int,
    margin: int,
    width: int,
    tr: Language,
    chosen: int | None,
    marked: int | None,
) -> list[TextRow]:
    """Draw a chart with its heading and legend."""
    chart = figure.chart
    drawn = charts.session_chart(
        chart.values,
        columns,
        axis=figure.axis,
        ticks=figure.ticks,
        rows=rows,
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
    used = {value.without for value in chart.values}
    legend = figure.signs | {sign: text for sign, text in known.items() if sign in used}
    heading = _heading(figure.heading, legend, width)
    return [
        TextRow(heading.rstrip(), figure.name, len(figure.heading)),
        *(TextRow(text.rstrip(), figure.name) for text in drawn),
    ]


def _quality_rows(
    bars: Sequence[tuple[str, list[float | None], str]], columns: Columns, margin: int, tr: Language
) -> list[TextRow]:
    return [
        TextRow(
            f"{_cut(name, margin):<{margin}}{tr.figures(columns.numbers(numbers, form))}".rstrip(),
            "quality" if place else "correct",
            min(len(name), margin - 1),
        )
        for place, (name, numbers, form) in enumerate(bars)
    ]


def _cut(name: str, margin: int) -> str:
    """Return a name that leaves a blank of a margin."""
    return name if len(name) < margin else f"{name[: margin - 2]}…"


def _dose_rows(
    line: LineProgress, columns: Columns, margin: int, rows: int, tr: Language
) -> list[TextRow]:
    """Return the minutes on task of each session as bars."""
    minutes = [each.time_on_task_s / 60 for each in line.sessions]
    drawn = columns.heights(minutes, rows, _minutes_form(minutes))
    name = tr("minutes")
    return [
        TextRow(
            f"{name if is_foot else '':<{margin}}{tr.figures(text)}".rstrip(),
            "dose",
            len(name) if is_foot else 0,
        )
        for text, is_foot in zip(drawn, [False] * (rows - 1) + [True], strict=True)
    ]


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
    feet = [row.text[row.name :] for row in below if row.figure == "dose"]
    longest = max(each.time_on_task_s for each in line.sessions) / 60
    if longest > 0 and not any(character.isdigit() for character in feet[-1]):
        minutes = _minutes_form([longest]).format(longest)
        notes.append(tr("The longest session: {minutes} min.", minutes=minutes))
    if any(TEN in row.text[row.name :] for row in below if row.figure in ("pain", "tired")):
        notes.append(tr("{sign}: 10 of 10.", sign=TEN))
    return notes


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
