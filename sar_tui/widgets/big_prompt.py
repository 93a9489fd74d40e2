"""Widget of the prompt: very large, and as a plain line for screen readers and tests."""

import functools
from collections.abc import Callable, Sequence

from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region, Size
from textual.strip import Strip
from textual.widget import Widget

from sar_tui.framework.messages import Prompt
from sar_tui.widgets.prompt_lines import Line, answer_lines, plain_lines

DrawPrompt = Callable[[Prompt | None, int, int], Sequence[Line]]
"""Draws a prompt, or the fixation point, in a number of columns and rows."""


class BigPrompt(Widget):
    """Shows one prompt or a fixation point. A change repaints its own region only, never the layout.

    Args:
        draw: draws the prompt (see `task_view.TaskView.prompt_lines`).
    """

    DEFAULT_CSS = "BigPrompt { height: 1fr; width: 1fr; }"

    def __init__(self, id: str | None = None, draw: DrawPrompt = plain_lines) -> None:
        super().__init__(id=id)
        self._draw = draw
        self._prompt: Prompt | None = None
        self._answer: Callable[[int, int], Sequence[Line]] | None = None
        self._lines: Sequence[Line] = ()
        self._drawn_for: Size | None = None

    def show(self, prompt: Prompt) -> None:
        """Show a prompt."""
        self._change(prompt)

    def show_answer(self, text: str, halves: tuple[str, ...] = ()) -> None:
        """Show the answer to a trial, in the same place; for two seats, in the halves of the screen."""
        self._change(None, lambda width, height: answer_lines(text, halves, width, height))

    def clear(self) -> None:
        """Show the fixation point only."""
        self._change(None)

    def redraw(self) -> None:
        """Draw again what is shown; paint it only if it looks different."""
        before, regions = self._lines, self._regions()
        self._draw_lines()
        if self._lines != before:
            self.refresh(*regions, *self._regions())

    def _change(self, prompt: Prompt | None, answer: Callable[[int, int], Sequence[Line]] | None = None) -> None:
        before = self._regions()
        self._prompt, self._answer = prompt, answer
        self._draw_lines()
        self.refresh(*before, *self._regions())

    def _regions(self) -> list[Region]:
        """Return the regions that hold text: a small frame reaches the terminal in one piece."""
        return [
            Region(_indent(line), y, cell_len(line.strip()), 1)
            for y, (line, _) in enumerate(self._lines)
            if line.strip()
        ]

    def _draw_lines(self) -> None:
        draw = self._answer or functools.partial(self._draw, self._prompt)
        self._lines = draw(*self.size) if self.size else ()
        self._drawn_for = self.size

    def render_line(self, y: int) -> Strip:
        if self._drawn_for != self.size:
            self._draw_lines()
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
                Segment(" " * max(0, width - left - cell_len(text)), style),
            ]
        ).adjust_cell_length(width, style)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())
