"""Keyboard layouts by physical place, and the choice sets made from them.

A level asks for places, so that it trains the same fingers on every layout; the layout gives their
characters. Places are named by row (0 digits, 1 top, 2 home, 3 bottom) and column from the left.
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
"""Characters left out of mixed cases, or of letters mixed with digits: they are hard to tell apart
quickly.
"""

FINGERS = "3627180549"
"""Columns of both hands, from the index fingers outwards, then the two in the middle."""
LETTERS = (2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 15, 18, 22)
"""Numbers of letters of the first levels for both hands; the next has all."""
ONE_HANDED = (2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16)
"""Numbers of keys of the levels for one hand; the last has all."""

ARROWS = ("left", "right", "up", "down")


class Level(msgspec.Struct, frozen=True):
    """The keys of a level. ``needs_shift``: upper and lower case differ."""

    keys: tuple[str, ...]
    needs_shift: bool = False


def levels(choice_set: str, layout: str) -> tuple[Level, ...]:
    """Return the levels of a choice set, easiest first.

    Each has few keys more than the one before. A reaction time grows with the logarithm of their
    number (Hick 1952), so from the eighth key on a level adds about a sixth.

    Args:
        choice_set: ``both hands``, ``left hand``, ``right hand`` or ``arrow keys``.
        layout: ``qwerty``, ``azerty`` or ``qwertz``.
    """
    if choice_set == "arrow keys":
        return (Level(ARROWS[:2]), Level(ARROWS[:3]), Level(ARROWS))
    if choice_set == "both hands":
        return _both_hands(layout)
    return _one_hand(layout, mirrored=choice_set == "right hand")


def row_keys(layout: str, row: int, columns: str) -> tuple[str, ...]:
    """Return the keys of a row at these columns."""
    return tuple(PLAIN[layout][row][int(column)] for column in columns)


def _both_hands(layout: str) -> tuple[Level, ...]:
    """Return levels from two home-row keys, through letters and digits, to capitals and
    punctuation.
    """
    home, top, bottom = (row_keys(layout, row, FINGERS) for row in (2, 1, 3))
    letters = tuple(key for key in (*home, *top, *bottom) if is_letter(key))
    clear, digits, signs = clear_letters(letters), clear_digits(), all_signs(layout)
    capitals = tuple(key.upper() for key in clear)
    mixed = (*clear, *digits, *capitals)
    plain_digits = PLAIN[layout][0].isdigit()
    few, more = (len(clear) + len(digits) + part * len(capitals) // 3 for part in (1, 2))
    return (
        *(Level(letters[:count]) for count in (*LETTERS, len(letters))),
        Level((*clear, *digits), needs_shift=not plain_digits),
        *(Level(mixed[:count], needs_shift=True) for count in (few, more, len(mixed))),
        Level((*mixed, *signs[: len(signs) // 2]), needs_shift=True),
        Level((*mixed, *signs), needs_shift=True),
    )


def is_letter(key: str) -> bool:
    """Return True for a letter of the English alphabet."""
    return key.isascii() and key.isalpha()


def clear_letters(letters: tuple[str, ...]) -> tuple[str, ...]:
    """Return the letters that cannot be taken for others."""
    return tuple(key for key in letters if key not in LOOK_ALIKE)


def clear_digits() -> tuple[str, ...]:
    """Return the digits that cannot be taken for letters."""
    return tuple(digit for digit in "1234567890" if digit not in LOOK_ALIKE)


def all_signs(layout: str) -> tuple[str, ...]:
    """Return the punctuation marks of a layout."""
    return tuple(
        dict.fromkeys(
            key for row in (*PLAIN[layout], *SHIFTED[layout]) for key in row if _is_sign(key)
        )
    )


def needs_shift(key: str, layout: str) -> bool:
    """Return True if a key is typed with Shift on a layout."""
    return any(key in row for row in SHIFTED[layout]) and not any(
        key in row for row in PLAIN[layout]
    )


def _is_sign(key: str) -> bool:
    return key.isascii() and not key.isalnum()


def _one_hand(layout: str, *, mirrored: bool) -> tuple[Level, ...]:
    """Return levels for one hand, from the index finger outwards, without Shift."""
    keys = one_handed_keys(layout, mirrored=mirrored)
    counts = [count for count in ONE_HANDED if count < len(keys)]
    return tuple(Level(keys[:count]) for count in (*counts, len(keys)))


def one_handed_keys(layout: str, *, mirrored: bool) -> tuple[str, ...]:
    """Return all keys of one hand: the home row, the top, the bottom, the inner columns, and the
    digits if they need no Shift. The left hand has columns 0-4 of each row, the right 9-5.
    """
    rows = [hand_keys(layout, row, "3210", mirrored=mirrored) for row in (2, 1, 3)]
    rows += [hand_keys(layout, row, "4", mirrored=mirrored) for row in (2, 1, 3)]
    if PLAIN[layout][0].isdigit():
        rows.append(hand_keys(layout, 0, "3210", mirrored=mirrored))
    return tuple(dict.fromkeys(key for row in rows for key in row))


def hand_keys(layout: str, row: int, columns: str, *, mirrored: bool) -> tuple[str, ...]:
    """Return the keys of one hand in a row; columns count from the outer edge of the keyboard."""
    places = [9 - int(column) if mirrored else int(column) for column in columns]
    return tuple(key for place in places if (key := PLAIN[layout][row][place]).isascii())
