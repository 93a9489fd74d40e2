"""Result of an attempt in a word, with a marker, for tables and plots. Pure."""

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:  # a table of the command line needs neither
    from sar_tui.model.messages import Outcome
    from sar_tui.model.trial_types import Metric

ResultName = Literal["reached", "missed", "inaccurate", "no result", "no goal"]
MARKERS: dict[ResultName, str] = {
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
