"""Very large characters: bitmaps of about 8 by 8, drawn in blocks at the largest size that fits.

Letters without accents, digits and punctuation come from a font; `letter_shapes` has the rest.
Characters that have no large shape, such as Han or emoji, are drawn at the terminal's own size, in
a frame.
"""

import unicodedata
from functools import cache

from pyfiglet import Figlet
from rich.cells import cell_len, set_cell_size

from sar_tui.widgets.letter_shapes import LETTERS, MARKS_ABOVE, MARKS_BELOW, SYMBOLS, Shape

FONT = "clb8x8"
"""A font that distinguishes I, l and 1, O and 0."""
_WIDTH = 9
"""Columns of a character, with the gap to the next one."""
_NARROW, _GAP = ".,", "  "
"""Characters that are as wide as their dots, and the gap to the next one."""
_WITHOUT_DOT = {"i": "ı", "j": "ȷ"}
_SPACE = (" " * 5,) * 8
"""The gap between words is narrower than a character."""


@cache
def _figlet() -> Figlet:
    return Figlet(font=FONT, width=400)


@cache
def bitmap(text: str) -> tuple[str, ...]:
    """Return the rows of a text, ``#`` for a dot; empty if one of its characters has no large
    shape.
    """
    if unknown(text):
        return ()
    return _cropped(tuple(row for line in text.splitlines() for row in _line(line)))


def unknown(text: str) -> list[str]:
    """Return the characters of a text that have no large shape, each once."""
    found = (
        letter for line in text.splitlines() for letter in letters(line) if not _shape(letter)[0]
    )
    return list(dict.fromkeys(found))


def _line(text: str) -> Shape:
    """Return the rows of a line of known characters, which stand on the same base."""
    shapes = [_shape(letter) for letter in letters(text)]
    above = max((up for _, up in shapes), default=0)
    placed = [(*(" " * len(rows[0]),) * (above - up), *rows) for rows, up in shapes]
    height = max(map(len, placed), default=0)
    return tuple(
        "".join(shape[y] if y < len(shape) else " " * len(shape[0]) for shape in placed)
        for y in range(height)
    )


def letters(text: str) -> list[str]:
    """Split a text into characters, each with the marks that belong to it."""
    found: list[str] = []
    for character in unicodedata.normalize("NFC", text):
        if found and unicodedata.combining(character):
            found[-1] += character
        else:
            found.append(character)
    return found


@cache
def _shape(letter: str) -> tuple[Shape, int]:
    """Return the rows of a character, a gap included, and how many of them are above row 0; no rows
    if unknown.
    """
    if letter == " ":
        return _SPACE, 0
    base, *marks = list(unicodedata.normalize("NFD", letter))
    if any(mark in MARKS_ABOVE for mark in marks):
        base = _WITHOUT_DOT.get(base, base)
    rows, above = _base(base), 0
    for mark in marks if rows else ():
        if over := MARKS_ABOVE.get(mark):
            rows, more = _marked_above(rows, over)
            above += more
        elif under := MARKS_BELOW.get(mark):
            rows = _marked_below(rows, under)
        else:
            return (), 0
    if letter in _NARROW:
        rows = _cropped(rows)
        return tuple(f"{row}{_GAP}" for row in rows), above
    return tuple(row.ljust(_WIDTH) for row in rows), above


def _base(letter: str) -> Shape:
    """Return the rows of a character without marks."""
    if known := SYMBOLS.get(letter) or LETTERS.get(letter):
        return known
    rows = [row.rstrip("\n") for row in str(_figlet().renderText(letter)).splitlines()]
    return tuple(rows) if any("#" in row for row in rows) else ()


def _marked_above(rows: Shape, mark: Shape) -> tuple[Shape, int]:
    """Put a mark a row above a character's topmost dot. Returns the number of rows that it adds on
    top, too.
    """
    top = next(y for y, row in enumerate(rows) if "#" in row)
    marked = (*_under_or_over(rows, mark), " " * len(rows[0]))
    more = max(0, len(marked) - top)
    return (*(" " * len(rows[0]),) * max(0, top - len(marked)), *marked, *rows[top:]), more


def _marked_below(rows: Shape, mark: Shape) -> Shape:
    """Hang a mark from a character's lowest dot."""
    bottom = max(y for y, row in enumerate(rows) if "#" in row)
    return (*rows[: bottom + 1], *_under_or_over(rows, mark))


def _under_or_over(rows: Shape, mark: Shape) -> Shape:
    """Return a mark as wide as a character, in the middle of its dots."""
    width = len(rows[0])
    inked = [x for x in range(width) if any(row[x] == "#" for row in rows)]
    left = max(0, (inked[0] + inked[-1] + 1 - len(mark[0])) // 2)
    return tuple((" " * left + row).ljust(width) for row in mark)


def _cropped(rows: tuple[str, ...]) -> tuple[str, ...]:
    """Return rows of equal length without the blank columns at their sides; none if no dot is in
    them.
    """
    inked = [row for row in rows if row.strip()]
    if not inked:
        return ()
    width = max(len(row.rstrip()) for row in inked)
    left = min(len(row) - len(row.lstrip()) for row in inked)
    return tuple(row.ljust(width)[left:width] for row in rows)


@cache
def draw(text: str, columns: int, rows: int) -> tuple[str, ...]:
    """Draw a text as large as fits into ``columns`` by ``rows`` cells; in a frame if it cannot be
    drawn large.

    A terminal's cell is about twice as high as wide, so a dot is two columns wide for each row.
    """
    dots = bitmap(text)
    if not dots:
        return small(text, columns, rows)
    scale = min(columns // (2 * len(dots[0])), rows // len(dots), 3)
    if scale:
        lines = [
            "".join("█" * (2 * scale) if dot == "#" else " " * (2 * scale) for dot in row)
            for row in dots
        ]
        return tuple(line for line in lines for _ in range(scale))
    if len(dots[0]) <= columns and len(dots) <= 2 * rows:
        return _half_blocks(dots)
    return small(text, columns, rows)


def is_large(text: str, columns: int, rows: int) -> bool:
    """Return True if `draw` draws a text large."""
    return draw(text, columns, rows) != small(text, columns, rows)


def small(text: str, columns: int, rows: int) -> tuple[str, ...]:
    """Draw a text at the terminal's own size, in a frame if there is room for it."""
    lines = text.splitlines() or [""]
    width = max(map(cell_len, lines))
    if not text.strip() or width + 4 > columns or len(lines) + 2 > rows:
        return tuple(cut(line, columns) for line in lines[: max(1, rows)])
    edge = "─" * (width + 2)
    return (f"┌{edge}┐", *(f"│ {set_cell_size(line, width)} │" for line in lines), f"└{edge}┘")


def cut(text: str, columns: int) -> str:
    """Return as much of a text as fits into a number of columns, of which a wide character takes
    two.
    """
    return text if cell_len(text) <= columns else set_cell_size(text, columns)


def _half_blocks(dots: tuple[str, ...]) -> tuple[str, ...]:
    """Draw two rows of dots in one row of cells."""
    blank = " " * len(dots[0])
    padded = (*dots, blank) if len(dots) % 2 else dots
    shapes = {"##": "█", "# ": "▀", " #": "▄", "  ": " "}
    return tuple(
        "".join(
            shapes[upper + lower] for upper, lower in zip(padded[i], padded[i + 1], strict=True)
        )
        for i in range(0, len(padded), 2)
    )
