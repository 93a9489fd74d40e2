"""The prompt: very large, and as one plain line of text for screen readers and tests."""

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region, Size
from textual.strip import Strip
from textual.widget import Widget

from sar_tui.widgets.glyphs import draw

FIXATION = "·"


class BigPrompt(Widget):
    """Shows one prompt or a fixation point. A change repaints its own region only, never the layout."""

    DEFAULT_CSS = "BigPrompt { height: 1fr; width: 1fr; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._glyph: str | None = None
        self._text = ""
        self._hint = ""
        self._lines: list[tuple[str, bool]] = []
        self._composed_for: Size | None = None

    def show(self, glyph: str, text: str, hint: str = "") -> None:
        """Put a prompt up: drawn large, with ``text`` as it is on a line of its own."""
        self._change(glyph, text, hint)

    def clear(self) -> None:
        """Show the fixation point only."""
        self._change(None, "", "")

    def _change(self, glyph: str | None, text: str, hint: str) -> None:
        before = self._regions()
        self._glyph, self._text, self._hint = glyph, text, hint
        self._compose_lines()
        self.refresh(*before, *self._regions())

    def _regions(self) -> list[Region]:
        """Where something stands: a small frame reaches the terminal in one piece."""
        width = self.size.width
        return [
            Region(max(0, (width - len(line)) // 2), y, min(width, len(line)), 1)
            for y, (line, _) in enumerate(self._lines)
            if line
        ]

    def _compose_lines(self) -> None:
        width, height = self.size
        drawn = draw(self._glyph, width - 2, height - 3) if self._glyph else (FIXATION,)
        block = [*((line, True) for line in drawn), ("", False), (self._text, True), (self._hint, False)]
        top = max(0, (height - len(block)) // 2)
        self._lines = [("", False)] * top + block
        self._composed_for = self.size

    def render_line(self, y: int) -> Strip:
        if self._composed_for != self.size:
            self._compose_lines()
        width = self.size.width
        style = self.rich_style
        if y >= len(self._lines):
            return Strip.blank(width, style)
        line, bold = self._lines[y]
        left = max(0, (width - len(line)) // 2)
        return Strip(
            [
                Segment(" " * left, style),
                Segment(line, style + Style(bold=bold)),
                Segment(" " * max(0, width - left - len(line)), style),
            ]
        ).adjust_cell_length(width, style)
