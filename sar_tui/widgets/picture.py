"""Pictures in place of drawn faces, for terminals that can show them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from textual.widget import Widget

from sar_tui.widgets.robot import HEIGHT, WIDTH

_PIXELS = (20 * WIDTH, 40 * HEIGHT)
"""Size to scale pictures to: characters are about twice as high as wide."""


def find_pictures() -> type[Widget] | None:
    """Return the widget that shows pictures in this terminal; None if it cannot, or the extra
    ``images`` is missing.

    Asks the terminal for its protocols (kitty, sixel), so it must be called before an app runs.
    """
    try:
        from textual_image.renderable import Image, SixelImage, TGPImage

        if Image not in (SixelImage, TGPImage):
            return None
        from textual_image.widget import Image as Picture
    except Exception:  # not installed, or an unexpected answer from the terminal
        return None
    found: type[Widget] = Picture
    return found


def load_pictures(files: Mapping[str, Path]) -> dict[str, Any]:
    """Return pictures by name, decoded and of one size, without files that cannot be read."""
    from PIL import Image, ImageOps

    pictures = {}
    for name, path in files.items():
        try:
            with Image.open(path) as picture:
                pictures[name] = ImageOps.pad(picture.convert("RGBA"), _PIXELS, color=(0, 0, 0, 0))
        except Exception:  # a decoder may raise anything for a broken file
            continue
    return pictures
