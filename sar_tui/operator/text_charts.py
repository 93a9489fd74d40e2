"""Charts in text, and text that fits a width."""

from collections.abc import Sequence
from math import ceil

from rich.cells import cell_len, set_cell_size
from textual.content import Content

from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import AttemptEnded, TrialEnded
from sar_tui.model.trial_types import Metric
from sar_tui.reports.charts import BARS, MARKERS, attempts_figure, result_name

_RIGHT, _WRONG, _MISSED, _UNSURE = "✓", "✗", "–", "?"
Piece = tuple[str, str]
"""Text and its style."""


def responses(trials: Sequence[TrialEnded], width: int) -> list[Piece]:
    """Return the last responses, newest last: a tick, a cross, a question mark for an unsure one or
    a dash for none, and the stimulus.
    """
    pieces: list[Piece] = []
    for trial in reversed(trials):
        sign, style = _result(trial)
        text = f"{sign}{trial.stimulus[:6]} "
        if len(text) > width:
            break
        width -= len(text)
        pieces.insert(0, (text, style))
    return pieces


def _result(trial: TrialEnded) -> Piece:
    if trial.is_unsure:
        return _UNSURE, "$warning bold"
    if trial.correct:
        return _RIGHT, "$success"
    return (_MISSED, "$text-muted") if trial.response is None else (_WRONG, "$warning bold")


def trial_value(trial: TrialEnded) -> float | None:
    """Return what a trial adds to the metric, else its reaction time (ms)."""
    return trial.value if trial.value is not None else trial.reaction_time_ms


def motion(rates: Sequence[float], width: int) -> str:
    """Draw how fast a hand turned in either direction, on a scale of at least 1 rad/s."""
    if not rates or width <= 0:
        return ""
    size = max(1, ceil(len(rates) / width))
    tops = [
        max(abs(rate) for rate in rates[begin : begin + size])
        for begin in range(0, len(rates), size)
    ]
    scale = max(1.0, *tops)
    return "".join(BARS[round(top / scale * (len(BARS) - 1))] for top in tops[-width:])


def trend(
    attempts: Sequence[AttemptEnded],
    metric: Metric | None,
    width: int,
    height: int,
    tr: Language = ENGLISH,
) -> Content:
    """Return the plot of one participant's attempts.

    Args:
        attempts: in order; practice attempts are left out, as in the summary.
        metric: of the task; None if it is not known.
        width, height: in characters.
        tr: language of the panel.
    """
    scored = [attempt for attempt in attempts if not attempt.practice]
    if metric is not None and metric.is_none:
        return Content.assemble((tr("This task has no result"), "$text-muted"))
    if metric is None or not scored:
        return Content.assemble((tr("No attempt finished yet"), "$text-muted"))
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
        tr=tr,
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


def bar(share: float, width: int) -> tuple[str, str]:
    """Return the full and the empty part of a bar."""
    full = ceil(max(0.0, min(1.0, share)) * width)
    return "█" * full, "░" * (width - full)


def cut(text: str, width: int) -> str:
    """Return a text on one line of at most ``width`` columns, with an ellipsis if it is cut."""
    line = " ".join(text.split())
    if cell_len(line) <= width:
        return line
    return set_cell_size(line, max(0, width - 1)).rstrip() + "…"


def wrap(text: str, width: int, rows: int) -> list[str]:
    """Return a text on at most ``rows`` lines of ``width`` columns, with an ellipsis if it is
    cut.
    """
    lines: list[str] = []
    for paragraph in text.splitlines() if width > 0 else []:
        rest = paragraph.split()
        while rest:
            line, rest = _line(rest, width)
            lines.append(line)
    if len(lines) <= rows:
        return lines
    last = lines[rows - 1] if rows else ""
    return (
        [*lines[: rows - 1], f"{set_cell_size(last, min(cell_len(last), width - 1)).rstrip()}…"]
        if rows
        else []
    )


def _line(words: list[str], width: int) -> tuple[str, list[str]]:
    """Return the first line and the remaining words. A word longer than the line is split."""
    line, rest = "", list(words)
    while rest and cell_len(f"{line} {rest[0]}".strip()) <= width:
        line = f"{line} {rest.pop(0)}".strip()
    if not line and rest:
        line = set_cell_size(rest[0], width).rstrip()
        rest[0] = rest[0][len(line) :]
    return line, rest


def two_lines(text: str, width: int) -> str:
    """Return a text on exactly two lines, so that nothing below them moves, with an ellipsis if it
    is cut.
    """
    first, rest = _line(text.split(), width)
    return f"{first}\n{cut(' '.join(rest), width)}"
