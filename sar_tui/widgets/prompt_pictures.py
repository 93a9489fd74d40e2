"""Pictures of prompts, prepared for a terminal before they are shown, so that a prompt's frame
takes no longer.

Kitty's graphics are sent to the terminal beforehand; the frame only says where. Sixel graphics are
in the frame. In other terminals, a picture is made of half blocks, a colour for each half of a
cell.
"""

import base64
import io
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from itertools import count, groupby
from pathlib import Path
from typing import Any, Literal, NamedTuple

from rich.color import Color
from rich.console import Console
from rich.control import Control
from rich.segment import ControlType, Segment
from rich.style import Style

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.loop.task_pictures import picture_file

Way = Literal["kitty", "sixel", "half blocks", "blocks"]
"""Ways to draw pictures. ``blocks``: whole cells, for the Linux console, whose font has no half
blocks.
"""
Pixel = tuple[int, int, int]
_CHUNK = 4096
"""Longest part of a picture in one of kitty's commands."""
_IDS = count(0x5A5201)
"""Ids of pictures in kitty. Three bytes, of which each shows in the placeholder's colour."""


class Drawn(NamedTuple):
    """A picture as it is drawn: the segments of each of its rows, and the columns that it takes.

    ``overlay``: what follows the last row, to be painted over all of them, from the top left
    corner; else empty.
    """

    rows: tuple[tuple[Segment, ...], ...]
    columns: int
    overlay: str = ""


class Pictures:
    """Pictures of a task.

    Args:
        folder: of the task.
        way: how this terminal shows them.
        write: writes to the terminal.
    """

    def __init__(self, folder: Path, way: Way, write: Callable[[str], None]) -> None:
        self.way = way
        self._folder = folder
        self._write = write
        self._drawn: dict[tuple[str, int, int, str], Drawn | None] = {}
        self._sent: list[int] = []

    def drawn(self, name: str, columns: int, rows: int, background: str) -> Drawn | None:
        """Return a picture as large as fits into a number of cells; None if it cannot be read.

        The first call with the same arguments prepares it.

        Args:
            name: the file, in the task's folder.
            columns, rows: cells.
            background: colour under transparent parts, as #rrggbb.
        """
        key = (name, columns, rows, background)
        if key not in self._drawn:
            try:
                self._drawn[key] = self._prepared(
                    picture_file(self._folder, name), columns, rows, background
                )
            except Exception:  # a decoder may raise anything for a broken file
                self._drawn[key] = None
        return self._drawn[key]

    def way_of(self, name: str) -> Literal["none"] | Way:
        """Return how a picture is drawn, for the record; ``none`` if it cannot be read."""
        known = [drawn for (known, *_), drawn in self._drawn.items() if known == name]
        try:
            is_read = (
                bool(known[-1]) if known else not decode_problem(picture_file(self._folder, name))
            )
        except ValueError:
            is_read = False
        return self.way if is_read else "none"

    def close(self) -> None:
        """Remove the pictures that the terminal keeps."""
        for sent in self._sent:
            self._write(_command(a="d", d="I", i=sent, q=2))
        self._sent.clear()

    def _prepared(self, file: Path, columns: int, rows: int, background: str) -> Drawn:
        from PIL import Image, ImageOps

        cell = _cell_size() if self.way in ("kitty", "sixel") else (10, 20)
        with Image.open(file) as opened:
            # a JPEG is decoded at about this size
            opened.draft("RGB", (columns * cell[0], rows * cell[1]))
            # upright, as the camera was held
            picture = ImageOps.exif_transpose(opened).convert("RGBA")
        width, height = _fitting(picture.size, (columns, rows), cell)
        ground = Image.new("RGBA", picture.size, background)
        picture = Image.alpha_composite(ground, picture).convert("RGB")
        match self.way:
            case "kitty":
                return self._sent_to_kitty(
                    picture.resize((width * cell[0], height * cell[1])), width, height
                )
            case "sixel":
                return _sixel(picture.resize((width * cell[0], height * cell[1])), width, height)
            case "half blocks":
                return _half_blocks(picture.resize((width, 2 * height)))
            case "blocks":
                return _blocks(picture.resize((width, height)))

    def _sent_to_kitty(self, picture: Any, width: int, height: int) -> Drawn:
        """Send a picture to kitty, and return the characters in whose place it is shown.

        See https://sw.kovidgoyal.net/kitty/graphics-protocol/#unicode-placeholders.
        """
        from textual_image.renderable.tgp import Image as Placeholders

        number = next(_IDS)
        file = io.BytesIO()
        picture.save(file, "PNG", compress_level=1)
        data = base64.b64encode(file.getvalue()).decode()
        for start in range(0, len(data), _CHUNK):
            more = int(start + _CHUNK < len(data))
            self._write(_command(data[start : start + _CHUNK], i=number, f=100, m=more, q=2))
        self._write(_command(a="p", i=number, c=width, r=height, U=1, q=2))
        self._sent.append(number)
        shown = Placeholders(picture, width, height)
        shown.terminal_image_id = number  # so that it does not send it
        console = Console(width=width, height=height, file=io.StringIO())
        lines = [
            part
            for part in shown.__rich_console__(console, console.options)
            if isinstance(part, Segment)
        ]
        return Drawn(tuple((Segment(part.text.rstrip("\n"), part.style),) for part in lines), width)


def _command(payload: str = "", **keys: str | int) -> str:
    """Return a command of kitty's graphics protocol."""
    named = ",".join(f"{key}={value}" for key, value in keys.items())
    return f"\x1b_G{named}{';' * bool(payload)}{payload}\x1b\\"


def _fitting(
    size: tuple[int, int], room: tuple[int, int], cell: tuple[int, int]
) -> tuple[int, int]:
    """Return the columns and rows of a picture that fills the room in one direction, and keeps its
    proportions.
    """
    scale = min(room[0] * cell[0] / size[0], room[1] * cell[1] / size[1])
    return (
        max(1, min(room[0], round(size[0] * scale / cell[0]))),
        max(1, min(room[1], round(size[1] * scale / cell[1]))),
    )


def _cell_size() -> tuple[int, int]:
    """Return width and height of a cell in pixels."""
    from textual_image._terminal import get_cell_size

    found = get_cell_size()
    return found.width, found.height


def _sixel(picture: Any, width: int, height: int) -> Drawn:
    from textual_image.renderable.sixel import Image as Sixels

    console = Console(width=width, height=height, file=io.StringIO())
    parts = Sixels(picture, width, height).__rich_console__(console, console.options)
    data = next(
        part.text for part in parts if isinstance(part, Segment) and part.text.startswith("\x1bP")
    )
    return Drawn(((Segment(" " * width),),) * height, width, data)


def _half_blocks(picture: Any) -> Drawn:
    """Draw two rows of pixels in a row of cells."""
    width, height = picture.size
    pixels = picture.load()
    rows = (
        [("▀", pixels[x, y], pixels[x, y + 1]) for x in range(width)] for y in range(0, height, 2)
    )
    return Drawn(tuple(tuple(_runs(row)) for row in rows), width)


def _blocks(picture: Any) -> Drawn:
    """Draw a pixel in each cell."""
    width, height = picture.size
    pixels = picture.load()
    rows = ([(" ", pixels[x, y], pixels[x, y]) for x in range(width)] for y in range(height))
    return Drawn(tuple(tuple(_runs(row)) for row in rows), width)


def _runs(cells: Sequence[tuple[str, Pixel, Pixel]]) -> list[Segment]:
    """Join neighbouring cells that look the same."""
    return [
        Segment(sign * len(list(alike)), _style(upper, lower))
        for (sign, upper, lower), alike in groupby(cells)
    ]


def _style(color: Pixel, background: Pixel) -> Style:
    return Style(color=Color.from_rgb(*color), bgcolor=Color.from_rgb(*background))


def decode_problem(file: Path) -> str:
    """Return a sentence if a file is not a picture that can be read; else an empty one."""
    from PIL import Image

    try:
        too_large = warnings.catch_warnings(action="error", category=Image.DecompressionBombWarning)
        with too_large, Image.open(file) as opened:
            opened.draft("RGB", (64, 64))  # a JPEG is decoded faster at about this size
            opened.load()
    except Exception as error:  # a decoder may raise anything for a broken file
        return f"The picture {file.name} cannot be read ({type(error).__name__})."
    return ""


def overlay(drawn: Drawn, x: int, y: int) -> Segment:
    """Return the segment that paints a picture's overlay with its top left corner in a cell of the
    screen.
    """
    place = Control.move_to(x, y).segment.text
    return Segment(f"\x1b7{place}{drawn.overlay}\x1b8", None, [(ControlType.CURSOR_FORWARD, 0)])


def find_way(environ: Mapping[str, str] = os.environ) -> Way | None:
    """Return how this terminal shows pictures; None if the extra ``images`` is missing.

    Asks the terminal for its protocols, so it must be called before an app runs.
    """
    try:
        from textual_image.renderable import Image, SixelImage, TGPImage
    except Exception:  # not installed, or an unexpected answer from the terminal
        return None
    if environ.get("TERM") == "linux":
        return "blocks"
    if "NO_COLOR" in environ:
        return "half blocks"  # in shades of grey
    # its ids are colours
    if Image is TGPImage and Console(force_terminal=True).color_system == "truecolor":
        way: Way = "kitty"
    elif Image is SixelImage:
        way = "sixel"
    else:
        return "half blocks"
    _cell_size()  # asks the terminal, once
    return way


def no_package() -> str:
    """Return the sentence that says how to install what shows pictures."""
    return f"Pictures need the extra images: {pip_install_extra('images')}"
