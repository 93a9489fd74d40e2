"""Filter of all lines that the apps draw: characters that a terminal would obey become visible."""

from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from sar_tui.framework.visible_text import visible


class VisibleLines(LineFilter):
    """Filter of Textual, which the lines of every widget pass. A changed line keeps its width."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        texts = [segment.text if segment.control else visible(segment.text) for segment in segments]
        if all(text == segment.text for text, segment in zip(texts, segments, strict=True)):
            return segments
        shown = [segment._replace(text=text) for text, segment in zip(texts, segments, strict=True)]
        return Segment.adjust_line_length(shown, sum(segment.cell_length for segment in segments), pad=False)
