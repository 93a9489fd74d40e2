"""The options of a question, drawn with characters: boxes of a scale, a line, a list, typed words."""

import textwrap
from collections.abc import Callable, Sequence

from textual.content import Content

from sar_tui.model.step import FULL, Entry, Point, Step, points
from sar_tui.widgets.block_digits import draw_digits

SMALLEST_SCALE = 44
"""Columns of eleven boxes beside each other."""
_MOST_BOXES = 11
"""Points of a scale that has boxes; a longer one has ticks."""
_ENDS = ("lowest", "highest")
_BOXES = (4, 13)
"""Least and most columns of a box of a scale."""
_LARGE_BOX, _LARGEST_BOX = 8, 13
"""Columns from which on the number in a box is three rows high, and in block letters."""
_WIDEST_GAP = 6
"""Most columns from one tick to the next."""
_MARK, _ARROW = "●", "▶"
_LINE = 51
"""Most columns of a line."""
_SHORTEST_LINE = 11
_NARROWEST_LABEL = 10
"""Least columns in which a label is broken."""
_TALL = 9
"""Most points that are written one below the other."""
_COLUMN_ROWS = 6
_GAP = "\N{NO-BREAK SPACE}"
"""A space that stays where lines are centred."""
_WIDE = 60
_LIGHT, _HEAVY = ("┌─┐", "│", "└─┘"), ("┏━┓", "┃", "┗━┛")
"""Borders of a box, and of the chosen one: top, side, bottom."""


def options_text(step: Step, entry: Entry, columns: int = SMALLEST_SCALE) -> str:
    """Return the options of a question, with what is chosen or typed so far.

    Args:
        step: the question.
        entry: what is chosen or typed.
        columns: room for them; the boxes of a scale grow with it.
    """
    match step.kind:
        case "text":
            return _typed(entry.typed, columns)
        case "line":
            return _line(step, entry, columns)
        case "number":
            scale = points(step)
            if len(step.labels) == len(scale) > len(_ENDS):
                return _list(step, entry, columns)
            has_boxes = len(scale) <= min(_MOST_BOXES, columns // _least_box(scale))
            return _boxes(step, entry, columns) if has_boxes else _ticks(step, entry, columns)
    return _list(step, entry, columns)


def _typed(text: str, columns: int) -> str:
    """Return typed words with a cursor, in lines of equal width."""
    whole, wide = f"{text}▏", max(1, min(_WIDE, columns))
    lines = [whole[start : start + wide] for start in range(0, len(whole), wide)]
    return _block(lines, wide)


def _boxes(step: Step, entry: Entry, columns: int) -> str:
    """Return a box for each number, the chosen one with a heavy border, above the words at both
    ends.
    """
    scale = points(step)
    least, most = _least_box(scale), _BOXES[1]
    width = min(max(columns // len(scale), least), most)
    if width > least and width % 2 == 0:
        width -= 1  # a digit has a middle only in an odd number of columns
    numbers = _numbers([point.typed for point in scale], width)
    drawn = [
        _box(number, width, _HEAVY if index in entry.chosen else _LIGHT)
        for index, number in enumerate(numbers)
    ]
    rows = ["".join(parts) for parts in zip(*drawn, strict=True)]
    return _with_ends(rows, step.labels)


def _least_box(scale: Sequence[Point]) -> int:
    """Return the columns of a box that all numbers of a scale fit into."""
    return max(_BOXES[0], 2 + max(len(point.typed) for point in scale))


def _ticks(step: Step, entry: Entry, columns: int) -> str:
    """Return a line with a tick for each point, and the chosen number above its own."""
    scale = points(step)
    gap = min(max((columns - 1) // (len(scale) - 1), 1), _WIDEST_GAP)
    width = (len(scale) - 1) * gap + 1
    line = ("┴" + "─" * (gap - 1)) * (len(scale) - 1) + "┴"
    line, chosen = f"└{line[1:-1]}┘", ""
    if entry.chosen:
        at, typed = entry.chosen[0] * gap, scale[entry.chosen[0]].typed
        line = f"{line[:at]}{_MARK}{line[at + 1 :]}"
        chosen = " " * min(max(0, at - len(typed) // 2), width - len(typed)) + typed
    low, high = scale[0].typed, scale[-1].typed
    return _with_ends([chosen.ljust(width), line, low + high.rjust(width - len(low))], step.labels)


def _box(rows: Sequence[str], width: int, border: tuple[str, str, str]) -> list[str]:
    top, side, bottom = border
    inner = width - 2
    return [
        f"{top[0]}{top[1] * inner}{top[2]}",
        *(f"{side}{row.center(inner)}{side}" for row in rows),
        f"{bottom[0]}{bottom[1] * inner}{bottom[2]}",
    ]


def _numbers(texts: Sequence[str], width: int) -> list[list[str]]:
    """Return the rows of each number, as large as all of them fit into boxes of this width."""
    ways: list[Callable[[str], list[str]]] = []
    if width >= _LARGEST_BOX and "-" not in "".join(texts):
        ways.append(_in_blocks)
    if width >= _LARGE_BOX:
        ways.append(draw_digits)
    for draw in ways:
        drawn = [draw(text) for text in texts]
        if max(len(row) for rows in drawn for row in rows) <= width - 2:
            return drawn
    return [[text] for text in texts]


def _in_blocks(text: str) -> list[str]:
    # its fonts take longer to load than the rest of a small window's modules
    from sar_tui.widgets.large_characters import draw

    digits = [draw(digit, 8, 4) for digit in text]
    return [" ".join(rows) for rows in zip(*digits, strict=True)]


def with_chosen(text: str) -> Content:
    """Return a drawn scale with the chosen box filled, border and all, in the colour of what is
    chosen; of a line, with the mark and the number above it in that colour.
    """
    content = Content(text)
    corner = text.find(_HEAVY[0][0])
    if corner < 0:
        first, at = text.split("\n", 1)[0], text.find(_MARK)
        above = len(first) if first.strip(_GAP).lstrip("-").isdecimal() else 0
        content = content.stylize("$accent", 0, above) if above else content
        return content.stylize("$accent", at, at + 1) if at >= 0 else content
    left = corner - (text.rfind("\n", 0, corner) + 1)
    width = text.index(_HEAVY[0][2], corner) - corner + 1
    begin = 0
    for row in text.split("\n"):
        if row[left : left + 1] in (_HEAVY[0][0], _HEAVY[1], _HEAVY[2][0]):
            at = begin + left
            content = content.stylize("$background on $accent", at, at + width)
            is_edge = row[left] != _HEAVY[1]
            for start, end in ((0, width),) if is_edge else ((0, 1), (width - 1, width)):
                content = content.stylize("$accent", at + start, at + end)
        begin += len(row) + 1
    return content


def rows_of_chosen(text: str) -> range:
    """Return the rows of what is chosen in drawn options; none if nothing is."""
    signs = (_ARROW, _MARK, _HEAVY[0][0], _HEAVY[2][0])
    rows = [
        number for number, row in enumerate(text.split("\n")) if any(sign in row for sign in signs)
    ]
    return range(rows[0], rows[-1] + 1) if rows else range(0)


def _line(step: Step, entry: Entry, columns: int) -> str:
    place, length = entry.place, max(_SHORTEST_LINE, min(_LINE, columns - 2))
    line = "─" * length
    if place is not None:
        at = round(place / FULL * (length - 1))
        line = f"{line[:at]}{_MARK}{line[at + 1 :]}"
    return _with_ends([f"├{line}┤"], step.labels)


def _with_ends(rows: list[str], labels: tuple[str, ...]) -> str:
    """Return rows with words below their ends, on one line if they fit."""
    width = len(rows[0])
    ends = []
    if labels:
        low, high = labels
        gap = width - len(low) - len(high)
        ends = [f"{low}{' ' * gap}{high}"] if gap > 1 else [low, high.rjust(width)]
    return _block([*rows, *ends], width)


def _list(step: Step, entry: Entry, columns: int) -> str:
    """Return the options one below the other, or in columns, with an arrow before what is chosen or
    pointed at.
    """
    several = step.kind == "choices"
    digits = max(len(point.typed) for point in points(step))
    lines = []
    for index, point in enumerate(points(step)):
        is_chosen = index in entry.chosen
        box = ("[x] " if is_chosen else "[ ] ") if several else ""
        is_at = index == entry.place if several else is_chosen
        before = f"{_ARROW if is_at else ' '} {box}{point.typed.rjust(digits)}  "
        width = max(_NARROWEST_LABEL, columns - len(before))
        label = textwrap.wrap(point.label, width, break_on_hyphens=False)
        indent = " " * len(before)
        lines.append((before + f"\n{indent}".join(label)).rstrip())
    if len(points(step)) > _TALL and not any("\n" in line for line in lines):
        lines = _in_columns(lines, columns)
    rows = [row for line in lines for row in line.split("\n")]
    return _block(rows, max(map(len, rows)))


def _in_columns(lines: Sequence[str], room: int) -> list[str]:
    """Return lines in columns beside each other, which are longer where too few have room."""
    for length in range(_COLUMN_ROWS, len(lines) + 1):
        columns = [lines[start : start + length] for start in range(0, len(lines), length)]
        widths = [max(map(len, column)) for column in columns]
        if sum(widths) + 2 * (len(widths) - 1) <= room:
            break
    return [
        "  ".join(
            column[row].ljust(width)
            for column, width in zip(columns, widths, strict=True)
            if row < len(column)
        )
        for row in range(length)
    ]


def _block(lines: list[str], width: int) -> str:
    """Return lines of one width, so that centring keeps their beginnings below each other."""
    return "\n".join(line.ljust(width).replace(" ", _GAP) for line in lines)
