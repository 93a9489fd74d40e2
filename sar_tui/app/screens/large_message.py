"""A text of the session's screen, larger where there is room. Pure."""

from typing import NamedTuple

from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.widgets.large_characters import bitmap, draw

ROOMY = (100, 30)
"""Least columns and rows of a window in which texts are larger."""
_LETTER, _HEIGHT = 8, 4
"""Columns and rows of a large letter, drawn in half blocks."""


class Message(NamedTuple):
    """Parts of a message, from top to bottom. ``key``: the key to press, drawn; empty if its name
    is in ``press``.
    """

    headline: str
    text: str
    key: str
    press: str


def is_roomy(columns: int, rows: int) -> bool:
    """Return True if texts are larger in a window of this size."""
    return columns >= ROOMY[0] and rows >= ROOMY[1]


def rows_of(text: WaitingText, width: int) -> int:
    """Return the rows of a message as it is written, with the blank ones between its parts."""
    parts = [_rows(part, width) for part in (text.headline, text.text, text.press) if part]
    return sum(parts) + max(0, len(parts) - 1)


def large_message(text: WaitingText, width: int, height: int, *, more: int = 0) -> Message:
    """Return a message for ``width`` by ``height`` cells: with the key drawn large, more air, and a
    large headline of one word.

    Each of these, in this order, only if there is room; the words are never left out.

    Args:
        text: the message.
        width, height: of the part of the screen that is for it.
        more: rows of what else is shown there.
    """
    rows = (
        height
        - more
        - _rows(text.headline, width)
        - _rows(text.text, width)
        - _rows(text.press, width)
        - 4
    )
    key, headline, lines = "", text.headline, text.text
    if drawn := _drawn(text.key, width, rows - 1):
        key, rows = "\n".join(drawn), rows - len(drawn) - 1
    if 0 < (air := text.text.count("\n") - 2 * text.text.count("\n\n")) <= rows:
        lines, rows = "\n\n".join(part for part in text.text.split("\n") if part), rows - air
    if " " not in text.headline and (drawn := _drawn(text.headline, width, rows)):
        headline = "\n".join(drawn)
    return Message(headline, lines, key, text.press)


def _drawn(text: str, width: int, rows: int) -> tuple[str, ...]:
    """Draw a text in large letters, all lines equally long; nothing if there is no room, or no such
    letter.
    """
    if (
        any(not bitmap(letter) for letter in text if letter != " ")
        or len(text) * _LETTER > width
        or rows < _HEIGHT
    ):
        return ()
    drawn = draw(text, width, _HEIGHT) if text else ()
    if len(drawn) != _HEIGHT:
        return ()
    longest = max(map(len, drawn))
    return tuple(line.ljust(longest) for line in drawn)


def _rows(text: str, width: int) -> int:
    return sum(-(-max(1, len(line)) // max(1, width)) for line in text.split("\n")) if text else 0
