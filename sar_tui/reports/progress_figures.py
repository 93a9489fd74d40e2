"""Progress of a line of sessions as text charts, for the screen and the terminal."""

from collections.abc import Sequence

from sar_tui.model.language import Language
from sar_tui.model.results_for_people import axis
from sar_tui.reports import progress_words, session_chart
from sar_tui.reports.attempts_plot import round_numbers
from sar_tui.reports.progress import LineProgress, SessionProgress
from sar_tui.reports.session_chart import (
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
)

_FEWEST_ROWS = 4
_SIDES = {"easier": ABOVE, "harder": BELOW, "": UNKNOWN}
_LEAST_MARGIN = 8
"""Columns for the names of the rows below a chart."""


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
    at_goal = [each.at_goal for each in line.sessions]
    values = [
        Value(found.difficulty, found.low, found.high)
        if found
        else Value(without=_SIDES[each.side])
        for each, found in zip(line.sessions, at_goal, strict=True)
    ]
    area = None
    if base := line.baseline:
        area = (base.mean - base.mdc95, base.mean + base.mdc95 + base.rise)
    low, high = session_chart.limits(values, area or ())
    low, high = (
        max((place for place in line.places if place <= low), default=low),
        min((place for place in line.places if place >= high), default=high),
    )
    unit = tr(line.axis.unit or line.axis.name)
    if line.places:
        ticks = [
            (place, f"{level} ({_plain(line, place, tr)})")
            for level, place in enumerate(line.places, 1)
        ]
        heading = f"{tr('level at goal')} ({unit})"
    else:
        ticks = [(value, _plain(line, value, tr)) for value in round_numbers(low, high, 5)]
        heading = unit
    signs = {BAND: tr("95 % band")}
    if area:
        signs[AREA] = tr("noise and practice")
    return _figure(
        line,
        values,
        (low, high),
        ticks,
        heading,
        signs,
        (width, height),
        tr,
        area=area,
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
    label, factor = axis(line.metric, tr)
    up = 1
    # the chart is turned, so that a person who gets better never seems to fall
    if line.metric.better == "lower":
        up, label = -1, f"{label}, {tr('better is up')}"
    values = [
        Value(without=UNKNOWN)
        if each.mean is None
        else _around(up * each.mean * factor, (each.sd or 0.0) * factor)
        for each in line.sessions
    ]
    goal = None if line.goal is None else up * line.goal * factor
    low, high = session_chart.limits(values, [] if goal is None else [goal])
    ticks = [(value, tr.figures(f"{up * value:zg}")) for value in round_numbers(low, high, 5)]
    signs = {POINT: tr("mean"), BAND: tr("SD within the session")}
    if goal is not None:
        signs[RULE] = tr("goal")
    size, bars = (width, height), qualities(line, tr)
    return _figure(
        line,
        values,
        (low, high),
        ticks,
        label,
        signs,
        size,
        tr,
        rule=goal,
        bars=bars,
        chosen=chosen,
        marked=marked,
    )


def _around(mean: float, sd: float) -> Value:
    return Value(mean, mean - sd, mean + sd)


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
    values: Sequence[Value],
    axis: tuple[float, float],
    ticks: Sequence[tuple[float, str]],
    heading: str,
    signs: dict[str, str],
    size: tuple[int, int],
    tr: Language,
    *,
    area: tuple[float, float] | None = None,
    rule: float | None = None,
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
    columns = Columns(len(values), max(10, width - margin))
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
    chart = session_chart.session_chart(
        values,
        columns,
        axis=axis,
        ticks=ticks,
        rows=max(_FEWEST_ROWS, height - 3 - len(below)),
        margin=margin,
        area=area,
        rule=rule,
        chosen=chosen,
        marked=marked,
    )
    known = {
        ABOVE: tr("all too easy"),
        BELOW: tr("all too hard"),
        UNKNOWN: tr("not known"),
    }
    months = tr("Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec").split()
    used = {value.without for value in values}
    lines = [
        _heading(
            heading, signs | {sign: text for sign, text in known.items() if sign in used}, width
        ),
        *chart,
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
