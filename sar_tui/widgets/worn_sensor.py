"""The sensor on the back of the hand, as in the thesis' Figure 4.7, and its three axes as bars."""

import math

from textual.content import Content

from sar_tui.motion.bounds import Hand

FULL_RAD_S = 4.0
"""The angular rate at which a bar is full."""

_RIGHT = """\
       ╭─╮╭─╮
    ╭─╮│ ││ │╭─╮
    │ ││ ││ ││ │
    │ ╰╯ ╰╯ ╰╯ │
╭─╮ │    ↑ y   │
│ ╰╮│  ╭─┴─╮   │
╰╮ ╰╯  │ ⊙ ├→ x│
 ╰╮    ╰─z─╯   │
  ╰─╮         ╭╯
    │         │"""
_LEFT = """\
   ╭─╮╭─╮
╭─╮│ ││ │╭─╮
│ ││ ││ ││ │
│ ╰╯ ╰╯ ╰╯ │
│    ↑ y   │ ╭─╮
│  ╭─┴─╮   │╭╯ │
│  │ ⊙ ├→ x╰╯ ╭╯
│  ╰─z─╯     ╭╯
╰╮         ╭─╯
 │         │"""
DRAWN: dict[Hand, str] = {"right": _RIGHT, "left": _LEFT}
"""A hand from above, palm down: y along the fingers, z out of the back of the hand, towards the eye."""


def draw_hand(hand: Hand) -> Content:
    """A hand with the sensor on it, the axes in the theme's accent."""
    return Content(DRAWN[hand]).highlight_regex("[xyz⊙↑→┴├]", style="bold $accent")


def bar(value: float, half: int) -> str:
    """A signed value as a bar about a middle, ``half`` cells on either side; it grows by half a cell."""
    steps = min(2 * half, round(abs(value) / FULL_RAD_S * 2 * half)) if math.isfinite(value) else 0
    whole, rest = divmod(steps, 2)
    empty = "─" * (half - whole - rest)
    if value > 0:
        return "─" * half + "┼" + "━" * whole + "╾" * rest + empty
    return empty + "╼" * rest + "━" * whole + "┼" + "─" * half
