"""Texts that a terminal must not get as they are."""

CONTROLS = "".join(map(chr, (*range(0x20), *range(0x7F, 0xA0))))
OBEYED = CONTROLS + "".join(
    map(chr, (0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x2070), 0xD800, 0xDCFF))
)
"""Characters that a terminal obeys: C0 and C1, line separators, changes of direction;
surrogates.
"""
HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202e\u2066\u2028end"
"""Sets a window's title, clears the screen, changes the colour and the direction of text."""
SHOWN = "␛]0;owned␇␛[2J�31m���end"
"""`HOSTILE` as people read it."""


def leaks(output: str) -> list[str]:
    """Return the characters in a program's output that a terminal would obey, other than
    newlines.
    """
    return sorted(map(ascii, set(output) & set(OBEYED) - {"\n"}))
