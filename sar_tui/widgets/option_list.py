"""A list of options that can be turned over by pages at any time."""

from typing import Literal

from textual import events
from textual.widgets import OptionList as TextualOptionList


class OptionList(TextualOptionList):
    """Textual's list, without two of its failures.

    It fails on Page Up and Page Down before it is laid out, or without a column to stand in; and on
    a click at an option that has been taken away and still stands on the screen.
    """

    async def _on_click(self, event: events.Click) -> None:
        if event.style.meta.get("option", 0) >= self.option_count:
            event.prevent_default()

    def _move_page(self, direction: Literal[-1, 1]) -> None:
        if self._lines and (self.highlighted or 0) in self._index_to_line:
            super()._move_page(direction)
