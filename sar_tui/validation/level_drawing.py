"""Figures of levels and of angular velocities as text."""

from collections.abc import Sequence
from typing import Any

from sar_tui.validation.charts import RESULT
from sar_tui.validation.feedback_drawing import draw
from sar_tui.validation.report import Row

_WIDTH, _HEIGHT, _LEVELS = 78, 14, 9


def draw_levels(rows: Sequence[Row], title: str, label: str = RESULT) -> str:
    """Draw results over attempts with the goal, and the level of each attempt below them.

    Args:
        rows: one per attempt, in order: ``reaction_time_ms`` (None without one), ``goal_ms``,
            ``level``, ``outcome``.
        title: text above the drawing.
        label: name and unit of the result.
    """
    marked = [{**row, "feedback": "none"} for row in rows]
    levels = [row["level"] for row in rows]
    attempts = list(range(1, len(rows) + 1))

    def body(plt: Any) -> None:
        plt.plotsize(_WIDTH, _LEVELS)
        plt.xlim(0.5, len(rows) + 0.5)
        plt.ylim(0, max(levels) + 1)
        plt.plot(attempts, levels, marker="braille")
        plt.scatter(attempts, levels, marker="●")
        ticks = range(1, max(levels) + 1, max(1, max(levels) // 4))
        plt.yticks(ticks, [f"{tick:>4}" for tick in ticks])
        plt.xticks(attempts, [str(attempt) for attempt in attempts])

    return f"{draw(marked, title, label)}\nlevel\n{_plotted(body)}"


def draw_curve(x: Sequence[float], y: Sequence[float], title: str, axes: str) -> str:
    """Draw a curve. ``axes``: says what is drawn over what."""

    def body(plt: Any) -> None:
        plt.plotsize(_WIDTH, _HEIGHT)
        plt.xlim(min(x), max(x))
        plt.plot(list(x), list(y), marker="braille")

    return f"{title}\n{axes}\n{_plotted(body)}"


def _plotted(draw_body: Any) -> str:
    import plotext

    plotext.clear_figure()
    try:
        plotext.limit_size(False, False)
        plotext.theme("clear")
        draw_body(plotext)
        body = plotext.uncolorize(str(plotext.build()))
    finally:
        plotext.clear_figure()
    return "\n".join(line.rstrip() for line in body.rstrip("\n").split("\n"))
