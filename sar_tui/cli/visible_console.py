"""Console for tables and progress bars, with characters made visible that a terminal would obey."""

from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from sar_tui.cli.visible_output import KEPT
from sar_tui.model.visible_text import visible


class VisibleConsole(Console):
    """Console for texts from anywhere. Only what rich itself sends to the terminal are commands."""

    def render_str(self, text: str, **how: Any) -> Text:
        """Return a string as text. Done here, before its length is measured."""
        return super().render_str(visible(text, KEPT), **how)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield (
                segment if segment.control else Segment(visible(segment.text, KEPT), segment.style)
            )
