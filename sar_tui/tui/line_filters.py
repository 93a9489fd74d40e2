"""Filters of all lines that the apps draw: of characters that a terminal would obey, and, on the
Linux console, of characters that its font lacks.
"""

import os

from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from sar_tui.model.visible_text import visible


class VisibleLines(LineFilter):
    """Makes characters visible that a terminal would obey. A changed line keeps its width."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        if all(segment.control or visible(segment.text) == segment.text for segment in segments):
            return segments
        width = sum(segment.cell_length for segment in segments)
        return Segment.adjust_line_length(_shown(segments), width, pad=False)


def _shown(segments: list[Segment]) -> list[Segment]:
    """Return the line with signs, which take the place of the next spaces, so that a border stays
    where it is.
    """
    found, wider = [], 0
    for segment in segments:
        sign = segment if segment.control else segment._replace(text=visible(segment.text))
        wider += sign.cell_length - segment.cell_length
        spaces = min(wider, len(sign.text) - len(sign.text.rstrip(" ")))
        wider -= spaces
        found.append(sign._replace(text=sign.text[: len(sign.text) - spaces]))
    return found


_SIMILAR = {
    "◠": "^",
    "‿": "_",
    "◉": "o",
    "○": "o",
    "▽": "v",
    "◁": "<",
    "▷": ">",
    "✓": "*",
    "▌": "│",
    "▐": "│",
    "▏": "│",
    "▎": "│",
    "▔": " ",
    "▁": "_",
    "▂": "_",
    "▃": "░",
    "▀": "▒",
    "▄": "▒",
    "▅": "▒",
    "▆": "█",
    "▇": "█",
    "⠀": " ",
    **{chr(dots): "·" for dots in range(0x2801, 0x2900)},
}
"""Each missing character with a similar one of the same width.

The console draws one sign for all characters that its font lacks. Known are the fonts of Debian's
and Ubuntu's console-setup (Fixed, Terminus and VGA, with the sets Lat15 and Uni2): of what the apps
draw they lack half blocks, fine bars, braille, rings and arcs.
"""
_TABLE = str.maketrans(_SIMILAR)


def on_linux_console() -> bool:
    """Return True if the terminal is the console of Linux itself."""
    return os.environ.get("TERM") == "linux"


class ConsoleGlyphs(LineFilter):
    """Replaces characters that the console's font lacks by similar ones."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment
            if segment.control or segment.text.isascii()
            else segment._replace(text=drawn(segment.text))
            for segment in segments
        ]


def drawn(text: str) -> str:
    """Return a text with characters that a console's font has; it keeps its length and width."""
    return text.translate(_TABLE)
