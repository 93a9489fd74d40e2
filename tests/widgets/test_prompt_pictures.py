"""Pictures of prompts: prepared once, of the right size and proportions, in whatever way the
terminal can show them.
"""

import base64
import io
import re
import sys
from pathlib import Path
from types import ModuleType

import msgspec
import pytest
from PIL import Image
from rich.cells import cell_len
from textual.app import App, ComposeResult
from textual.geometry import Region
from textual.strip import Strip

from sar_tui.widgets.big_prompt import BigPrompt
from sar_tui.widgets.prompt_pictures import Drawn, Pictures, Way, find_way
from tests.widgets.test_big_prompt import prompt

GROUND = "#10171e"
WAYS: tuple[Way, ...] = ("kitty", "sixel", "half blocks", "blocks")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A task's folder: a red picture twice as wide as high, and a transparent one."""
    Image.new("RGB", (400, 200), (255, 0, 0)).save(tmp_path / "red.png")
    Image.new("RGBA", (50, 50), (0, 0, 0, 0)).save(tmp_path / "clear.png")
    (tmp_path / "broken.png").write_bytes(b"\x89PNG and no more")
    return tmp_path


def pictures(folder: Path, way: Way) -> tuple[Pictures, list[str]]:
    written: list[str] = []
    return Pictures(folder, way, written.append), written


def drawn(
    folder: Path, way: Way, name: str = "red.png", columns: int = 78, rows: int = 11
) -> Drawn:
    found = pictures(folder, way)[0].drawn(name, columns, rows, GROUND)
    assert found is not None
    return found


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("columns", "rows"), [(78, 11), (20, 11), (1, 1)])
def test_a_picture_fills_its_room(folder: Path, way: Way, columns: int, rows: int) -> None:
    picture = drawn(folder, way, columns=columns, rows=rows)
    assert picture.columns <= columns
    assert len(picture.rows) <= rows
    assert picture.columns == columns or len(picture.rows) == rows
    drawn_rows = ["".join(part.text for part in row) for row in picture.rows]
    assert {cell_len(row) for row in drawn_rows} == {picture.columns}
    if columns > 1:  # a cell is twice as high as wide
        assert picture.columns == pytest.approx(4 * len(picture.rows), abs=3)


@pytest.mark.parametrize("way", ["half blocks", "blocks"])
def test_blocks_have_the_colours_of_the_picture(folder: Path, way: Way) -> None:
    for name, color in (("red.png", (255, 0, 0)), ("clear.png", (0x10, 0x17, 0x1E))):
        styles = {part.style for row in drawn(folder, way, name).rows for part in row}
        assert [style.bgcolor.triplet for style in styles if style and style.bgcolor] == [color]


def test_a_photograph_is_upright_as_the_camera_was_held(folder: Path) -> None:
    photograph = Image.new("RGB", (40, 80), (255, 0, 0))
    turned = photograph.getexif()
    turned[0x0112] = 6  # Orientation: by a quarter
    photograph.save(folder / "photograph.jpg", exif=turned)
    upright, expected = drawn(folder, "half blocks", "photograph.jpg"), drawn(folder, "half blocks")
    assert (upright.columns, len(upright.rows)) == (expected.columns, len(expected.rows))


def test_kitty_gets_a_picture_beforehand_and_its_frame_only_says_where(folder: Path) -> None:
    shown, written = pictures(folder, "kitty")
    picture = shown.drawn("red.png", 78, 11, GROUND)
    assert picture is not None
    *parts, placed = re.findall(r"\x1b_G([^;\x1b]*);?([^\x1b]*)\x1b\\", "".join(written))
    data = base64.b64decode("".join(payload for _, payload in parts))
    assert Image.open(io.BytesIO(data)).getpixel((0, 0)) == (255, 0, 0)
    assert [keys.partition("m=")[2][0] for keys, _ in parts] == ["1"] * (len(parts) - 1) + ["0"]
    assert f"c={picture.columns},r=11,U=1" in placed[0]
    number = int(placed[0].partition("i=")[2].split(",")[0])
    ((segment,), *_) = picture.rows
    assert segment.style.color.triplet == (number >> 16, number >> 8 & 255, number & 255)
    shown.drawn("red.png", 78, 11, GROUND)
    assert len(written) == len(parts) + 1, "it is sent once"
    shown.close()
    assert written[-1] == f"\x1b_Ga=d,d=I,i={number},q=2\x1b\\"


def test_a_picture_that_cannot_be_read_is_none(folder: Path) -> None:
    shown, _ = pictures(folder, "half blocks")
    for name in ("missing.png", "broken.png", "../red.png", "/etc/hostname"):
        assert shown.drawn(name, 78, 11, GROUND) is None
        assert shown.way_of(name) == "none"
    assert shown.way_of("red.png") == "half blocks"


@pytest.mark.parametrize(
    ("image", "environment", "way"),
    [
        ("sixel", {}, "sixel"), ("kitty", {"COLORTERM": "truecolor"}, "kitty"),
        ("kitty", {"COLORTERM": ""}, "half blocks"), ("neither", {}, "half blocks"),
        ("sixel", {"NO_COLOR": "1"}, "half blocks"), ("neither", {"TERM": "linux"}, "blocks"),
    ],
)  # fmt: skip
def test_the_way_depends_on_the_terminal(
    image: str, environment: dict[str, str], way: Way, monkeypatch: pytest.MonkeyPatch
) -> None:
    renderable = ModuleType("textual_image.renderable")
    known = {"sixel": object(), "kitty": object(), "neither": object()}
    vars(renderable).update(SixelImage=known["sixel"], TGPImage=known["kitty"], Image=known[image])
    monkeypatch.setitem(sys.modules, "textual_image.renderable", renderable)
    for name, value in ({"TERM": "xterm-256color"} | environment).items():
        monkeypatch.setenv(name, value)
    assert find_way() == way


def test_without_the_extra_there_is_no_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "textual_image.renderable", None)
    assert find_way() is None


class Stage(App[None]):
    def __init__(self, shown: Pictures | None) -> None:
        super().__init__()
        self._pictures = shown

    def compose(self) -> ComposeResult:
        yield BigPrompt(pictures=self._pictures)

    @property
    def strips(self) -> list[Strip]:
        return self.query_one(BigPrompt).render_lines(Region(0, 0, 80, 14))

    @property
    def texts(self) -> list[str]:
        return [strip.text for strip in self.strips]


def with_picture(name: str, colour: str = "") -> object:
    return msgspec.structs.replace(prompt("red", "What is it?"), picture=name, colour=colour)


@pytest.mark.parametrize("way", WAYS)
async def test_a_picture_stands_above_the_plain_line(folder: Path, way: Way) -> None:
    app = Stage(pictures(folder, way)[0])
    async with app.run_test(size=(80, 14)):
        widget = app.query_one(BigPrompt)
        before = app.texts
        assert widget.show(with_picture("red.png")) == way  # type: ignore[arg-type]
        texts = app.texts
        assert [text.strip() for text in texts].count("What is it?") == 1
        assert {strip.cell_length for strip in app.strips} == {80}
        rows = {region.y for region in widget._regions()}
        assert rows >= set(range(11)), "the whole picture is painted, and painted over later"
        escapes = [y for y, text in enumerate(texts) if "\x1bP" in text]
        assert escapes == ([10] if way == "sixel" else [])
        if way == "sixel":
            assert "\x1b7\x1b[1;" in texts[10]
            assert texts[10].endswith("\x1b\\\x1b8")
        widget.clear()
        assert app.texts == before


async def test_without_pictures_the_glyph_is_drawn_and_the_record_says_so(folder: Path) -> None:
    for shown, name in ((None, "red.png"), (pictures(folder, "half blocks")[0], "broken.png")):
        app = Stage(shown)
        async with app.run_test(size=(80, 14)):
            widget = app.query_one(BigPrompt)
            assert widget.show(with_picture(name)) == "none"  # type: ignore[arg-type]
            assert any("█" in text for text in app.texts)


async def test_a_prepared_picture_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    app = Stage(pictures(folder, "sixel")[0])
    async with app.run_test(size=(80, 14)):
        app.query_one(BigPrompt).prepare(["red.png", "missing.png"])
        (prepared,) = app.query_one(BigPrompt)._strips.values()
        monkeypatch.setattr(Image, "open", lambda *_: pytest.fail("read in the prompt's frame"))
        assert app.query_one(BigPrompt).show(with_picture("red.png")) == "sixel"  # type: ignore[arg-type]
        assert app.strips[:11] == prepared
        assert all(strip._render_cache for strip in prepared), "they are rendered, too"


async def test_only_the_drawing_has_the_colour_of_a_prompt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLORTERM", "truecolor")
    app = Stage(None)
    async with app.run_test(size=(80, 14)):
        widget = app.query_one(BigPrompt)
        plain = msgspec.structs.replace(prompt("", "● or 語", "a hint"), halves=("語", "●"))
        widget.show(msgspec.structs.replace(plain, colour="green"))
        coloured = {
            part.text
            for strip in app.strips
            for part in strip
            if part.style and part.style.color and part.style.color.triplet == (0, 0x9E, 0x73)
        }
        assert any("█" in text for text in coloured)
        assert any("語" in text for text in coloured)
        assert not set("".join(coloured)) & set("│┌─hint"), "frames, wall, plain line and hint"
        texts = app.texts
        widget.show(plain)
        assert app.texts == texts
