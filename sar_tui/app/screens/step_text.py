"""Texts of a step between attempts: the question, what can be chosen, and how."""

from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.model.language import Language
from sar_tui.model.messages import AskedStep
from sar_tui.model.results_for_people import duration_text
from sar_tui.model.step import TIMED, points
from sar_tui.model.step_entry import FULL
from sar_tui.model.units import SECOND

_CELL, _LINE = 5, 51
"""Columns of a number on a scale, and of a line."""
_TALL = 9
"""Most points that are written one below the other."""
_COLUMN_ROWS = 6
_GAP = "\N{NO-BREAK SPACE}"
"""A space that stays where lines are centred."""
_WIDE = 60


def step_text(asked: AskedStep, tr: Language, left: int = 0) -> WaitingText:
    """Return the text for a step; ``left``: time that is left of a rest or a calibration (ns)."""
    step = asked.step
    if step.kind in TIMED:
        return WaitingText(
            step.text, tr("We go on in {time}.", time=duration_text(-(-left // SECOND), tr)), ""
        )
    if not step.is_question:
        return WaitingText("", step.text, tr("Press Enter to go on."), tr("Enter"))
    missing = {
        "text": tr("Please type your answer first, then press Enter."),
        "choices": tr("Please choose at least one, then press Enter."),
    }.get(step.kind, tr("Please choose first, then press Enter."))
    question = tr("{who}: {words}", who=asked.who, words=step.text) if asked.who else step.text
    return WaitingText(
        question, _options(asked), missing if asked.entry.is_missing else _how(asked, tr)
    )


def decline_text(asked: AskedStep | None, tr: Language) -> str:
    """Return how to give no answer to a question; empty if nothing is asked, or a long scale takes
    its place.
    """
    is_said = asked is not None and asked.step.is_question and asked.step.kind != "borg"
    return tr("Tab: I would rather not say.") if is_said else ""


def _how(asked: AskedStep, tr: Language) -> str:
    match asked.step.kind:
        case "text":
            return tr("Type your answer, then press Enter.")
        case "choices":
            return tr("Press the number of each that fits, then Enter.")
        case "borg":
            return tr("Number or arrow key, then Enter. Tab: I would rather not say.")
        case "line":
            return tr("Move the mark with the arrow keys, then press Enter.")
    return tr("Press the number or an arrow key, then Enter.")


def _options(asked: AskedStep) -> str:
    match asked.step.kind:
        case "text":
            return _typed(asked.entry.typed)
        case "line":
            return _line(asked)
        case "number":
            return _row(asked)
    return _list(asked)


def _typed(text: str) -> str:
    """Return typed words with a cursor, in lines of equal width."""
    whole = f"{text}▏"
    lines = [whole[start : start + _WIDE] for start in range(0, len(whole), _WIDE)]
    return _block(lines, _WIDE)


def _row(asked: AskedStep) -> str:
    """Return the numbers of a scale beside each other, the chosen one in brackets, above the words
    at its ends.
    """
    cells = []
    for index, point in enumerate(points(asked.step)):
        mark = f"[{point.typed}]" if index in asked.entry.chosen else point.typed
        cells.append(mark.center(_CELL))
    row = "".join(cells)
    return _with_ends(row, asked.step.labels)


def _line(asked: AskedStep) -> str:
    place = asked.entry.place
    line = "─" * _LINE
    if place is not None:
        at = round(place / FULL * (_LINE - 1))
        line = f"{line[:at]}●{line[at + 1 :]}"
    return _with_ends(f"├{line}┤", asked.step.labels)


def _with_ends(row: str, labels: tuple[str, ...]) -> str:
    """Return a row with words below its ends, on one line if they fit."""
    if not labels:
        return row.replace(" ", _GAP)
    low, high = labels
    gap = len(row) - len(low) - len(high)
    ends = [f"{low}{' ' * gap}{high}"] if gap > 1 else [low.ljust(len(row)), high.rjust(len(row))]
    return _block([row, *ends], len(row))


def _list(asked: AskedStep) -> str:
    """Return the options one below the other, or in columns, with an arrow before what is chosen or
    pointed at.
    """
    step, entry = asked.step, asked.entry
    several = step.kind == "choices"
    digits = max(len(point.typed) for point in points(step))
    lines = []
    for index, point in enumerate(points(step)):
        is_chosen = index in entry.chosen
        box = ("[x] " if is_chosen else "[ ] ") if several else ""
        is_at = index == entry.place if several else is_chosen
        lines.append(
            f"{'▶' if is_at else ' '} {box}{point.typed.rjust(digits)}  {point.label}".rstrip()
        )
    width = max(map(len, lines))
    if len(lines) <= _TALL:
        return _block(lines, width)
    columns = [lines[start : start + _COLUMN_ROWS] for start in range(0, len(lines), _COLUMN_ROWS)]
    widths = [max(map(len, column)) for column in columns]
    rows = [
        "  ".join(
            column[row].ljust(width)
            for column, width in zip(columns, widths, strict=True)
            if row < len(column)
        )
        for row in range(_COLUMN_ROWS)
    ]
    return _block(rows, max(map(len, rows)))


def _block(lines: list[str], width: int) -> str:
    """Return lines of one width, so that centring keeps their beginnings below each other."""
    return "\n".join(line.ljust(width).replace(" ", _GAP) for line in lines)
