"""Text plot of a session: a strip with the results of its attempts, and below it one with their
levels.

The thesis draws both into one plot with two axes (Figure 4.4), which invites to compare heights
that mean nothing.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from sar_tui.model.language import Language

if TYPE_CHECKING:  # a table of the command line needs neither
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
"""Characters of the bars of levels, by height."""
_COLORS: dict[str, str] = {
    "reached": "green",
    "missed": "red",
    "inaccurate": "red",
    "no result": "red",
    "no goal": "cyan",
}

_ENGLISH = Language()
_MARGIN = 7
"""Columns for the numbers of the left axis and the name of the lower one."""
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
    has_bars: bool = True,
    tr: Language = _ENGLISH,
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
        has_bars: False for levels in figures alone.
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
    bar_lines = (height >= _FOR_BARS) + (height >= _FOR_TALL_BARS) if has_bars else 0
    explained = legend(
        goals, results or [name for name in names if name == "no result"], tr, markers
    )
    heading = _heading(
        metric, explained if has_legend else [], width, may_have_two=height >= _FOR_LEGEND
    )
    plotext.clear_figure()
    try:
        size = width, height - len(heading) - has_empty - 1 - bar_lines
        body = _body(plotext, metrics, goals, size, names, markers, beside, tr)
    finally:
        plotext.clear_figure()
    lines = [line.rstrip() for line in body.rstrip("\n").split("\n")]
    lines[-1] = tr("attempt")[:_MARGIN].ljust(_MARGIN) + lines[-1][_MARGIN:]
    columns = _Columns.of_axis(plotext.uncolorize(lines[-2]), len(levels))
    below = []
    if has_empty:
        marker = plotext.colorize(MARKERS["no result"], _COLORS["no result"], "bold")
        below.append(columns.line({n: marker for n, value in enumerate(metrics) if value is None}))
    below.append(tr("level")[:_MARGIN].ljust(_MARGIN) + columns.numbers(levels)[_MARGIN:])
    below += [plotext.colorize(line, "blue") for line in columns.bars(levels, bar_lines)]
    text = "\n".join([*heading, *lines[:-1], *below, lines[-1]])
    return text if color else plotext.uncolorize(text)


def _body(
    plt: Any,
    metrics: Sequence[float | None],
    goals: Sequence[float | None],
    size: tuple[int, int],
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
    plt.yticks(ticks, [tr.figures(f"{tick:g}").rjust(_MARGIN) for tick in ticks], yside="left")
    room = count * (len(str(count)) + 1) / (size[0] - _MARGIN - 6)
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
    tr: Language = _ENGLISH,
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
