"""Figures 4.11, 4.12 and 4.14 of the thesis as text: the results of a session's attempts, with
their feedback.
"""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from sar_tui.validation.charts import RESULT
from sar_tui.validation.report import Row

MARKS = {"positive": "▲", "neutral": "■", "negative": "▼", "none": "·"}
"""Marks for the feedback on an attempt."""
GOAL = "╌"
_STEP_MS = 200
_WIDTH, _HEIGHT = 78, 16


def draw(rows: Sequence[Row], title: str, label: str = RESULT) -> str:
    """Draw reaction times over attempts, with a mark for the feedback on each, and the goal as a
    line.

    Args:
        rows: one per attempt, in order: ``reaction_time_ms`` (None without one), ``goal_ms``,
            ``feedback``.
        title: text above the drawing.
        label: name and unit of the result.
    """
    import plotext

    plotext.clear_figure()
    try:
        body = plotext.uncolorize(_body(plotext, rows))
    finally:
        plotext.clear_figure()
    lines = [line.rstrip() for line in body.rstrip("\n").split("\n")]
    seen = {row["feedback"] for row in rows}
    legend = "  ".join(f"{mark} {name}" for name, mark in MARKS.items() if name in seen)
    return "\n".join([title, f"{label}  {legend}  {GOAL} goal", *lines])


def _body(plt: Any, rows: Sequence[Row]) -> str:
    attempts = range(1, len(rows) + 1)
    times: list[float | None] = [row["reaction_time_ms"] for row in rows]
    goals = [row["goal_ms"] for row in rows]
    known = [*goals, *(time for time in times if time is not None)]
    low, high = min(known) // _STEP_MS * _STEP_MS, (max(known) // _STEP_MS + 1) * _STEP_MS
    plt.limit_size(False, False)
    plt.theme("clear")
    plt.plotsize(_WIDTH, _HEIGHT)
    plt.xlim(0.5, len(rows) + 0.5)
    plt.ylim(low, high)
    for has_result, run in groupby(attempts, key=lambda attempt: times[attempt - 1] is not None):
        if has_result and len(joined := list(run)) > 1:
            plt.plot(joined, [times[attempt - 1] for attempt in joined], marker="braille")
    plt.plot([0.5, len(rows) + 0.5], [goals[0], goals[-1]], marker=GOAL)
    for feedback, mark in MARKS.items():
        marked = [attempt for attempt in attempts if rows[attempt - 1]["feedback"] == feedback]
        if marked:
            plt.scatter(marked, [times[attempt - 1] or low for attempt in marked], marker=mark)
    ticks = range(int(low), int(high) + 1, _STEP_MS)
    plt.yticks(ticks, [str(tick) for tick in ticks])
    plt.xticks(attempts, [str(attempt) for attempt in attempts])
    return str(plt.build())
