"""A list of options that can be turned over by pages at any time."""

from typing import Literal

from textual.widgets import OptionList as TextualOptionList


class OptionList(TextualOptionList):
    """Textual's list, which fails on Page Up and Page Down before it is laid out, or without a column to stand in."""

    def _move_page(self, direction: Literal[-1, 1]) -> None:
        if self._lines and (self.highlighted or 0) in self._index_to_line:
            super()._move_page(direction)
