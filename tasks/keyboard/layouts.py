"""Keyboard layouts by physical place, and the choice sets made from them.

A level asks for places, so that it trains the same fingers on every layout; the layout gives their characters. Places
are named by row (0 digits, 1 top, 2 home, 3 bottom) and column from the left.
"""

import msgspec

Place = tuple[int, int]

PLAIN: dict[str, tuple[str, str, str, str]] = {
    "qwerty": ("1234567890", "qwertyuiop", "asdfghjkl;", "zxcvbnm,./"),
    "azerty": ("&é\"'(-è_çà", "azertyuiop", "qsdfghjklm", "wxcvbn,;:!"),
    "qwertz": ("1234567890", "qwertzuiop", "asdfghjklö", "yxcvbnm,.-"),
}
"""Character of each place without Shift."""

SHIFTED: dict[str, tuple[str, str, str, str]] = {
    "qwerty": ("!@#$%^&*()", "QWERTYUIOP", "ASDFGHJKL:", "ZXCVBNM<>?"),
    "azerty": ("1234567890", "AZERTYUIOP", "QSDFGHJKLM", "WXCVBN?./§"),
    "qwertz": ('!"§$%&/()=', "QWERTZUIOP", "ASDFGHJKLÖ", "YXCVBNM;:_"),
}
"""Character of each place with Shift."""

LOOK_ALIKE = frozenset("loiLOI01")
"""Characters left out of mixed cases, or of letters mixed with digits: they are hard to tell apart quickly."""

ARROWS = ("left", "right", "up", "down")


class Level(msgspec.Struct, frozen=True):
    """The keys of a level. ``needs_shift``: upper and lower case differ."""

    keys: tuple[str, ...]
    needs_shift: bool = False


def levels(choice_set: str, layout: str) -> tuple[Level, ...]:
    """Return the levels of a choice set, easiest first.

    Args:
        choice_set: ``both hands``, ``left hand``, ``right hand`` or ``arrow keys``.
        layout: ``qwerty``, ``azerty`` or ``qwertz``.
    """
    if choice_set == "arrow keys":
        return (Level(ARROWS[:2]), Level(ARROWS[:3]), Level(ARROWS))
    if choice_set == "both hands":
        return _both_hands(layout)
    return _one_hand(layout, mirrored=choice_set == "right hand")


def _at(layout: str, row: int, columns: str) -> tuple[str, ...]:
    return tuple(PLAIN[layout][row][int(column)] for column in columns)


def _both_hands(layout: str) -> tuple[Level, ...]:
    """Return levels from two home-row keys, through letters and digits, to capitals and punctuation."""
    home, top, bottom = (_at(layout, row, "0123456789") for row in (2, 1, 3))
    fingers = _at(layout, 2, "36"), _at(layout, 2, "2367"), _at(layout, 2, "123678"), _at(layout, 2, "01235678")
    letters = tuple(key for key in (*home, *top, *bottom) if key.isascii() and key.isalpha())
    reached = tuple(key for key in (*home, *top) if key in letters)
    plain_digits = PLAIN[layout][0].isdigit()
    signs = tuple(dict.fromkeys(key for row in (*PLAIN[layout], *SHIFTED[layout]) for key in row if _is_sign(key)))
    clear = tuple(key for key in letters if key not in LOOK_ALIKE)
    digits = tuple(digit for digit in "1234567890" if digit not in LOOK_ALIKE)
    capitals = tuple(key.upper() for key in clear)
    return (
        *(Level(keys) for keys in fingers),
        Level(reached),
        Level(letters),
        Level((*clear, *digits), needs_shift=not plain_digits),
        Level((*clear, *capitals), needs_shift=True),
        Level((*clear, *capitals, *digits), needs_shift=True),
        Level((*clear, *capitals, *digits, *signs), needs_shift=True),
    )


def needs_shift(key: str, layout: str) -> bool:
    """Return True if a key is typed with Shift on a layout."""
    return any(key in row for row in SHIFTED[layout]) and not any(key in row for row in PLAIN[layout])


def _is_sign(key: str) -> bool:
    return key.isascii() and not key.isalnum()


def _one_hand(layout: str, *, mirrored: bool) -> tuple[Level, ...]:
    """Return ten levels for one hand, from the index finger outwards, without Shift.

    The left hand has columns 0-4 of each row, the right 9-5. Digits are used only if they need no Shift.
    """

    def keys(row: int, columns: str) -> tuple[str, ...]:
        places = [9 - int(column) if mirrored else int(column) for column in columns]
        return tuple(key for place in places if (key := PLAIN[layout][row][place]).isascii())

    home, top, bottom = keys(2, "3210"), keys(1, "3210"), keys(3, "3210")
    inner = keys(2, "4") + keys(1, "4") + keys(3, "4")
    if len(home) < 4:
        home += inner[:1]
    last = keys(0, "3210") if PLAIN[layout][0].isdigit() else inner
    return tuple(
        Level(tuple(dict.fromkeys(chosen)))
        for chosen in (
            home[:2],
            home[:3],
            home,
            home + top[:1],
            home + top[:2],
            home + top,
            home + top + bottom[:2],
            home + top + bottom,
            home + top + bottom + inner[:2],
            home + top + bottom + inner + last,
        )
    )
