"""Shapes of large characters that the font lacks: marks above and below letters, other letters, arrows, symbols.

A shape has a text for each row, ``#`` for a dot. As in the font, capitals take the rows 0 to 6, small letters without a
stem the rows 2 to 6, and row 7 is for descenders.
"""

Shape = tuple[str, ...]
"""Rows of a character, all equally long."""

_RIGHT = (
    "    #   ",
    "    ##  ",
    "    ### ",
    "########",
    "########",
    "    ### ",
    "    ##  ",
    "    #   ",
)
_DOWN = tuple("".join(row[x] for row in _RIGHT) for x in range(8))
_TRIANGLE = (
    "   ##   ",
    "   ##   ",
    "  ####  ",
    "  ####  ",
    " ###### ",
    " ###### ",
    "########",
    "########",
)
_DISC = (
    "  ####  ",
    " ###### ",
    "########",
    "########",
    "########",
    "########",
    " ###### ",
    "  ####  ",
)
_RING = (
    "  ####  ",
    " ##  ## ",
    "##    ##",
    "##    ##",
    "##    ##",
    "##    ##",
    " ##  ## ",
    "  ####  ",
)
SYMBOLS: dict[str, Shape] = {
    "→": _RIGHT,
    "←": tuple(row[::-1] for row in _RIGHT),
    "↑": _DOWN[::-1],
    "↓": _DOWN,
    "●": _DISC,
    "○": _RING,
    "■": ("########",) * 8,
    "□": ("########", "########", *("##    ##",) * 4, "########", "########"),
    "▲": _TRIANGLE,
    "▼": _TRIANGLE[::-1],
    "◆": (
        "   ##   ",
        "  ####  ",
        " ###### ",
        "########",
        "########",
        " ###### ",
        "  ####  ",
        "   ##   ",
    ),
    "✓": (
        "       #",
        "      ##",
        "     ## ",
        "#   ##  ",
        "## ##   ",
        " ###    ",
        "  #     ",
        "        ",
    ),
    "✗": (
        "##    ##",
        "###  ###",
        " ###### ",
        "  ####  ",
        "  ####  ",
        " ###### ",
        "###  ###",
        "##    ##",
    ),
}
"""Signs of eight rows."""

LETTERS: dict[str, Shape] = {
    "ß": (
        " ##### ",
        "##   ##",
        "##   ##",
        "## ### ",
        "##   ##",
        "##   ##",
        "## ### ",
        "##     ",
    ),
    "ı": (
        "      ",
        "      ",
        "####  ",
        "  ##  ",
        "  ##  ",
        "  ##  ",
        "######",
    ),
    "ȷ": (
        "     ",
        "     ",
        " ####",
        "   ##",
        "   ##",
        "   ##",
        "   ##",
        "#### ",
    ),
    "ø": (
        "       ",
        "      #",
        " ##### ",
        "##  ###",
        "## # ##",
        "###  ##",
        " ##### ",
        "#      ",
    ),
    "Ø": (
        "  ### #",
        " ## ## ",
        "##  ###",
        "## # ##",
        "###  ##",
        " ## ## ",
        "# ###  ",
    ),
    "æ": (
        "        ",
        "        ",
        " ## ### ",
        "#  ##  #",
        "#  #####",
        "#  ##   ",
        " ## ### ",
    ),
    "Æ": (
        "   #####",
        "  ###   ",
        " ## #   ",
        " ## ####",
        " #####  ",
        "##  #   ",
        "##  ####",
    ),
    "œ": (
        "        ",
        "        ",
        " ### ## ",
        "#  ##  #",
        "#  #####",
        "#  ##   ",
        " ### ## ",
    ),
    "Œ": (
        " #######",
        "##  #   ",
        "##  #   ",
        "##  ####",
        "##  #   ",
        "##  #   ",
        " #######",
    ),
    "ł": (
        " ### ",
        "  ## ",
        "  ###",
        "  ## ",
        " ### ",
        "  ## ",
        " ####",
    ),
    "Ł": (
        "##     ",
        "##     ",
        "## ##  ",
        "####   ",
        "###    ",
        "##     ",
        "###### ",
    ),
    "¿": (
        "  ##  ",
        "      ",
        "  ##  ",
        " ##   ",
        "##    ",
        "##  ##",
        " #### ",
    ),
    "¡": (
        " ## ",
        "    ",
        " ## ",
        " ## ",
        "####",
        "####",
        " ## ",
    ),
    "€": (
        "  #### ",
        " ##  ##",
        "#####  ",
        " ##    ",
        "#####  ",
        " ##  ##",
        "  #### ",
    ),
}
"""Letters and punctuation of languages that are written in Latin letters."""

MARKS_ABOVE: dict[str, Shape] = {
    "\N{COMBINING GRAVE ACCENT}": ("##  ", "  ##"),
    "\N{COMBINING ACUTE ACCENT}": ("  ##", "##  "),
    "\N{COMBINING CIRCUMFLEX ACCENT}": (" ### ", "## ##"),
    "\N{COMBINING TILDE}": (" ##  ##", "##  ## "),
    "\N{COMBINING MACRON}": ("#####",),
    "\N{COMBINING BREVE}": ("##  ##", " #### "),
    "\N{COMBINING DOT ABOVE}": ("##",),
    "\N{COMBINING DIAERESIS}": ("## ##",),
    "\N{COMBINING RING ABOVE}": (" ## ", "#  #", " ## "),
    "\N{COMBINING DOUBLE ACUTE ACCENT}": (" ## ##", "## ## "),
    "\N{COMBINING CARON}": ("## ##", " ### "),
}
"""Marks that stand a row above a letter."""

MARKS_BELOW: dict[str, Shape] = {
    "\N{COMBINING CEDILLA}": (" ## ", "  ##", "### "),
    "\N{COMBINING OGONEK}": ("  ## ", " ##  ", "  ###"),
    "\N{COMBINING COMMA BELOW}": ("   ", " ##", "## "),
    "\N{COMBINING DOT BELOW}": ("  ", "##"),
}
"""Marks that hang from a letter."""
