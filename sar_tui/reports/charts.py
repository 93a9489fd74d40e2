"""Charts, drawn as text or as a picture: attempts of a session, sessions over time, curves."""

import math
import statistics
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from datetime import date
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import msgspec

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.model.language import ENGLISH, Language

if TYPE_CHECKING:
    from sar_tui.model.messages import Outcome
    from sar_tui.model.trial_types import Metric


ResultName = Literal["reached", "missed", "inaccurate", "no result", "no goal"]
MARKERS: dict[str, str] = {
    "reached": "●",
    "missed": "○",
    "inaccurate": "◇",
    "no result": "×",
    "no goal": "•",
}


def result_name(
    outcome: "Outcome", value: float | None, goal: float | None, metric: "Metric"
) -> ResultName:
    """Return the result of an attempt.

    A failure whose value is better than the goal is ``inaccurate``: too few of its responses were
    right.

    Args:
        outcome: of the attempt.
        value: its metric; None if no response could be timed.
        goal: of the attempt; None if it had none, and in data of early versions.
        metric: of the task.
    """
    if outcome == "none" and (value is not None or metric.is_none):
        return "no goal"
    if value is None:
        return "no result"
    if outcome == "success":
        return "reached"
    return "inaccurate" if goal is not None and metric.is_better(value, goal) else "missed"


GOAL = "╌"
BARS = "▁▂▃▄▅▆▇█"
"""Characters of bars, by height."""
_COLORS: dict[str, str] = {
    "reached": "green",
    "missed": "default",
    "inaccurate": "default",
    "no result": "default",
    "no goal": "cyan",
}

_MARGIN = 7
"""Least columns for the numbers of the left axis and the names of the lower ones."""
_SMALLEST = (30, 7)
"""Least width and height."""
_FOR_BARS, _FOR_TALL_BARS = 9, 16
"""Height from which levels have bars beside their numbers, and bars of two lines."""
_FOR_LEGEND = 9
"""Height from which a legend that does not fit beside the heading has a line of its own."""


def attempts_figure(
    levels: Sequence[int],
    metrics: Sequence[float | None],
    *,
    metric: str,
    goals: Sequence[float | None],
    width: int,
    height: int,
    color: bool = True,
    results: Sequence[str] = (),
    markers: Mapping[str, str] = MARKERS,
    beside: Sequence[float | None] = (),
    has_legend: bool = True,
    tr: Language = ENGLISH,
) -> str:
    """Draw the metric over attempts, with the goal as a line, and the levels below.

    Attempts without a result have their markers below the axis, where no value is read from them.

    Args:
        levels: of each attempt.
        metrics: of each attempt; None without a result.
        metric: name and unit, the heading of the left axis.
        goals: of each attempt; they may differ by level; None for an attempt without one.
        width, height: in characters, including heading and axes.
        color: use ANSI colours.
        results: of each attempt; if empty, all that have a metric have the same marker. One
            without a metric has ``no result``.
        markers: of these results; those of the goal, unless they are others.
        beside: metrics and goals of a figure shown beside this one, so that both have the same
            axes.
        has_legend: False if the legend is shown elsewhere (`legend`).
        tr: the language of the other words.

    Returns:
        ``height`` lines of ``width`` characters, a plot of at least 30 by 7.
    """
    if not levels:
        return tr("There are no attempts to show yet.")
    import plotext

    width, height = max(width, _SMALLEST[0]), max(height, _SMALLEST[1])
    names = results or ["no result" if value is None else "reached" for value in metrics]
    has_empty = None in (*metrics, *beside)
    bar_lines = (height >= _FOR_BARS) + (height >= _FOR_TALL_BARS)
    explained = legend(
        goals, results or [name for name in names if name == "no result"], tr, markers
    )
    heading = _heading(
        metric, explained if has_legend else [], width, may_have_two=height >= _FOR_LEGEND
    )
    attempt, level = tr("attempt"), tr("level")
    margin = max(_MARGIN, len(attempt), len(level))
    plotext.clear_figure()
    try:
        size = width, height - len(heading) - has_empty - 1 - bar_lines
        body = _body(plotext, metrics, goals, size, margin, names, markers, beside, tr)
    finally:
        plotext.clear_figure()
    lines = [line.rstrip() for line in body.rstrip("\n").split("\n")]
    lines[-1] = attempt.ljust(margin) + lines[-1][margin:]
    columns = _Columns.of_axis(plotext.uncolorize(lines[-2]), len(levels))
    below = []
    if has_empty:
        marker = plotext.colorize(MARKERS["no result"], _COLORS["no result"], "bold")
        below.append(columns.line({n: marker for n, value in enumerate(metrics) if value is None}))
    below.append(level.ljust(margin) + columns.numbers(levels)[margin:])
    below += [plotext.colorize(line, "blue") for line in columns.bars(levels, bar_lines)]
    text = "\n".join([*heading, *lines[:-1], *below, lines[-1]])
    return text if color else plotext.uncolorize(text)


def _body(
    plt: Any,
    metrics: Sequence[float | None],
    goals: Sequence[float | None],
    size: tuple[int, int],
    margin: int,
    results: Sequence[str],
    markers: Mapping[str, str],
    beside: Sequence[float | None],
    tr: Language,
) -> str:
    """Draw the axes and the data, on a canvas two lines lower than the height."""
    count, rows = len(metrics), size[1] - 2
    attempts = range(1, count + 1)
    plt.limit_size(False, False)
    plt.theme("clear")
    plt.plotsize(*size)
    plt.xaxes(True, False)
    plt.xlim(0.5, count + 0.5)
    values = [value for value in (*metrics, *goals, *beside) if value is not None]
    low, high = _limits(values)
    plt.ylim(low, high, yside="left")
    if not values:  # plotext draws no axes without data
        plt.scatter([1], [low], marker=" ")
    for goal, alike in groupby(enumerate(goals, start=1), key=lambda item: item[1]):
        same = [attempt for attempt, _ in alike]
        if goal is None:
            continue
        plt.plot([same[0] - 0.5, same[-1] + 0.5], [goal] * 2, marker=GOAL)
    for run in _runs(metrics):
        plt.plot([attempt for attempt, _ in run], [value for _, value in run], marker="braille")
    for name, marker in markers.items():
        found = [
            attempt
            for attempt, its in zip(attempts, results, strict=True)
            if its == name != "no result"
        ]
        if found:
            plt.scatter(
                found,
                [metrics[attempt - 1] for attempt in found],
                marker=marker,
                color=_COLORS.get(name, "blue"),
                style="bold",
            )

    ticks = _possible(round_numbers(low, high, max(2, rows // 2)), values)
    plt.yticks(ticks, [tr.figures(f"{tick:g}").rjust(margin) for tick in ticks], yside="left")
    room = count * (len(str(count)) + 1) / (size[0] - margin - 6)
    every = next(
        step
        for power in (1, 10, 100, 1000, 10_000)
        for m in (1, 2, 5)
        if (step := m * power) >= room
    )
    labelled = [
        attempt for attempt in attempts if every == 1 or attempt == 1 or attempt % every == 0
    ]
    plt.xticks(labelled, [str(attempt) for attempt in labelled])
    return str(plt.build())


class _Columns(NamedTuple):
    """The columns of the screen that attempts are drawn in."""

    first: int
    last: int
    attempts: int

    @classmethod
    def of_axis(cls, axis: str, count: int) -> "_Columns":
        """Return the columns between the ends of an axis that plotext drew."""
        return cls(axis.index("└") + 1, axis.index("┘") - 1, count)

    def column(self, attempt: int) -> int:
        """Return the column in which plotext draws the value of an attempt (0, 1, …)."""
        return self.first + math.floor(
            0.5 + round((self.last - self.first) * (attempt + 0.5) / self.attempts, 8)
        )

    def line(self, characters: dict[int, str]) -> str:
        """Return a line with a character in the columns of some attempts."""
        line = [" "] * (self.last + 1)
        for attempt, character in characters.items():
            line[self.column(attempt)] = character
        return "".join(line).rstrip()

    def numbers(self, levels: Sequence[int]) -> str:
        """Return a line with the level of each attempt if there is room, else where it changes."""
        line = [" "] * (self.last + 1)
        wide = len(str(max(levels))) + 1
        changes = [n for n, level in enumerate(levels) if n == 0 or level != levels[n - 1]]
        free_from = 0
        for attempt in (
            range(self.attempts) if self.attempts * wide <= self.last - self.first else changes
        ):
            text, column = str(levels[attempt]), self.column(attempt)
            if free_from <= column <= self.last + 1 - len(text):
                line[column : column + len(text)] = text
                free_from = column + wide
        return "".join(line).rstrip()

    def bars(self, levels: Sequence[int], lines: int) -> list[str]:
        """Return lines of bars, as high as the levels."""
        highest, steps, width = max(*levels, 1), len(BARS), self.last - self.first + 1
        shown = [max(levels[column * self.attempts // width], 0) for column in range(width)]
        heights = [max(1, round(level / highest * steps * lines)) for level in shown]
        return [
            " " * self.first + "".join(_part_of_bar(height - below * steps) for height in heights)
            for below in reversed(range(lines))
        ]


def _part_of_bar(height: int) -> str:
    """Return the character of one line of a bar; a blank above its end."""
    return BARS[min(height, len(BARS)) - 1] if height > 0 else " "


def legend(
    goals: Sequence[float | None],
    results: Collection[str],
    tr: Language = ENGLISH,
    markers: Mapping[str, str] = MARKERS,
) -> list[str]:
    """Return the parts of the legend: the markers of these results, and the goal, with its value if
    it is one.
    """
    known = {goal for goal in goals if goal is not None}
    value = tr.figures(f" {goals[0]:g}") if len(known) == 1 and len(set(goals)) == 1 else ""
    return [
        *(
            f"{marker} {tr(name)}"
            for name, marker in {**MARKERS, **markers}.items()
            if name in results
        ),
        *([f"{GOAL} {tr('goal')}{value}"] if known else []),
    ]


def _heading(metric: str, explained: Sequence[str], width: int, *, may_have_two: bool) -> list[str]:
    """Return the name of the axis, and as much of the legend as fits: at its right, else on a line
    of its own.
    """
    left, parts = metric[:width], list(explained)
    if may_have_two and len("  ".join([left, *parts])) > width:
        return [left, *_heading("", parts, width, may_have_two=False)]
    while parts and len("  ".join([left, *parts] if left else parts)) > width:
        parts.pop()
    return [left + "  ".join(parts).rjust(width - len(left))]


def _runs(metrics: Sequence[float | None]) -> Iterator[list[tuple[int, float]]]:
    """Yield runs of consecutive attempts with a result, to be joined by a line."""
    for has_result, run in groupby(
        enumerate(metrics, start=1), key=lambda item: item[1] is not None
    ):
        if has_result:
            yield [(attempt, value) for attempt, value in run if value is not None]


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """Return the axis limits, with a margin around the values."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return low - room, high + room


def _possible(ticks: Sequence[float], values: Sequence[float]) -> list[float]:
    """Return the ticks that a value may have: whole ones if all values are, and none below zero if
    no value is.
    """
    is_whole, is_positive = (
        all(value == int(value) for value in values),
        min(values, default=0.0) >= 0,
    )
    return [
        tick
        for tick in ticks
        if (tick == int(tick) or not is_whole) and (tick >= 0 or not is_positive)
    ]


def round_numbers(low: float, high: float, most: int) -> list[float]:
    """Return at most ``most`` round numbers between two bounds, and at least one, in round
    steps.
    """
    power = 10 ** math.floor(math.log10((high - low) / most))
    step = next(s for m in (1, 2, 5, 10, 20) if (high - low) / (s := m * power) <= most)
    # it leaps over both bounds: the next smaller of 1, 2 and 5
    if math.ceil(low / step) > math.floor(high / step):
        step /= 2.5 if f"{step:e}".startswith("5") else 2
    first = math.ceil(low / step)
    return [round(n * step, 10) for n in range(first, math.floor(high / step) + 1)][:most]


POINT, BAND, RULE, CHOSEN = "■", "│", "╌", "▲"
HALVES = "▄▀"
"""A value in the lower and in the upper half of a row."""
BAND_HALVES = "╷╵"
"""The end of a band in the lower and in the upper half of a row."""
LIMIT, EDGE = "─", "▁"
"""A line between the halves of a row, so that each value is above it or below it, and one between
two rows.
"""
BASELINE = "━"
"""The mean of the sessions of the baseline, where nothing is shaded."""
TEN = "X"
"""Stands for 10 where there is room for one character."""
ABOVE, BELOW, UNKNOWN = "^", "v", "?"
"""Stand for a session without a value: it lies above or below what could be measured, or is not
known.
"""
MARKED = "◆"
"""Stands for the session that another one is compared with."""
EVENT = "!"
"""Stands for an adverse event."""
_WIDEST = 10
"""Most columns that a session has, so that a few sessions stay together."""
_GAP = 2
"""Least number of blanks between two dates."""
_LONG_DAYS = 300
"""From this time on, dates below the axis have years instead of days."""
_ROOM = 1.2
"""Room beyond the outermost values, in bands: one session with a very wide band must not flatten
all others.
"""


_ROUNDING = 1e-9
"""Share of a value below which a difference is an error of rounding."""


class Value(msgspec.Struct, frozen=True):
    """A session's value and its band, or the character that stands for one without a value."""

    value: float | None = None
    low: float | None = None
    high: float | None = None
    without: str = ""


class Columns(msgspec.Struct, frozen=True):
    """Columns of sessions in a chart; a column holds several sessions if there are more sessions
    than columns.
    """

    count: int
    width: int

    @property
    def step(self) -> float:
        """Columns from one session to the next."""
        return min(_WIDEST, self.width / max(1, self.count))

    @property
    def most(self) -> int:
        """Largest number of sessions in a column."""
        return max(1, math.ceil(1 / self.step))

    def column(self, session: int) -> int:
        """Return the column of a session (0, 1, …)."""
        return min(self.width - 1, int((session + 0.5) * self.step))

    def groups(self) -> Iterator[tuple[int, range]]:
        """Yield each column that has sessions, with them."""
        first = 0
        for session in range(1, self.count + 1):
            if session == self.count or self.column(session) != self.column(first):
                yield self.column(first), range(first, session)
                first = session

    def figures(self, values: Sequence[int | None]) -> str:
        """Return a row with the greatest number of each column, or ``·``; `TEN` is 10 where there
        is no room.
        """
        line = [" "] * self.width
        for column, sessions in self.groups():
            known = [value for session in sessions if (value := values[session]) is not None]
            text = str(max(known)) if known else "·"
            if len(text) > 1 and self.step < len(text) + 1:
                text = TEN
            line[column : column + len(text)] = text
        return "".join(line).rstrip()

    def signs(self, marked: Sequence[bool], sign: str) -> str:
        """Return a row with a sign in each column that has a marked session."""
        line = [" "] * self.width
        for column, sessions in self.groups():
            if any(marked[session] for session in sessions):
                line[column] = sign
        return "".join(line).rstrip()

    def numbers(self, values: Sequence[float | None], form: str) -> str:
        """Return a row of numbers, formatted by ``form``; empty if they have no room."""
        texts = [form.format(value) if value is not None else "·" for value in values]
        if max(map(len, texts), default=0) >= math.floor(self.step):
            return ""
        line = [" "] * self.width
        for session, text in enumerate(texts):
            begin = min(self.column(session), self.width - len(text))
            line[begin : begin + len(text)] = text
        return "".join(line).rstrip()

    def bars(self, values: Sequence[float | None]) -> str:
        """Return a row of bars between the least and the greatest value; ``·`` where there is
        none.
        """
        line = [" "] * self.width
        means = [
            (column, _mean([values[session] for session in sessions]))
            for column, sessions in self.groups()
        ]
        known = [mean for _, mean in means if mean is not None]
        for column, mean in means:
            line[column] = (
                "·" if mean is None else BARS[_part(mean, min(known), max(known), len(BARS) - 1)]
            )
        return "".join(line).rstrip()

    def heights(self, values: Sequence[float]) -> str:
        """Return a row of bars from zero to the greatest value; ``·`` where it is zero."""
        means = {
            column: statistics.fmean([values[session] for session in sessions])
            for column, sessions in self.groups()
        }
        highest = max(means.values(), default=0.0) or 1.0
        line = [" "] * self.width
        for column, mean in means.items():
            eighths = math.ceil(mean / highest * len(BARS) - _ROUNDING)
            line[column] = _part_of_bar(eighths) if mean > 0 else "·"
        return "".join(line).rstrip()

    def dates(self, days: Sequence[str], months: Sequence[str]) -> str:
        """Return a row of dates as far as there is room; the last one is always there.

        Args:
            days: of each session ("2026-03-02"); at least one.
            months: short names of the months.
        """
        is_long = _days(days[0], days[-1]) > _LONG_DAYS
        texts = [
            day[:7] if is_long else f"{int(day[8:])} {months[int(day[5:7]) - 1]}" for day in days
        ]
        line = [" "] * self.width
        last = min(self.column(len(days) - 1), self.width - len(texts[-1]))
        line[last:] = texts[-1]
        free, before = 0, texts[-1]
        for column, sessions in self.groups():
            shown = texts[sessions[0]]
            if free <= column <= last - len(shown) - _GAP and shown != before:
                line[column : column + len(shown)] = shown
                free, before = column + len(shown) + _GAP, shown
        return "".join(line)


def limits(values: Sequence[Value], more: Sequence[float] = ()) -> tuple[float, float]:
    """Return the lowest and the highest value of an axis, with room for most of the bands.

    Args:
        values: at least one has a value.
        more: values that must be on the axis as well.
    """
    known = [*(each.value for each in values if each.value is not None), *more]
    halves = [
        (each.high - each.low) / 2
        for each in values
        if each.high is not None and each.low is not None
    ]
    room = _ROOM * statistics.median(halves) if halves else 0.0
    low, high = min(known) - room, max(known) + room
    if low == high:
        room = 0.1 * abs(high) or 1.0
        return low - room, high + room
    return low, high


Role = Literal["", "point", "band", "line", "label", "area", "ground"]
"""Part of a chart that a character belongs to; ``ground`` is what shows where nothing is."""


class Run(NamedTuple):
    """Characters of a row that look alike: the first column and the one after the last, and the
    parts of the chart that they show and have behind them.
    """

    first: int
    last: int
    shown: Role
    behind: Role = ""


class SessionChart(NamedTuple):
    """A chart of sessions: its rows, the parts that their characters show, and the signs whose
    names have no room in it.
    """

    rows: list[str]
    runs: list[list[Run]]
    unnamed: list[str]


def session_chart(
    values: Sequence[Value],
    columns: Columns,
    *,
    axis: tuple[float, float],
    ticks: Sequence[tuple[float, str]],
    rows: int,
    margin: int,
    area: tuple[float, float] | None = None,
    rule: float | None = None,
    baseline: float | None = None,
    names: Mapping[str, str] | None = None,
    chosen: int | None = None,
    marked: int | None = None,
    is_shaded: bool = False,
) -> SessionChart:
    """Draw values over sessions. Those without a value have a row of their own above or below the
    others.

    Args:
        values: of each session; of several in a column, the means are drawn.
        columns: where the sessions are.
        axis: lowest and highest value.
        ticks: values with their labels.
        rows: number of rows above the axis.
        margin: columns for the labels and the axis.
        area: values with a thin line at each that is on the axis, or a shade between them. Each
            value is on its side of them, if need be half a row further up or down.
        rule: value at which a dashed line is drawn.
        baseline: value at which another line is drawn.
        names: of the area (`LIMIT`), the rule and the baseline, which stand at them if there is
            room.
        chosen, marked: sessions with a sign of their own on the axis.
        is_shaded: True if colours are shown behind characters. The area is a shade then, and a band
            an unbroken stroke with the point in it.

    Returns:
        ``rows`` + 1 rows.
    """
    low, high = axis
    above, below = (_signs(values, columns, signs) for signs in (ABOVE, BELOW + UNKNOWN))
    rows -= bool(above) + bool(below)

    highest = 2 * rows - 1
    below_area, above_area = _borders(area, axis, highest, is_shaded=is_shaded)

    def step(value: float) -> int:
        """Return the half row of a value, counted from below."""
        found = _part(value, low, high, highest)
        if area and below_area is not None:
            is_in = value >= area[0] - _ROUNDING * abs(area[0])
            found = max(found, below_area) if is_in else min(found, below_area - 1)
        if area and above_area is not None:
            is_in = value <= area[1] + _ROUNDING * abs(area[1])
            found = min(found, above_area - 1) if is_in else max(found, above_area)
        return found

    canvas = _Canvas(rows, columns.width, is_shaded)
    named: dict[str, list[int]] = {LIMIT: []}
    if area and area[0] <= high and area[1] >= low:
        named[LIMIT] = canvas.area(below_area, above_area)
    for sign, value in ((BASELINE, baseline), (RULE, rule)):
        if value is not None and low <= value <= high:
            line = step(value) // 2
            if is_shaded and sign == BASELINE:
                line, is_between = _line(value, axis, highest)
                sign_drawn = EDGE if is_between else LIMIT
            else:
                sign_drawn = sign
            canvas.rule(line, sign_drawn)
            named[LIMIT] = [row for row in named[LIMIT] if row != line]
            named[sign] = [line]
    for column, sessions in columns.groups():
        canvas.draw([values[session] for session in sessions], column, step)
    wanted = names or {}
    unnamed = [
        sign
        for sign in (BASELINE, RULE, LIMIT)
        if named.get(sign) and sign in wanted and not canvas.name(wanted[sign], named[sign])
    ]
    labels = _labels(ticks, axis, highest)
    lines: list[str] = []
    runs: list[list[Run]] = []
    for number in reversed(range(rows)):
        axis_line = "┤" if number in labels else "│"
        label = f"{labels.get(number, ''):>{margin - 1}}"
        text, own = canvas.row(number, margin)
        lines.append(f"{label}{axis_line}{text}")
        runs.append(own)
    edge = f"{'│':>{margin}}"
    if above:
        lines.insert(0, edge + above)
        runs.insert(0, [])
    if below:
        lines.append(edge + below)
        runs.append([])
    return SessionChart([*lines, foot(columns, margin, chosen, marked)], [*runs, []], unnamed)


def _labels(
    ticks: Sequence[tuple[float, str]], axis: tuple[float, float], highest: int
) -> dict[int, str]:
    """Return the label of each row, counted from below, that has one: of several, that of the tick
    next to its middle.
    """

    def distance(value: float) -> float:
        return abs(_middle(_part(value, *axis, highest), axis, highest) - value)

    return {
        _part(value, *axis, highest) // 2: label
        for value, label in sorted(ticks, key=lambda tick: -distance(tick[0]))
        if axis[0] <= value <= axis[1]
    }


class _Canvas:
    """The cells of a chart: each has two halves, one above the other, and may have a character,
    which is drawn where no value and no band is. Rows and half rows count from below.
    """

    def __init__(self, rows: int, width: int, is_shaded: bool) -> None:
        self._width = width
        self._is_shaded = is_shaded
        self._halves: list[list[Role]] = [[""] * width for _ in range(2 * rows)]
        self._signs = [[" "] * width for _ in range(rows)]
        self._names: set[tuple[int, int]] = set()

    def area(self, lower: int | None, upper: int | None) -> list[int]:
        """Draw an area between two edges of half rows; None for one beyond the axis.

        Returns:
            Rows for its name, the best ones first.
        """
        first = 0 if lower is None else lower
        last = (len(self._halves) if upper is None else upper) - 1
        inside = list(reversed(range((first + 1) // 2, (last + 1) // 2)))
        if not self._is_shaded:
            borders = [edge // 2 for edge in (upper, lower) if edge is not None]
            for row in borders:
                self.rule(row, LIMIT)
            return borders + inside
        for half in range(first, last + 1):
            self._halves[half] = ["area"] * self._width
        return inside

    def rule(self, row: int, sign: str) -> None:
        """Draw a line over the whole width."""
        self._signs[row] = [sign] * self._width

    def draw(self, values: Sequence[Value], column: int, step: Callable[[float], int]) -> None:
        """Draw the mean of values with its band, given the half row of a value."""
        value = _mean([each.value for each in values])
        low = _mean([each.low for each in values])
        high = _mean([each.high for each in values])
        if value is None:
            return
        if low is not None and high is not None:
            for half in range(step(low), step(high) + 1):
                self._halves[half][column] = "band"
        self._halves[step(value)][column] = "point"

    def name(self, text: str, rows: Sequence[int]) -> bool:
        """Write a name as far right as there is room in one of the rows, the first ones first;
        return False if there is none.
        """
        spaced = f" {text} "
        for row in rows:
            taken = {
                column
                for column in range(self._width)
                if (row, column) in self._names or {"point", "band"} & set(self._cell(row, column))
            }
            for first in range(self._width - len(spaced) + 1, -1, -1):
                place = range(first, min(self._width, first + len(spaced)))
                if taken.isdisjoint(place):
                    self._signs[row][place[0] : place[-1] + 1] = spaced[: len(place)]
                    self._names |= {(row, column) for column in place}
                    return True
        return False

    def row(self, row: int, margin: int) -> tuple[str, list[Run]]:
        """Return a row, without blanks at its end, and the parts that its characters show, which
        begins after a margin.
        """
        cells = [self._drawn(row, column) for column in range(self._width)]
        while cells and cells[-1] == (" ", "", ""):
            cells.pop()
        runs, first = [], margin
        for (shown, behind), alike in groupby(cells, key=lambda cell: cell[1:]):
            last = first + len(list(alike))
            if shown or behind:
                runs.append(Run(first, last, shown, behind))
            first = last
        return "".join(character for character, *_ in cells), runs

    def _cell(self, row: int, column: int) -> tuple[Role, Role]:
        """Return the lower and the upper half of a cell."""
        return self._halves[2 * row][column], self._halves[2 * row + 1][column]

    def _drawn(self, row: int, column: int) -> tuple[str, Role, Role]:
        """Return a character, the part that it shows, and the part behind it."""
        halves, sign = self._cell(row, column), self._signs[row][column]
        is_name = (row, column) in self._names
        if (is_name or sign != " ") and not {"point", "band"} & set(halves):
            return sign, "label" if is_name else "line", "area" if "area" in halves else ""
        if self._is_shaded:
            return _shaded(*halves)
        if "point" in halves:
            return HALVES[halves.index("point")], "point", ""
        if "band" in halves:
            both = halves[0] == halves[1]
            return BAND if both else BAND_HALVES[halves.index("band")], "band", ""
        return " ", "", ""


def _shaded(lower: Role, upper: Role) -> tuple[str, Role, Role]:
    """Return a character for two halves, the part that it shows, and the part behind it. Whole
    cells have no character, so that strokes have no gaps between rows, whatever the font.
    """
    if lower == upper:
        return " ", "", lower
    if lower == "point":
        return HALVES[0], lower, upper
    return HALVES[1], upper or "ground", lower


def _borders(
    area: tuple[float, float] | None,
    axis: tuple[float, float],
    highest: int,
    *,
    is_shaded: bool,
) -> tuple[int | None, int | None]:
    """Return the half rows, counted from below, on whose lower edges the limits of an area are; None
    for one beyond the axis. There is room between them, above and below. A line is in the middle of
    a row; a shade may begin between rows, too.
    """
    low, high = axis
    if area is None or low >= high:
        return None, None

    def border(value: float) -> int:
        halves = (value - low) / (high - low) * highest + 0.5
        return round(halves) if is_shaded else 2 * round((halves - 1) / 2) + 1

    upper = max(3, min(highest, border(area[1])))
    lower = max(1, min(upper - 2, border(area[0])))
    return lower if low <= area[0] <= high else None, upper if low <= area[1] <= high else None


def _line(value: float, axis: tuple[float, float], highest: int) -> tuple[int, bool]:
    """Return the row of a line that is the nearest to a value: in its middle, or True, on its lower
    edge.
    """
    low, high = axis
    if high <= low:
        return highest // 4, False
    halves = (value - low) / (high - low) * highest + 0.5
    row = min(math.floor(halves / 2), highest // 2)
    over = halves - (2 * row + 1)
    if over > 0.5 + _ROUNDING and 2 * row + 1 < highest:
        return row + 1, True
    return row, over < -0.5 - _ROUNDING


def foot(
    columns: Columns,
    margin: int,
    chosen: int | None = None,
    marked: int | None = None,
) -> str:
    """Return the lower axis, with signs of the chosen session and the one it is compared with."""
    line = ["─"] * columns.width
    for session, sign in ((marked, MARKED), (chosen, CHOSEN)):
        if session is not None:
            line[columns.column(session)] = sign
    return f"{'└':>{margin}}{''.join(line)}"


def _signs(values: Sequence[Value], columns: Columns, wanted: str) -> str:
    """Return a row with the signs of columns that have no value, as far as they are wanted; empty
    for none.
    """
    line = [" "] * columns.width
    for column, sessions in columns.groups():
        found = [values[session] for session in sessions]
        if all(each.value is None for each in found):
            line[column] = next(
                (each.without for each in found if each.without and each.without in wanted), " "
            )
    return "".join(line).rstrip()


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.fmean(known) if known else None


def _part(value: float, low: float, high: float, steps: int) -> int:
    """Return the step of a value between two others, 0 to ``steps``; those beyond are at the
    ends.
    """
    if high - low <= _ROUNDING * max(abs(low), abs(high)):
        return steps // 2
    return max(0, min(steps, round((value - low) / (high - low) * steps)))


def _middle(step: int, axis: tuple[float, float], highest: int) -> float:
    """Return the value in the middle of the row of a half row."""
    return axis[0] + (axis[1] - axis[0]) * (step // 2 * 2 + 0.5) / highest


def _days(first: str, last: str) -> int:
    return (date.fromisoformat(last) - date.fromisoformat(first)).days


def sparkline(values: Sequence[float | None], width: int) -> str:
    """Draw the last values as columns between the least and the greatest; a dot for None."""
    shown = values[-width:] if width > 0 else []
    known = [value for value in shown if value is not None]
    if not known:
        return "·" * len(shown)
    least, span = min(known), (max(known) - min(known)) or 1.0
    return "".join(
        "·" if value is None else BARS[round((value - least) / span * (len(BARS) - 1))]
        for value in shown
    )


def curve(
    x: Sequence[float],
    y: Sequence[float],
    width: int,
    height: int,
    *,
    axis: tuple[float, float] | None = None,
    rule: float | None = None,
) -> list[str]:
    """Draw a curve with its axes.

    Args:
        x, y: of its points.
        width, height: in characters.
        axis: lowest and highest value; both axes get round numbers. None: those of the curve.
        rule: value at which a dashed line is drawn.
    """
    import plotext

    plotext.clear_figure()
    try:
        plotext.limit_size(False, False)
        plotext.theme("clear")
        plotext.plotsize(width, height)
        plotext.xlim(min(x), max(x))
        if axis is not None:
            plotext.ylim(*axis)
            plotext.yticks(round_numbers(*axis, max(2, height // 3)))
            plotext.xticks(round_numbers(min(x), max(x), max(2, width // 10)))
        if rule is not None:
            plotext.plot([min(x), max(x)], [rule] * 2, marker=RULE)
        plotext.plot(list(x), list(y), marker="braille")
        body = plotext.uncolorize(str(plotext.build()))
    finally:
        plotext.clear_figure()
    return [line.rstrip() for line in body.rstrip("\n").split("\n")]


# --- pictures
# --------------------------------------------------------------------------------------------------

Spec = dict[str, Any]
"""A chart in Vega-Lite (version 5), or a part of one, without a remote reference."""
INK, SOFT, ACCENT, ALARM, DIM = "#1f4e79", "#b9c7d6", "#8a4b08", "#a01010", "#777777"
"""Colours of pictures."""
WIDTH = 620
"""Width of a picture in pixels."""
_CONFIG: Spec = {
    "aria": False,  # the page names each chart as a whole
    "font": "sans-serif",
    "axis": {"labelFontSize": 11, "titleFontSize": 11, "titleFontWeight": "normal"},
    "axisY": {"format": ".6~r", "minExtent": 40},
    "view": {"stroke": "#ccc"},
}


def picture(values: Sequence[Spec] = (), layers: Sequence[Spec] = (), **more: Any) -> Spec:
    """Return a chart of values.

    Args:
        layers: made by `mark`; empty if ``more`` has other parts.
        more: further parts of the chart, such as its height.
    """
    made: Spec = {"$schema": "https://vega.github.io/schema/vega-lite/v5.json", "config": _CONFIG}
    if values:
        made["data"] = {"values": list(values)}
    if layers:
        made |= {"width": WIDTH, "layer": list(layers)}
    return made | more


def mark(kind: str, encoding: Spec, values: Sequence[Spec] | None = None, **look: Any) -> Spec:
    """Return a layer of a chart.

    Args:
        kind: of mark: line, rule, point, bar, …
        encoding: its channels, each made by `channel`.
        values: its own, if they are others than those of the chart.
        look: colour, dash and other properties of the mark.
    """
    layer: Spec = {"mark": {"type": kind, **look}, "encoding": encoding}
    return layer if values is None else {"data": {"values": list(values)}, **layer}


def channel(field: str, type: str = "quantitative", **more: Any) -> Spec:
    """Return the channel that shows a field."""
    return {"field": field, "type": type, **more}


class ChartsMissing(Exception):
    """The package that draws pictures is not installed. The message is one clear sentence."""


def no_package() -> str:
    """Return the sentence that says how to install what draws pictures."""
    how = pip_install_extra("report")
    return f"The charts need the Python package vl-convert-python. Install it with: {how}"


def drawn(spec: Spec) -> str:
    """Return a chart as SVG. Raises ChartsMissing if the extra ``report`` is not installed."""
    try:
        import vl_convert
    except ImportError:
        raise ChartsMissing(no_package()) from None
    return str(vl_convert.vegalite_to_svg(spec))
