"""Text plot of result and level over the attempts of a session (thesis, Figure 4.4)."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from sar_tui.framework.language import Language
from sar_tui.reports.attempt_results import MARKERS, ResultName

LEVEL, GOAL = "░", "╌"
_COLORS: dict[ResultName, str] = {"reached": "green", "missed": "red", "inaccurate": "red", "no result": "red"}

_ENGLISH = Language()
_MARGIN = 7
"""Columns for the numbers of the left axis and the name of the lower one."""
_SMALLEST = (30, 7)
"""Least width and height."""


def attempts_figure(
    levels: Sequence[int],
    metrics: Sequence[float | None],
    *,
    metric: str,
    goals: Sequence[float],
    width: int,
    height: int,
    color: bool = True,
    results: Sequence[ResultName] = (),
    beside: Sequence[float | None] = (),
    tr: Language = _ENGLISH,
) -> str:
    """Draw the metric (left axis) and the level (right axis, shaded) over attempts, with the goal as a line.

    Attempts without a result have their markers below the axis, where no value is read from them.

    Args:
        levels: of each attempt.
        metrics: of each attempt; None without a result.
        metric: name and unit, the heading of the left axis.
        goals: of each attempt; they may differ by level.
        width, height: in characters, including heading and axes.
        color: use ANSI colours.
        results: of each attempt; if empty, all that have a metric have the same marker.
        beside: metrics and goals of a figure shown beside this one, so that both have the same axes.
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
    plotext.clear_figure()
    try:
        body = _body(plotext, levels, metrics, goals, (width, height - 1 - has_empty), names, beside, tr)
    finally:
        plotext.clear_figure()
    lines = [line.rstrip() for line in body.rstrip("\n").split("\n")]
    lines[-1] = tr("attempt")[:_MARGIN].ljust(_MARGIN) + lines[-1][_MARGIN:]
    if has_empty:
        marker = plotext.colorize(MARKERS["no result"], _COLORS["no result"], "bold")
        lines.insert(-1, _below_axis(plotext.uncolorize(lines[-2]), metrics, marker))
    text = "\n".join([_heading(metric, goals, names, width, tr, has_legend=bool(results)), *lines])
    return text if color else plotext.uncolorize(text)


def _body(
    plt: Any,
    levels: Sequence[int],
    metrics: Sequence[float | None],
    goals: Sequence[float],
    size: tuple[int, int],
    results: Sequence[ResultName],
    beside: Sequence[float | None],
    tr: Language,
) -> str:
    """Draw the axes and the data, on a canvas two lines lower than the height."""
    count, rows = len(levels), size[1] - 2
    attempts = range(1, count + 1)
    plt.limit_size(False, False)
    plt.theme("clear")
    plt.plotsize(*size)
    plt.xaxes(True, False)
    plt.xlim(0.5, count + 0.5)
    low, high = _limits([value for value in (*metrics, *goals, *beside) if value is not None])
    plt.ylim(low, high, yside="left")
    highest = max(1, *levels)
    shaded = rows if len(set(levels)) > 1 else max(1, rows // 4)  # a level that never changes needs no more
    rise = shaded // highest or shaded / highest
    plt.ylim(1 / rise, rows / rise, yside="right")

    plt.bar(attempts, levels, width=1, minimum=1 / rise, marker=LEVEL, color="blue", yside="right")
    for goal, alike in groupby(enumerate(goals, start=1), key=lambda item: item[1]):
        same = [attempt for attempt, _ in alike]
        plt.plot([same[0] - 0.5, same[-1] + 0.5], [goal] * 2, marker=GOAL)
    for run in _runs(metrics):
        plt.plot([attempt for attempt, _ in run], [value for _, value in run], marker="braille")
    for name, marker in MARKERS.items():
        found = [attempt for attempt, its in zip(attempts, results, strict=True) if its == name != "no result"]
        if found:
            plt.scatter(
                found, [metrics[attempt - 1] for attempt in found], marker=marker, color=_COLORS[name], style="bold"
            )

    ticks = _round_numbers(low, high, max(2, rows // 2))
    plt.yticks(ticks, [tr.figures(f"{tick:g}").rjust(_MARGIN) for tick in ticks], yside="left")
    plt.yticks(shown := sorted(set(levels)), [str(level) for level in shown], yside="right")
    room = count * (len(str(count)) + 1) / (size[0] - _MARGIN - 6)
    every = next(step for power in (1, 10, 100, 1000, 10_000) for m in (1, 2, 5) if (step := m * power) >= room)
    labelled = [attempt for attempt in attempts if every == 1 or attempt == 1 or attempt % every == 0]
    plt.xticks(labelled, [str(attempt) for attempt in labelled])
    return str(plt.build())


def _below_axis(axis: str, metrics: Sequence[float | None], marker: str) -> str:
    """Return the line below the axis, with a marker for each attempt without a metric in the attempt's column."""
    first, last = axis.index("└") + 1, axis.index("┘") - 1
    line = [" "] * (last + 1)
    for index, value in enumerate(metrics):
        if value is None:  # the column in which plotext would draw a value
            line[first + math.floor(0.5 + round((last - first) * (index + 0.5) / len(metrics), 8))] = marker
    return "".join(line).rstrip()


def _heading(
    metric: str,
    goals: Sequence[float],
    results: Sequence[ResultName],
    width: int,
    tr: Language,
    *,
    has_legend: bool,
) -> str:
    """Return the names of both axes, and between them as much of the legend as fits."""
    used = set(results) if has_legend else {"no result"} & set(results)
    legend = [f"{marker} {tr(name)}" for name, marker in MARKERS.items() if name in used]
    goal = tr.figures(f" {goals[0]:g}") if len(set(goals)) == 1 else ""
    legend += [f"{GOAL} {tr('goal')}{goal}"]
    right = f"{LEVEL} {tr('level')}"
    left = metric[: width - len(right) - 2]
    while legend and len("  ".join([left, *legend, right])) > width:
        legend.pop()
    middle = "  ".join(legend)
    return left + middle.center(width - len(left) - len(right)) + right


def _runs(metrics: Sequence[float | None]) -> Iterator[list[tuple[int, float]]]:
    """Yield runs of consecutive attempts with a result, to be joined by a line."""
    for has_result, run in groupby(enumerate(metrics, start=1), key=lambda item: item[1] is not None):
        if has_result:
            yield [(attempt, value) for attempt, value in run if value is not None]


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """Return the axis limits, with a margin around the values."""
    low, high = min(values), max(values)
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return low - room, high + room


def _round_numbers(low: float, high: float, most: int) -> list[float]:
    """Return at most ``most`` round numbers between two bounds, in steps of 1, 2 or 5 times a power of ten."""
    power = 10 ** math.floor(math.log10((high - low) / most))
    step = next(s for m in (1, 2, 5, 10, 20) if (high - low) / (s := m * power) <= most)
    first = math.ceil(low / step)
    return [round(n * step, 10) for n in range(first, math.floor(high / step) + 1)][:most]
