"""The prompt: very large, and as one plain line of text for screen readers and tests."""

from collections.abc import Sequence

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region, Size
from textual.strip import Strip
from textual.widget import Widget

from sar_tui.widgets.glyphs import draw

FIXATION = "·"
_WALL = "│"
_Line = tuple[str, bool]
"""A line in full, and whether it is bold."""


class BigPrompt(Widget):
    """Shows one prompt or a fixation point. A change repaints its own region only, never the layout.

    Args:
        names: of the halves, left and right, where the screen is divided between two people.
    """

    DEFAULT_CSS = "BigPrompt { height: 1fr; width: 1fr; }"

    def __init__(self, id: str | None = None, names: Sequence[str] = ()) -> None:
        super().__init__(id=id)
        self._names = tuple(names)
        self._glyph: str | None = None
        self._halves: tuple[str, ...] = ()
        self._text = ""
        self._hint = ""
        self._lines: list[_Line] = []
        self._composed_for: Size | None = None

    def show(self, glyph: str, text: str, hint: str = "", halves: Sequence[str] = ()) -> None:
        """Put a prompt up: drawn large, with ``text`` as it is on a line of its own.

        ``halves``: what is drawn in the left and in the right half instead.
        """
        self._change(glyph, text, hint, halves)

    def clear(self) -> None:
        """Show the fixation point only."""
        self._change(None, "", "")

    def name_halves(self, names: Sequence[str]) -> None:
        """Say whose each half is, and what else has to be known of them."""
        if tuple(names) != self._names:
            self._names = tuple(names)
            self._change(self._glyph, self._text, self._hint, self._halves)

    def _change(self, glyph: str | None, text: str, hint: str, halves: Sequence[str] = ()) -> None:
        before = self._regions()
        self._glyph, self._text, self._hint, self._halves = glyph, text, hint, tuple(halves)
        self._compose_lines()
        self.refresh(*before, *self._regions())

    def _regions(self) -> list[Region]:
        """Where something stands: a small frame reaches the terminal in one piece."""
        return [
            Region(_indent(line), y, len(line.strip()), 1) for y, (line, _) in enumerate(self._lines) if line.strip()
        ]

    def _compose_lines(self) -> None:
        width, height = self.size
        if self._names:
            self._lines = self._divided(width, height)
        else:
            drawn = draw(self._glyph, width - 2, height - 3) if self._glyph else (FIXATION,)
            block = [*((line, True) for line in drawn), ("", False), (self._text, True), (self._hint, False)]
            top = max(0, (height - len(block)) // 2)
            self._lines = [("", False)] * top + [(_centred(line, width), bold) for line, bold in block]
        self._composed_for = self.size

    def _divided(self, width: int, height: int) -> list[_Line]:
        """A name at the top of each half, what stands in it below, and the plain line at the foot."""
        half = max(0, (width - 1) // 2)
        room = max(1, height - 4)
        bodies = [draw(glyph, max(1, half - 2), room) if glyph else () for glyph in self._halves or ("", "")]
        middle = room // 2
        body = []
        for row in range(room):
            parts = [_row(lines, row, room) for lines in bodies]
            wall = FIXATION if row == middle and not self._halves else _WALL
            body.append((_beside(parts[0], wall, parts[1], half), True))
        named = (_beside(self._names[0], _WALL, self._names[1], half), True)
        return [named, (_beside("", _WALL, "", half), False), *body, ("", False), (_centred(self._text, width), True)]

    def render_line(self, y: int) -> Strip:
        if self._composed_for != self.size:
            self._compose_lines()
        width = self.size.width
        style = self.rich_style
        if y >= len(self._lines):
            return Strip.blank(width, style)
        line, bold = self._lines[y]
        left = _indent(line)
        text = line.strip()
        return Strip(
            [
                Segment(" " * left, style),
                Segment(text, style + Style(bold=bold)),
                Segment(" " * max(0, width - left - len(text)), style),
            ]
        ).adjust_cell_length(width, style)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _centred(line: str, width: int) -> str:
    return " " * max(0, (width - len(line)) // 2) + line


def _row(lines: Sequence[str], row: int, room: int) -> str:
    """A row of what is drawn in the middle of so many."""
    at = row - (room - len(lines)) // 2
    return lines[at] if 0 <= at < len(lines) else ""


def _beside(left: str, wall: str, right: str, half: int) -> str:
    """Two texts, each in the middle of its half, and what stands between."""
    return f"{_centred(left[:half], half):<{half}}{wall}{_centred(right[:half], half)}"
