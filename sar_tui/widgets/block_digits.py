"""Numbers in digits of three rows, for windows that have no room for block letters."""

import re

ROWS = 3
_DIGITS = {
    "0": ("█▀█", "█ █", "▀▀▀"),
    "1": ("▄█ ", " █ ", "▀▀▀"),
    "2": ("▀▀█", "█▀▀", "▀▀▀"),
    "3": ("▀▀█", " ▀█", "▀▀▀"),
    "4": ("█ █", "▀▀█", "  ▀"),
    "5": ("█▀▀", "▀▀█", "▀▀▀"),
    "6": ("█▀▀", "█▀█", "▀▀▀"),
    "7": ("▀▀█", "  █", "  ▀"),
    "8": ("█▀█", "█▀█", "▀▀▀"),
    "9": ("█▀█", "▀▀█", "▀▀▀"),
    ".": (" ", " ", "▀"),
    ",": (" ", " ", "█"),
    "-": ("  ", "▀▀", "  "),
}
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
_SHARE = re.compile(r"(\d+)( \w+ )(\d+) ")
"""Two numbers with a word between them: ``9 of 10``."""
_GAP = "\N{NO-BREAK SPACE}"
"""A space that stays where lines are centred."""


def draw_digits(number: str) -> list[str]:
    """Return the rows of a number."""
    return [" ".join(rows) for rows in zip(*(_DIGITS[digit] for digit in number), strict=True)]


def draw_result(text: str) -> list[str]:
    """Return the rows of a result that begins with a number, its unit beside the last row; none if
    it begins otherwise.
    """
    found = _NUMBER.match(text)
    if not found:
        return []
    unit = text[found.end() :]
    *upper, last = draw_digits(found[0])
    rows = (*(row + " " * len(unit) for row in upper), last + unit)
    return [row.replace(" ", _GAP) for row in rows]


def draw_share(text: str) -> list[str]:
    """Return the rows of a text such as ``9 of 10 goals reached``, its words below the numbers;
    none if it begins otherwise.
    """
    found = _SHARE.match(text)
    if not found:
        return []
    part, word, whole = found.groups()
    between = (" " * len(word), word, " " * len(word))
    drawn = zip(draw_digits(part), between, draw_digits(whole), strict=True)
    words = text[found.end() :]
    rows = ["".join(parts) for parts in drawn]
    width = max(len(words), len(rows[0]))
    return [row.center(width).replace(" ", _GAP) for row in (*rows, words)]
