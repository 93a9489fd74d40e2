"""Filter of all lines on the Linux console, whose font has few characters: the others become
similar ones.

The console draws one sign for all characters that its font lacks. Known are the fonts of Debian's
and Ubuntu's console-setup (Fixed, Terminus and VGA, with the sets Lat15 and Uni2): of what the apps
draw they lack half blocks, fine bars, braille, rings and arcs.
"""

import os

from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

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
"""Each missing character with a similar one of the same width."""
_TABLE = str.maketrans(_SIMILAR)


def on_linux_console() -> bool:
    """Return True if the terminal is the console of Linux itself."""
    return os.environ.get("TERM") == "linux"


class ConsoleGlyphs(LineFilter):
    """Filter of Textual, which the lines of every widget pass."""

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
