"""Numbers in digits of three rows, for windows that have no room for block letters."""

import re

ROWS = 3
_DIGITS = {
    "0": ("█▀█", "█ █", "▀▀▀"),
    "1": ("▀█", " █", " ▀"),
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
}
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")


def draw_digits(number: str) -> list[str]:
    """Return the rows of a number without a sign."""
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
    return [row.replace(" ", "\N{NO-BREAK SPACE}") for row in rows]  # kept where it is centred
