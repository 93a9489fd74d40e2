"""Pictures that may stand for a drawn face, where the terminal can show them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from textual.widget import Widget

from sar_tui.widgets.robot import HEIGHT, WIDTH

_PIXELS = (20 * WIDTH, 40 * HEIGHT)
"""Terminals draw characters about twice as high as wide; what there is too little or too much of is scaled."""


def find_pictures() -> type[Widget] | None:
    """The widget that shows pictures in this terminal; None where there is none, or the extra ``images`` is missing.

    It asks the terminal whether it understands one of the protocols (kitty, sixel), so it has to be called before an
    app runs there.
    """
    try:
        from textual_image.renderable import Image, SixelImage, TGPImage

        if Image not in (SixelImage, TGPImage):
            return None
        from textual_image.widget import Image as Picture
    except Exception:  # it is not installed, or the terminal answered with what nobody expects
        return None
    found: type[Widget] = Picture
    return found


def load_pictures(files: Mapping[str, Path]) -> dict[str, Any]:
    """Pictures by their names, decoded and of one size; a file that is none is left out."""
    from PIL import Image, ImageOps

    pictures = {}
    for name, path in files.items():
        try:
            with Image.open(path) as picture:
                pictures[name] = ImageOps.pad(picture.convert("RGBA"), _PIXELS, color=(0, 0, 0, 0))
        except Exception:  # what a broken file does to a decoder is nobody's to foresee
            continue
    return pictures
