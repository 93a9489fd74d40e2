"""Filter of all lines that the apps draw: characters that a terminal would obey become visible."""

from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from sar_tui.model.visible_text import visible


class VisibleLines(LineFilter):
    """Filter of Textual, which the lines of every widget pass. A changed line keeps its width."""

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
