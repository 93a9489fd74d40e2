"""Whose keys are whose: the left half of the keyboard is A's, the right half B's, by physical place."""

ROWS: dict[str, tuple[str, str, str, str]] = {
    "qwerty": ("1234567890", "qwertyuiop", "asdfghjkl;", "zxcvbnm,./"),
    "azerty": ("&é\"'(-è_çà", "azertyuiop", "qsdfghjklm", "wxcvbn,;:!"),
    "qwertz": ("1234567890", "qwertzuiop", "asdfghjklö", "yxcvbnm,.-"),
}
"""What each place types without Shift: digits, top, home and bottom row, ten columns from the left."""

_HALF = 5
_OUTWARDS = (3, 2, 1, 0, 4)
"""The columns of a left hand from the forefinger outwards, and the one between the hands last."""
_PAIRS = (2, 3, 4, 6, 8, 11)
"""How many keys each has to choose from, by level."""

Pair = tuple[str, str]


def owners(layout: str) -> dict[str, str]:
    """Whose each key is, by what it types: ``A`` or ``B``."""
    return {key: "A" if column < _HALF else "B" for row in ROWS[layout] for column, key in enumerate(row)}


def levels(layout: str) -> tuple[tuple[Pair, ...], ...]:
    """The levels, easiest first: pairs of letters at mirrored places, so that both ask the same finger.

    The home row comes first, then the top, then the bottom row; a place that types no plain letter on either side is
    left out.
    """
    _, top, home, bottom = ROWS[layout]
    mirrored = [(row[column], row[9 - column]) for row in (home, top, bottom) for column in _OUTWARDS]
    letters = tuple(pair for pair in mirrored if all(key.isascii() and key.isalpha() for key in pair))
    return tuple(letters[:count] for count in _PAIRS)
