"""The results and levels of the session's attempts, as a plot beside the log where there is
room.
"""

from collections.abc import Sequence

from textual.content import Content

from sar_tui.model.messages import AttemptEnded
from sar_tui.model.trial_types import Metric
from sar_tui.reports.attempts_plot import BARS, MARKERS, attempts_figure, result_name


def trend(
    attempts: Sequence[AttemptEnded], metric: Metric | None, width: int, height: int
) -> Content:
    """Return the plot of one participant's attempts.

    Args:
        attempts: in order; practice attempts are left out, as in the summary.
        metric: of the task; None if it is not known.
        width, height: in characters.
    """
    scored = [attempt for attempt in attempts if not attempt.practice]
    if metric is not None and metric.is_none:
        return Content.assemble(("This task has no result", "$text-muted"))
    if metric is None or not scored:
        return Content.assemble(("No attempt finished yet", "$text-muted"))
    figure = attempts_figure(
        [attempt.level for attempt in scored],
        [attempt.metric for attempt in scored],
        metric=metric.label,
        goals=[attempt.goal for attempt in scored],
        width=width,
        height=height,
        color=False,
        results=[
            result_name(attempt.outcome, attempt.metric, attempt.goal, metric) for attempt in scored
        ],
    )
    plot = Content(figure)
    for name, marker in MARKERS.items():
        style = {"reached": "$success", "no goal": "$accent"}.get(name, "$warning")
        plot = _colored(plot, marker, style)
    return _colored(plot, BARS, "$text-muted")


def _colored(plot: Content, characters: str, style: str) -> Content:
    """Return a plot with some characters in a style."""
    for column, character in enumerate(plot.plain):
        if character in characters:
            plot = plot.stylize(style, column, column + 1)
    return plot
