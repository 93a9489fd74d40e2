"""Very large characters: an 8 by 8 bitmap, drawn in blocks at the largest size that fits."""

from functools import cache

from pyfiglet import Figlet

FONT = "clb8x8"
"""A font that distinguishes I, l and 1, O and 0."""

_ARROW_RIGHT = (
    "    #   ",
    "    ##  ",
    "    ### ",
    "########",
    "########",
    "    ### ",
    "    ##  ",
    "    #   ",
)
_ARROW_DOWN = tuple("".join(row[x] for row in _ARROW_RIGHT) for x in range(8))
_DRAWN = {
    "→": _ARROW_RIGHT,
    "←": tuple(row[::-1] for row in _ARROW_RIGHT),
    "↑": _ARROW_DOWN[::-1],
    "↓": _ARROW_DOWN,
}


@cache
def _figlet() -> Figlet:
    return Figlet(font=FONT, width=400)


@cache
def bitmap(text: str) -> tuple[str, ...]:
    """Return the rows of a text, ``#`` for a dot; empty if the font has no such character."""
    if text in _DRAWN:
        return _DRAWN[text]
    rows = [row.rstrip("\n") for row in str(_figlet().renderText(text)).splitlines()]
    if not any("#" in row for row in rows):
        return ()
    width = max(len(row.rstrip()) for row in rows)
    left = min(len(row) - len(row.lstrip()) for row in rows if row.strip())
    return tuple(row[left:width].ljust(width - left) for row in rows)


@cache
def draw(text: str, columns: int, rows: int) -> tuple[str, ...]:
    """Draw a text as large as fits into ``columns`` by ``rows`` cells; as plain text if that is too small.

    A terminal's cell is about twice as high as wide, so a dot is two columns wide for each row.
    """
    dots = bitmap(text)
    if not dots:
        return (text[:columns],)
    scale = min(columns // (2 * len(dots[0])), rows // len(dots), 3)
    if scale:
        lines = ["".join("█" * (2 * scale) if dot == "#" else " " * (2 * scale) for dot in row) for row in dots]
        return tuple(line for line in lines for _ in range(scale))
    if len(dots[0]) <= columns and len(dots) <= 2 * rows:
        return _half_blocks(dots)
    return (text[:columns],)


def _half_blocks(dots: tuple[str, ...]) -> tuple[str, ...]:
    """Draw two rows of dots in one row of cells."""
    blank = " " * len(dots[0])
    padded = (*dots, blank) if len(dots) % 2 else dots
    shapes = {"##": "█", "# ": "▀", " #": "▄", "  ": " "}
    return tuple(
        "".join(shapes[upper + lower] for upper, lower in zip(padded[i], padded[i + 1], strict=True))
        for i in range(0, len(padded), 2)
    )
