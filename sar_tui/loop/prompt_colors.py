"""Colours that a prompt may have, by the names that people call them: told apart without normal
colour vision, too.

The set is that of Okabe & Ito (2008), "Color Universal Design: how to make figures and
presentations that are friendly to colorblind people" (https://jfly.uni-koeln.de/color/). Its
vermillion is named red here, its bluish green green, its reddish purple purple; its black is the
colour of texts.
"""

from functools import cache

from sar_tui.model.contrast import contrast

OKABE_ITO = {
    "red": "#d55e00",
    "orange": "#e69f00",
    "yellow": "#f0e442",
    "green": "#009e73",
    "sky blue": "#56b4e9",
    "blue": "#0072b2",
    "purple": "#cc79a7",
}
"""The colours by name."""
LEAST_CONTRAST = 3.0
"""Least contrast with the background, as WCAG 2.2 asks of large text and of graphics (1.4.3,
1.4.11).
"""
_STEPS = 100


@cache
def color_on(name: str, background: str) -> str:
    """Return a colour of the set as #rrggbb: as published, or darker or lighter until it stands out
    on a background.

    Args:
        name: of the colour.
        background: as #rrggbb.
    """
    published = OKABE_ITO[name]
    towards = max(("#000000", "#ffffff"), key=lambda end: contrast(end, background))
    mixes = (_mixed(published, towards, step / _STEPS) for step in range(_STEPS + 1))
    return next(color for color in mixes if contrast(color, background) >= LEAST_CONTRAST)


def color_problem(name: str) -> str:
    """Return a sentence if a prompt has a colour that is not in the set; else an empty one."""
    if not name or name in OKABE_ITO:
        return ""
    return f"There is no colour {name!r}. Choose one of: {', '.join(OKABE_ITO)}."


def _mixed(color: str, other: str, share: float) -> str:
    """Return a colour with a share of another one."""
    parts = [(int(color[i : i + 2], 16), int(other[i : i + 2], 16)) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(one + share * (two - one)):02x}" for one, two in parts)
