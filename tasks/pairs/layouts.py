"""The two halves of the keyboard by physical place: the left is seat A's, the right seat B's."""

ROWS: dict[str, tuple[str, str, str, str]] = {
    "qwerty": ("1234567890", "qwertyuiop", "asdfghjkl;", "zxcvbnm,./"),
    "azerty": ("&é\"'(-è_çà", "azertyuiop", "qsdfghjklm", "wxcvbn,;:!"),
    "qwertz": ("1234567890", "qwertzuiop", "asdfghjklö", "yxcvbnm,.-"),
}
"""Character of each place without Shift: digits, top, home and bottom row, ten columns from the
left.
"""

_HALF = 5
_OUTWARDS = (3, 2, 1, 0, 4)
"""Columns of the left hand from the index finger outwards, then the column between the hands."""
_PAIRS = (2, 3, 4, 6, 8, 11)
"""Number of keys for each seat, by level."""

Pair = tuple[str, str]


def owners(layout: str) -> dict[str, str]:
    """Return the seat of each key, by the character it types: ``A`` or ``B``."""
    return {
        key: "A" if column < _HALF else "B"
        for row in ROWS[layout]
        for column, key in enumerate(row)
    }


def levels(layout: str) -> tuple[tuple[Pair, ...], ...]:
    """Return the levels, easiest first: pairs of letters at mirrored places, for the same finger of
    either hand.

    The home row comes first, then the top, then the bottom row. Places without a plain letter on
    both sides are left out.
    """
    _, top, home, bottom = ROWS[layout]
    mirrored = [
        (row[column], row[9 - column]) for row in (home, top, bottom) for column in _OUTWARDS
    ]
    letters = tuple(
        pair for pair in mirrored if all(key.isascii() and key.isalpha() for key in pair)
    )
    return tuple(letters[:count] for count in _PAIRS)
