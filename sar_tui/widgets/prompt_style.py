"""The colour of a prompt in Rich's terms: exact if the terminal can show it, else a different one
for each name.
"""

from functools import cache

from rich._palettes import STANDARD_PALETTE
from rich.color import Color

from sar_tui.loop.prompt_colors import OKABE_ITO, color_on
from sar_tui.model.contrast import contrast

_SIXTEEN = {
    "red": (9, 1),
    "orange": (3, 9),
    "yellow": (11, 3),
    "green": (10, 2),
    "sky blue": (14, 6),
    "blue": (12, 4),
    "purple": (13, 5),
}
"""Numbers of the nearest of a terminal's sixteen colours, on a dark and on a light background.

The nearest by Rich's measure are alike for some names: red and orange, green and blue.
"""


@cache
def prompt_color(name: str, background: str, color_system: str | None) -> Color | None:
    """Return the colour for a prompt; None for the colour of texts, as for a name that is not in
    the set.

    Args:
        name: of the colour; empty for none.
        background: as #rrggbb.
        color_system: of Rich's console: "truecolor", "256", "standard" …
    """
    if name not in OKABE_ITO:
        return None
    if color_system in ("standard", "windows"):
        is_light = contrast("#000000", background) > contrast("#ffffff", background)
        return Color.from_rgb(*STANDARD_PALETTE[_SIXTEEN[name][is_light]])
    return Color.parse(color_on(name, background))
