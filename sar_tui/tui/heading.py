"""The sentence at the head of a screen, in the largest of four sizes that the window has room for
(docs/design-language.md).
"""

import re
from collections.abc import Iterator, Sequence

from textual.content import Content
from textual.geometry import Size
from textual.widget import Widget

from sar_tui.model.line_breaks import spaced

ROOMY = (100, 30)
"""Least columns and rows of a window in which texts are larger."""
_LETTER = 9
"""Columns of a letter in half blocks, with the gap to the next one."""
ONE_LINE, TWO_LINES = 4, 9
"""Rows of one and of two lines in half blocks."""
TALL = 40
"""Least rows of a window in which a sentence may take two lines of large letters, beside all else."""
_HEIGHTS = (8, ONE_LINE)
"""Rows of a letter in whole blocks and in half blocks; a letter in whole blocks is twice as wide."""
_MOST_LINES = 2
"""Lines of a sentence; of one in half blocks that may take the whole screen, as many as it takes."""
_FIGURES = re.compile(r"\d+(?:[.,]\d+)?(?: \w+ \d+)?")
"""A number, or two with a word between them: ``9 of 10``."""


def is_roomy(columns: int, rows: int) -> bool:
    """Return True if texts are larger in a window of this size."""
    return columns >= ROOMY[0] and rows >= ROOMY[1]


def most_rows(size: Size) -> int:
    """Return the most rows of a sentence that shares a window of this size with other things."""
    return TWO_LINES if size.height >= TALL else ONE_LINE


def in_blocks(text: str, columns: int, rows: int) -> list[str]:
    """Return the lines of a text drawn in block letters; none if there is no room for it.

    It may be broken between words once; in half blocks, as often as there is room.

    Args:
        text: the text; nothing is drawn of one with characters that have no large shape.
        columns, rows: the most that the drawing may take.
    """
    # its fonts take longer to load than the rest of the first frame's modules
    from sar_tui.widgets.large_characters import bitmap, draw

    if not text or any(not bitmap(letter) for letter in text if letter != " "):
        return []
    for height in _HEIGHTS:
        gap = 2 if height == _HEIGHTS[0] else 1
        lines = _even(list(_wrapped(text, (columns + gap) // (_LETTER * gap))))
        fitting = (rows + 1) // (height + 1)
        if lines and len(lines) <= (fitting if gap == 1 else min(fitting, _MOST_LINES)):
            drawn = [draw(line, columns, height) for line in lines]
            if all(len(letters) == height for letters in drawn):
                rows_of_lines = (row for letters in drawn for row in (*_block(letters), ""))
                return list(rows_of_lines)[:-1]
    return []


def figures_in_blocks(text: str, columns: int, *, is_below: bool = False) -> list[str]:
    """Return the lines of a text with its first figures in block letters; none if it does not
    begin with figures, or if there is no room.

    Args:
        text: the text.
        columns: the most that it may take.
        is_below: the words are in the middle below the figures, in spaced capitals, else beside
            their last row.
    """
    if not (found := _FIGURES.match(text)):
        return []
    words = text[found.end() :]
    drawn = in_blocks(found[0], columns if is_below else columns - len(words), ONE_LINE)
    if not drawn:
        return []
    if is_below:
        words = spaced(words.strip(), columns)
        width = max(len(words), *map(len, drawn))
        return _block([*(row.center(width) for row in drawn), "", words.center(width)])
    return _block([*drawn[:-1], drawn[-1] + words])


def _wrapped(text: str, letters: int) -> Iterator[str]:
    """Break a text between words into lines of so many letters; nothing if a word is longer."""
    line = ""
    words = text.split(" ")
    if max(map(len, words)) > letters:
        return
    for word in words:
        if line and len(line) + 1 + len(word) > letters:
            yield line
            line = word
        else:
            line = f"{line} {word}".strip()
    yield line


def _even(lines: list[str]) -> list[str]:
    """Return two lines broken where both are about as long, the first one rather the shorter: that
    is more often between phrases.
    """
    if len(lines) != 2:
        return lines
    words = " ".join(lines).split(" ")
    broken = ([" ".join(words[:at]), " ".join(words[at:])] for at in range(1, len(words)))
    return min(broken, key=lambda two: max(map(len, two)))


def _block(rows: Sequence[str]) -> list[str]:
    """Return rows of one width that keep it where each line is centred."""
    width = max(map(len, rows))
    return [row.ljust(width).replace(" ", "\N{NO-BREAK SPACE}") for row in rows]


class Heading(Widget):
    """The one sentence of a screen. It changes only by ``show``, and with the window's size.

    Args:
        text: the sentence.
        largest: the most rows that it may take; 1: it is never drawn in block letters.
        classes: ``well-done`` for praise, which is written in spaced capitals in a small window.
    """

    DEFAULT_CSS = "Heading { width: 100%; height: auto; }"

    def __init__(
        self,
        text: str = "",
        *,
        largest: int = 1,
        id: str | None = None,
        classes: str = "sentence",
    ) -> None:
        super().__init__(id=id, classes=classes)
        self.text, self._largest = text, largest

    def show(self, text: str, largest: int | None = None) -> None:
        """Show a sentence; empty: nothing, and no room is taken.

        Args:
            text: the sentence.
            largest: the most rows that it may take from now on; None: as many as before.
        """
        self.text = text
        self._largest = self._largest if largest is None else largest
        self.display = bool(text)
        self.refresh(layout=True)

    def _lines(self, columns: int) -> list[str]:
        if is_roomy(*self.app.size) and (drawn := in_blocks(self.text, columns, self._largest)):
            return drawn
        return [spaced(self.text, columns) if self.has_class("well-done") else self.text]

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return self._content(width).get_height({}, max(1, width))

    def _content(self, columns: int) -> Content:
        return Content("\n".join(self._lines(columns)))

    def render(self) -> Content:
        return self._content(self.content_size.width)
