"""Area for a drawing of a task's view, drawn again when its size changes."""

from rich.text import Text
from textual.widget import Widget

from sar_tui.widgets.task_view import Drawing


class DrawingArea(Widget):
    """Shows a drawing, and takes no room without one."""

    DEFAULT_CSS = "DrawingArea { height: 1fr; min-height: 6; display: none; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._drawing: Drawing | None = None

    def show(self, drawing: Drawing | None) -> None:
        """Show a drawing; None for nothing."""
        self._drawing = drawing
        self.display = drawing is not None
        self.refresh()

    def render(self) -> Text:
        width, height = self.content_size
        if not self._drawing or not width or not height:
            return Text("")
        return self._drawing(width, height, self.app.theme_variables)
