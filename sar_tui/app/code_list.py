"""A list of people by their codes: typing finds one, and the chosen line is highlighted in full."""

from collections.abc import Sequence
from typing import Any

from rich.segment import Segment
from textual.events import Key
from textual.strip import Strip

from sar_tui.widgets.lists import MarkedList


class CodeList(MarkedList):
    """Base of lists of people. A list has ``found`` and ``draw``.

    Attributes:
        sought: the part of a code, or a word, that was typed.
    """

    app: Any

    def __init__(self, **how: Any) -> None:
        super().__init__(markup=False, **how)
        self.sought = ""

    def found(self) -> Sequence[str]:
        """Return the codes that have what was typed; all if nothing was typed."""
        raise NotImplementedError

    def draw(self, chosen: str | None) -> None:
        """List the people that are found, with one of them chosen."""
        raise NotImplementedError

    @property
    def code(self) -> str | None:
        """The code of the chosen person; None on another line."""
        return self.chosen

    @property
    def is_empty(self) -> bool:
        """True if nobody is known."""
        raise NotImplementedError

    def on_key(self, event: Key) -> None:
        """Narrow the list to the people with the typed characters; Escape shows all again, and who
        was chosen before.
        """
        typed = (event.character or "").upper()
        if event.key == "escape" and self.sought:
            sought = ""
        elif event.key == "backspace" and self.sought:
            sought = self.sought[:-1]
        elif not self.is_empty and len(typed) == 1 and (typed.isalnum() or typed in "-_"):
            sought = self.sought + typed
        else:
            return
        event.stop()
        event.prevent_default()
        before, self.sought = self.sought, sought
        if len(sought) > len(before) and not self.found():
            self.sought = before
            self.app.bell()
            return
        if event.key == "escape":
            self.draw(self._before)
        else:
            self.draw(self.code if not self.sought else self._best())

    def _best(self) -> str | None:
        """Return the first code that begins with what was typed; without one, the first found."""
        found = self.found()
        return next(
            (code for code in found if code.startswith(self.sought)), next(iter(found), None)
        )

    def render_line(self, y: int) -> Strip:
        """Draw a line; all words of the chosen one have the same colour."""
        strip = super().render_line(y)
        line = self.scroll_offset.y + y
        if line < len(self._lines) and self._lines[line][0] == self.highlighted:
            style = self.get_visual_style("option-list--option", "option-list--option-highlighted")
            return Strip(Segment.apply_style(strip, post_style=style.rich_style))
        return strip
