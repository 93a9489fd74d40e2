"""Colours and their contrast."""

import math
import re


def is_color(value: str) -> bool:
    """Return True if a text is a colour like #a0b1c2."""
    return bool(re.fullmatch(r"#[0-9a-fA-F]{6}", value))


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two #rrggbb colours, 1 to 21 (WCAG 2.2, "contrast ratio")."""
    lighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def cut(ratio: float) -> float:
    """Return a ratio truncated to two decimals, not rounded: 4.499 stays below 4.5."""
    return math.floor(ratio * 100) / 100


def _luminance(color: str) -> float:
    """Return the relative luminance of an sRGB colour (WCAG 2.2, "relative luminance")."""
    channels = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    red, green, blue = (
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
