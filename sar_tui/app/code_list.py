"""A list of people by their codes: typing finds one, and the chosen line is highlighted in full."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rich.segment import Segment
from textual.content import Content
from textual.events import Key
from textual.reactive import reactive
from textual.strip import Strip
from textual.widgets.option_list import Option

from sar_tui.widgets.lists import MarkedList

BESIDE = 3
"""Columns of a line's padding and the scroll bar."""
_LONGEST_CODE = 12
"""Longer codes are cut, so that there is room for what is said."""


class CodeList(MarkedList):
    """People, of whom those are listed whose code has what is typed.

    Attributes:
        sought: the part of a code, or a word, that was typed.
    """

    app: Any
    sought: reactive[str] = reactive("", repaint=False)

    def __init__(self, **how: Any) -> None:
        super().__init__(markup=False, **how)
        self._words: Mapping[str, str] = {}
        self._lines_of: Callable[[Sequence[str]], Iterable[Option]] = lambda codes: ()

    def list_people(
        self,
        words: Mapping[str, str],
        lines: Callable[[Sequence[str]], Iterable[Option]],
        chosen: str | None,
    ) -> None:
        """List people, with one of them chosen.

        Args:
            words: by which they are found if no code has what is typed, in capitals, by code.
            lines: returns the lines of some codes; the id of a person's line is the code.
            chosen: a code.
        """
        self._words, self._lines_of = words, lines
        if chosen and self.sought not in chosen:
            self.sought = ""
        self.draw(chosen)
        self._before = self.chosen

    def draw(self, chosen: str | None) -> None:
        """List the people that are found, with one of them chosen."""
        self.clear_options()
        self.add_options(self._lines_of(self.found()))
        self.choose(chosen)

    def found(self) -> list[str]:
        """Return the codes that have what was typed; without one, those of whom it is said."""
        by_code = [code for code in self._words if self.sought in code]
        return by_code or [code for code, said in self._words.items() if self.sought in said]

    @property
    def code(self) -> str | None:
        """The code of the chosen person; None on another line."""
        return self.chosen if self.chosen in self._words else None

    @property
    def is_empty(self) -> bool:
        """True if nobody is known."""
        return not self._words

    def find_words(self, otherwise: str) -> str:
        """Return what is sought, for the border; if nothing is, how to find somebody."""
        if self.sought:
            return str(self.app.tr("find: {typed} (Esc)", typed=self.sought))
        return "" if self.is_empty else otherwise

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


def code_width(codes: Iterable[str]) -> int:
    """Return the columns of some codes."""
    return min(_LONGEST_CODE, max(map(len, codes), default=0))


def code_cell(code: str, width: int) -> Content:
    """Return a code as a line begins with it."""
    return Content.styled(code, "bold").truncate(width, ellipsis=True, pad=True)
