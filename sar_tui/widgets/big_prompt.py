"""Widget of the prompt: very large or as a picture, and as a plain line for screen readers and
tests.
"""

import functools
import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import Literal

from rich._palettes import STANDARD_PALETTE
from rich.cells import cell_len
from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region, Size
from textual.strip import Strip
from textual.widget import Widget

from sar_tui.loop.prompt_colors import OKABE_ITO, color_on
from sar_tui.model.contrast import contrast
from sar_tui.model.messages import Prompt
from sar_tui.widgets.prompt_lines import Line, answer_lines, plain_lines, room, with_text
from sar_tui.widgets.prompt_pictures import Drawn, Pictures, Way, overlay

DrawPrompt = Callable[[Prompt | None, int, int], Sequence[Line]]
"""Draws a prompt, or the fixation point, in a number of columns and rows."""
_FRAMES = re.compile("([─│┌┐└┘]+)")
"""Frames, and the wall between halves: never in the colour of the prompt."""


class BigPrompt(Widget):
    """Shows one prompt or a fixation point. A change repaints its own region only, never the
    layout.

    Args:
        draw: draws the prompt (see `task_view.TaskView.prompt_lines`).
        pictures: of the task; None if none can be shown.
    """

    DEFAULT_CSS = "BigPrompt { height: 1fr; width: 1fr; }"

    def __init__(
        self,
        id: str | None = None,
        draw: DrawPrompt = plain_lines,
        pictures: Pictures | None = None,
    ) -> None:
        super().__init__(id=id)
        self._draw = draw
        self._pictures = pictures
        self._prompt: Prompt | None = None
        self._answer: Callable[[int, int], Sequence[Line]] | None = None
        self._lines: Sequence[Line] = ()
        self._picture: Drawn | None = None
        self._to_come: Sequence[str] = ()
        self._strips: dict[tuple[int, Region], list[Strip]] = {}
        self._top = 0
        self._drawn_for: Size | None = None

    def show(self, prompt: Prompt) -> Way | Literal["", "none"]:
        """Show a prompt. Returns how its picture is drawn; empty if it has none."""
        self._change(prompt)
        if not prompt.picture:
            return ""
        return self._pictures.way_of(prompt.picture) if self._pictures else "none"

    def show_answer(self, text: str, halves: tuple[str, ...] = ()) -> None:
        """Show the answer to a trial, in the same place; for two seats, in the halves of the
        screen.
        """
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

    def prepare(self, pictures: Sequence[str]) -> None:
        """Prepare pictures that a prompt will soon show, so that its frame takes no longer for
        them.
        """
        self._to_come = pictures
        for name in pictures if self.size else ():
            if picture := self._drawn_picture(name):
                self._strips_of(picture)

    def on_resize(self) -> None:
        """Prepare for the new size, also for the first one: nothing could be prepared before."""
        self.prepare(self._to_come)

    def _change(
        self, prompt: Prompt | None, answer: Callable[[int, int], Sequence[Line]] | None = None
    ) -> None:
        before = self._regions()
        self._prompt, self._answer = prompt, answer
        self._draw_lines()
        self.refresh(*before, *self._regions())

    def _regions(self) -> list[Region]:
        """Return the regions that hold something: a small frame reaches the terminal in one
        piece.
        """
        rows = range(self._top, self._top + len(self._picture.rows)) if self._picture else range(0)
        return [
            Region(0, y, self.size.width, 1)
            if y in rows
            else Region(_indent(line), y, cell_len(line.strip()), 1)
            for y, (line, _) in enumerate(self._lines)
            if line.strip() or y in rows
        ]

    def _draw_lines(self) -> None:
        self._picture, self._lines = None, ()
        self._drawn_for = self.size
        if not self.size:
            return
        prompt = self._prompt
        if prompt and prompt.picture:
            self._picture = self._drawn_picture(prompt.picture)
        if prompt and self._picture:
            self._top = self._top_of(self._picture)
            self._lines = with_text(
                ("",) * len(self._picture.rows), prompt.text, prompt.hint, *self.size
            )
        else:
            draw = self._answer or functools.partial(self._draw, prompt)
            self._lines = draw(*self.size)

    def _drawn_picture(self, name: str) -> Drawn | None:
        """Return a picture for the present size; None if it cannot be shown."""
        if self._pictures is None:
            return None
        background = _hex(self.background_colors[1].rgb)
        return self._pictures.drawn(name, *room(*self.size), background)

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
                *self._coloured(text, style + Style(bold=bold)),
                Segment(" " * max(0, width - left - cell_len(text)), style),
            ]
        ).adjust_cell_length(width, style)

    def render_lines(self, crop: Region) -> list[Strip]:
        """Put the rows of a picture, which are prepared, between the lines that are drawn now."""
        strips = super().render_lines(crop)
        if self._picture:
            for y, row in enumerate(self._strips_of(self._picture), self._top - crop.y):
                if 0 <= y < len(strips):
                    strips[y] = row.crop(crop.x, crop.right)
        return strips

    def _strips_of(self, picture: Drawn) -> list[Strip]:
        """Return the rows of a picture as lines of the present width, rendered for this terminal.

        What is painted over the picture follows its last row. It must not pass the filters of
        lines, which would make its escape sequences visible.
        """
        key = (id(picture), self.region)
        if key not in self._strips:
            style, background = self.rich_style, self.background_colors[1]
            left = (self.size.width - picture.columns) // 2
            margins = (
                Segment(" " * left, style),
                Segment(" " * (self.size.width - left - picture.columns), style),
            )
            rows = [Strip([margins[0], *row, margins[1]], self.size.width) for row in picture.rows]
            for each in self.app.get_line_filters():
                rows = [row.apply_filter(each, background) for row in rows]
            if picture.overlay:
                painted = overlay(
                    picture, self.region.x + left, self.region.y + self._top_of(picture)
                )
                rows[-1] = Strip([*rows[-1], painted], self.size.width)
            for row in rows:
                row.render(self.app.console)  # the strip keeps it
            self._strips[key] = rows
        return self._strips[key]

    def _top_of(self, picture: Drawn) -> int:
        """Return the line on which a picture begins."""
        blank = ("",) * len(picture.rows)
        return len(with_text(blank, "", "", *self.size)) - len(blank) - 3

    def _coloured(self, text: str, style: Style) -> list[Segment]:
        """Return a line in the prompt's colour, except frames, and except the plain line."""
        color = self._color
        if color is None or not style.bold or not self._prompt or self._prompt.text == text:
            return [Segment(text, style)]
        parts = (part for part in _FRAMES.split(text) if part)
        return [
            Segment(part, style if _FRAMES.match(part) else style + Style(color=color))
            for part in parts
        ]

    @property
    def _color(self) -> Color | None:
        """The colour of the prompt; None for that of texts."""
        if not self._prompt or not self._prompt.colour:
            return None
        return prompt_color(
            self._prompt.colour, _hex(self.background_colors[1].rgb), self.app.console.color_system
        )


def _hex(rgb: tuple[int, int, int]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


_SIXTEEN = {
    "red": (9, 1),
    "orange": (3, 9),
    "yellow": (11, 3),
    "green": (10, 2),
    "sky blue": (14, 6),
    "blue": (12, 4),
    "purple": (13, 5),
}
"""Numbers of the nearest of a terminal's sixteen colours, on a dark and on a light background.

The nearest by Rich's measure are alike for some names: red and orange, green and blue.
"""


@cache
def prompt_color(name: str, background: str, color_system: str | None) -> Color | None:
    """Return the colour for a prompt; None for the colour of texts, as for a name that is not in
    the set.

    Args:
        name: of the colour; empty for none.
        background: as #rrggbb.
        color_system: of Rich's console: "truecolor", "256", "standard" …
    """
    if name not in OKABE_ITO:
        return None
    if color_system in ("standard", "windows"):
        is_light = contrast("#000000", background) > contrast("#ffffff", background)
        return Color.from_rgb(*STANDARD_PALETTE[_SIXTEEN[name][is_light]])
    return Color.parse(color_on(name, background))
