"""Figures of a few characters: responses, times, the motion of a hand, time that runs out."""

from collections.abc import Sequence
from math import ceil

from rich.cells import cell_len, set_cell_size

from sar_tui.framework.messages import TrialEnded

_STEPS = "▁▂▃▄▅▆▇█"
_RIGHT, _WRONG, _MISSED = "✓", "✗", "–"
Piece = tuple[str, str]
"""A text and its style."""


def responses(trials: Sequence[TrialEnded], width: int) -> list[Piece]:
    """The last responses, newest last: a tick, a cross, or a dash for none, and what was to be done."""
    pieces: list[Piece] = []
    for trial in reversed(trials):
        sign, style = _judged(trial)
        text = f"{sign}{trial.stimulus[:6]} "
        if len(text) > width:
            break
        width -= len(text)
        pieces.insert(0, (text, style))
    return pieces


def _judged(trial: TrialEnded) -> Piece:
    if trial.correct:
        return _RIGHT, "$success"
    return (_MISSED, "$text-muted") if trial.response is None else (_WRONG, "$warning bold")


def timed(trial: TrialEnded) -> float | None:
    """The time of a trial, for an eye to compare: what it adds to the metric, else its reaction time (ms)."""
    return trial.value if trial.value is not None else trial.reaction_time_ms


def sparkline(values: Sequence[float | None], width: int) -> str:
    """Values as columns of one character from the least to the greatest; a dot where there is none."""
    shown = values[-width:] if width > 0 else []
    known = [value for value in shown if value is not None]
    if not known:
        return "·" * len(shown)
    least, span = min(known), (max(known) - min(known)) or 1.0
    return "".join(
        "·" if value is None else _STEPS[round((value - least) / span * (len(_STEPS) - 1))] for value in shown
    )


def motion(rates: Sequence[float], width: int) -> str:
    """How fast a hand turned, either way round: one row, scaled to no less than 1 rad/s."""
    if not rates or width <= 0:
        return ""
    size = max(1, ceil(len(rates) / width))
    tops = [max(abs(rate) for rate in rates[begin : begin + size]) for begin in range(0, len(rates), size)]
    scale = max(1.0, *tops)
    return "".join(_STEPS[round(top / scale * (len(_STEPS) - 1))] for top in tops[-width:])


def bar(share: float, width: int) -> tuple[str, str]:
    """What is left of something, as a line of blocks, and the rest of the width."""
    full = ceil(max(0.0, min(1.0, share)) * width)
    return "█" * full, "░" * (width - full)


def cut(text: str, width: int) -> str:
    """A text on one line of at most so many columns; what does not fit is told by an ellipsis."""
    line = " ".join(text.split())
    if cell_len(line) <= width:
        return line
    return set_cell_size(line, max(0, width - 1)).rstrip() + "…"


def folded(text: str, width: int, rows: int) -> list[str]:
    """A text on lines of at most so many columns, no more than so many; what does not fit is told by an ellipsis."""
    lines: list[str] = []
    for paragraph in text.splitlines() if width > 0 else []:
        rest = paragraph.split()
        while rest:
            line, rest = _line(rest, width)
            lines.append(line)
    if len(lines) <= rows:
        return lines
    last = lines[rows - 1] if rows else ""
    return [*lines[: rows - 1], f"{set_cell_size(last, min(cell_len(last), width - 1)).rstrip()}…"] if rows else []


def _line(words: list[str], width: int) -> tuple[str, list[str]]:
    """The first line of words, and those that are left; a word that is longer than the line is cut in two."""
    line, rest = "", list(words)
    while rest and cell_len(f"{line} {rest[0]}".strip()) <= width:
        line = f"{line} {rest.pop(0)}".strip()
    if not line and rest:
        line = set_cell_size(rest[0], width).rstrip()
        rest[0] = rest[0][len(line) :]
    return line, rest


def two_lines(text: str, width: int) -> str:
    """A text on exactly two lines, so that nothing below them moves; what does not fit is told by an ellipsis."""
    first, rest = _line(text.split(), width)
    return f"{first}\n{cut(' '.join(rest), width)}"
