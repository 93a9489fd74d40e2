"""The levels of sessions under earlier rules, some of them far apart: from eight keys to
nineteen.
"""

from .layouts import (
    ARROWS,
    PLAIN,
    Level,
    all_signs,
    clear_digits,
    clear_letters,
    hand_keys,
    is_letter,
    row_keys,
)

LAST_RULES = 2
"""The last version of the rules under which sessions had these levels."""


def earlier_levels(choice_set: str, layout: str) -> tuple[Level, ...]:
    """Return the levels of a choice set, easiest first."""
    if choice_set == "arrow keys":
        return (Level(ARROWS[:2]), Level(ARROWS[:3]), Level(ARROWS))
    if choice_set == "both hands":
        return _both_hands(layout)
    return _one_hand(layout, mirrored=choice_set == "right hand")


def _both_hands(layout: str) -> tuple[Level, ...]:
    home, top, bottom = (row_keys(layout, row, "0123456789") for row in (2, 1, 3))
    fingers = [row_keys(layout, 2, columns) for columns in ("36", "2367", "123678", "01235678")]
    letters = tuple(key for key in (*home, *top, *bottom) if is_letter(key))
    reached = tuple(key for key in (*home, *top) if key in letters)
    clear, digits, signs = clear_letters(letters), clear_digits(), all_signs(layout)
    capitals = tuple(key.upper() for key in clear)
    return (
        *(Level(keys) for keys in fingers),
        Level(reached),
        Level(letters),
        Level((*clear, *digits), needs_shift=not PLAIN[layout][0].isdigit()),
        Level((*clear, *capitals), needs_shift=True),
        Level((*clear, *capitals, *digits), needs_shift=True),
        Level((*clear, *capitals, *digits, *signs), needs_shift=True),
    )


def _one_hand(layout: str, *, mirrored: bool) -> tuple[Level, ...]:
    home, top, bottom = (hand_keys(layout, row, "3210", mirrored=mirrored) for row in (2, 1, 3))
    inner = tuple(
        key for row in (2, 1, 3) for key in hand_keys(layout, row, "4", mirrored=mirrored)
    )
    if len(home) < 4:
        home += inner[:1]
    last = hand_keys(layout, 0, "3210", mirrored=mirrored) if PLAIN[layout][0].isdigit() else inner
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
