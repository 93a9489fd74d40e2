"""Progress, in words and as a line."""

from textual.content import Content
from textual.widget import Widget

from sar_tui.widgets.language import language_of


class ProgressLine(Widget):
    """Shows "Prompts 3 of 20 ━━───────". It has no timer, and changes only by ``show``."""

    DEFAULT_CSS = "ProgressLine { height: 1; width: 1fr; margin-right: 2; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._what, self._done, self._total = "", 0, 0

    def show(self, what: str, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` are done; ``what`` is in the screen's language."""
        self._what, self._done, self._total = what, done, total
        self.refresh()

    def render(self) -> Content:
        tr = language_of(self.app)
        words = (
            tr("{what} {done} of {total}", what=self._what, done=self._done, total=self._total)
            + " "
        )
        room = max(0, self.size.width - len(words))
        done = room * min(self._done, self._total) // max(1, self._total)
        return Content.assemble(
            (words, "$text-muted"),
            ("━" * done, "$accent"),
            ("─" * (room - done), "$text-muted 50%"),
        )
