"""Drawing of the sensor on the back of the hand (Figure 4.7 of the thesis), and bars for its
axes.
"""

import math

from textual.content import Content

from sar_tui.motion.reach import Hand

FULL_RAD_S = 4.0
"""Angular rate of a full bar."""

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
_TRUNK = """\
      ╭───╮
      │   │
      ╰╮ ╭╯
   ╭───╯ ╰───╮
  ╭╯  ╭───╮  ╰╮
  │ │ │ ⊙ │ │ │
  │ │ ╰───╯ │ │
  │ │       │ │
  │ ╰╮     ╭╯ │
  ╰──┤     ├──╯"""
DRAWN: dict[Hand, str] = {"right": _RIGHT, "left": _LEFT}
"""Hands from above, palm down: y along the fingers, z out of the back of the hand, towards the
viewer.
"""


def draw_hand(hand: Hand) -> Content:
    """Draw a hand with the sensor on it, its axes in the theme's accent colour."""
    return Content(DRAWN[hand]).highlight_regex("[xyz⊙↑→┴├]", style="bold $accent")


def draw_trunk() -> Content:
    """Draw a trunk from the front with the sensor on the breastbone, in the theme's accent
    colour.
    """
    return Content(_TRUNK).highlight_regex("⊙", style="bold $accent")


def bar(value: float, half: int) -> str:
    """Draw a signed value as a bar from the middle, ``half`` cells on either side, in steps of half
    a cell.
    """
    steps = min(2 * half, round(abs(value) / FULL_RAD_S * 2 * half)) if math.isfinite(value) else 0
    whole, rest = divmod(steps, 2)
    empty = "─" * (half - whole - rest)
    if value > 0:
        return "─" * half + "┼" + "━" * whole + "╾" * rest + empty
    return empty + "╼" * rest + "━" * whole + "┼" + "─" * half
