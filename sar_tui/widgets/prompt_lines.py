"""A prompt as lines of text: drawn large, above its plain line. No Textual is needed to draw it."""

from collections.abc import Sequence

from rich.cells import cell_len, set_cell_size

from sar_tui.model.messages import Prompt
from sar_tui.widgets.large_characters import cut, draw

FIXATION = "·"
_WALL = "│"
Line = tuple[str, bool]
"""A line at its full indentation, and whether it is bold."""


def plain_lines(prompt: Prompt | None, width: int, height: int) -> list[Line]:
    """Draw a prompt in the middle of ``width`` by ``height`` cells; without a prompt, the fixation
    point.
    """
    if prompt and prompt.halves:
        return halves(prompt.halves, prompt.text, width, height)
    if prompt is None:
        return with_text((FIXATION,), "", "", width, height)
    drawn = draw(prompt.glyph, *room(width, height)) if prompt.glyph else ()
    return with_text(drawn, prompt.text, prompt.hint, width, height)


def answer_lines(text: str, sides: Sequence[str], width: int, height: int) -> list[Line]:
    """Draw the answer to a trial in the place of its prompt; ``sides``: those of two seats, if they
    differ.
    """
    if sides:
        return halves(sides, text, width, height)
    return with_text(draw(text, *room(width, height)), text, "", width, height)


def room(width: int, height: int) -> tuple[int, int]:
    """Return the columns and rows that a prompt's drawing has on a stage of ``width`` by ``height``
    cells.
    """
    return width - 2, height - 3


def with_text(drawn: Sequence[str], text: str, hint: str, width: int, height: int) -> list[Line]:
    """Put what is drawn large in the middle, with its plain line and a hint below it."""
    block = [*((line, True) for line in drawn), ("", False), (text, True), (hint, False)]
    top = max(0, (height - len(block)) // 2)
    return [("", False)] * top + [(centred(line, width), bold) for line, bold in block]


def centred(line: str, width: int) -> str:
    """Indent a line so that it stands in the middle of ``width`` cells."""
    return " " * max(0, (width - cell_len(line)) // 2) + line


def halves(
    glyphs: Sequence[str], text: str, width: int, height: int, names: Sequence[str] = ("", "")
) -> list[Line]:
    """Draw two halves below their names, with a wall between them, and without glyphs the fixation
    point on it.
    """
    half = max(0, (width - 1) // 2)
    room = max(1, height - 4)
    bodies = [draw(glyph, max(1, half - 2), room) if glyph else () for glyph in glyphs or ("", "")]
    body = []
    for row in range(room):
        left, right = (_row(lines, row, room) for lines in bodies)
        wall = FIXATION if row == room // 2 and not glyphs else _WALL
        body.append((_beside(left, wall, right, half), True))
    named = (_beside(names[0], _WALL, names[1], half), True)
    return [
        named,
        (_beside("", _WALL, "", half), False),
        *body,
        ("", False),
        (centred(text, width), True),
    ]


def _row(lines: Sequence[str], row: int, room: int) -> str:
    """Return the text in a row if ``lines`` are in the middle of ``room`` rows."""
    at = row - (room - len(lines)) // 2
    return lines[at] if 0 <= at < len(lines) else ""


def _beside(left: str, wall: str, right: str, half: int) -> str:
    """Put two texts beside each other, each in the middle of its half."""
    return f"{set_cell_size(centred(cut(left, half), half), half)}{wall}{centred(cut(right, half), half)}"
