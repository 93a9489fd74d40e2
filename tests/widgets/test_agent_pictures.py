"""Pictures in the place of drawn faces: only where the terminal shows them, and never at the price
of a face.
"""

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import msgspec
import pytest
from PIL import Image
from textual.app import App, ComposeResult
from textual.widgets import Static

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.theme import Theme
from sar_tui.widgets.agent import Agent, find_pictures, load_pictures


class Frame(Static):
    """Shows pictures, as `textual_image.widget.Image` does."""

    image: Any = None


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A theme's folder with a picture, and with a file that calls itself one."""
    Image.new("RGB", (300, 100), (255, 0, 0)).save(tmp_path / "happy.png")
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\nand then nothing")
    return tmp_path


def hang(
    theme: Theme, folder: Path, picture: type[Static] | None = Frame, **images: str
) -> tuple[Agent, App[None]]:
    """An agent with a theme's pictures, alone on a screen."""
    agent = Agent(msgspec.structs.replace(theme, images=images), VirtualClock(), picture, folder)

    class PictureApp(App[None]):
        def compose(self) -> ComposeResult:
            yield agent

    return agent, PictureApp()


def shown(agent: Agent) -> list[str]:
    kinds = ("picture", "robot")
    return [name for name in kinds for widget in agent.query(f".{name}") if widget.display]


async def test_faces_without_a_picture_are_drawn(calm: Theme, folder: Path) -> None:
    agent, app = hang(calm, folder, happy="happy.png")
    async with app.run_test():
        assert shown(agent) == ["robot"]
        agent.say("Well done.", "happy")
        assert shown(agent) == ["picture"]
        assert agent.query_one(Frame).image.getpixel((210, 140)) == (255, 0, 0, 255)
        agent.clear("listening")
        assert shown(agent) == ["robot"]


@pytest.mark.parametrize(
    ("image", "picture"), [("broken.png", Frame), ("gone.png", Frame), ("happy.png", None)]
)
async def test_without_a_valid_picture_or_a_terminal_for_it_it_is_drawn(
    calm: Theme, folder: Path, image: str, picture: type[Static] | None
) -> None:
    agent, app = hang(calm, folder, picture, happy=image)
    async with app.run_test():
        agent.look("happy")
        assert shown(agent) == ["robot"]


async def test_pictures_change_with_the_theme(calm: Theme, folder: Path) -> None:
    agent, app = hang(calm, folder, happy="happy.png")
    async with app.run_test():
        agent.look("happy")
        agent.apply_theme(calm)
        assert shown(agent) == ["robot"]


async def test_a_speaking_picture_is_shown_by_voice(calm: Theme, folder: Path) -> None:
    agent, app = hang(calm, folder, speaking="happy.png")
    async with app.run_test():
        agent.say("Press the key that appears.", "speaking")
        assert shown(agent) == ["robot"]
        agent.speaking(True)
        assert shown(agent) == ["picture"]
        agent.hold()
        agent.speaking(False)
        assert shown(agent) == ["picture"], "nothing changes while a response is awaited"
        agent.release()
        assert shown(agent) == ["robot"]


async def test_a_picture_is_read_before_its_face_is_needed(calm: Theme, folder: Path) -> None:
    agent, app = hang(calm, folder, happy="happy.png")
    async with app.run_test():
        (folder / "happy.png").unlink()
        agent.look("happy")
        assert shown(agent) == ["picture"]


def test_pictures_keep_their_proportions_and_have_one_size(folder: Path) -> None:
    Image.new("RGB", (50, 400), (0, 255, 0)).save(folder / "tall.png")
    wide, tall = load_pictures({"wide": folder / "happy.png", "tall": folder / "tall.png"}).values()
    assert wide.size == tall.size
    assert wide.getpixel((wide.width // 2, 0))[3] == 0  # above it is nothing
    assert tall.getpixel((0, tall.height // 2))[3] == 0  # nor beside it


@pytest.mark.parametrize(
    ("protocol", "is_found"), [("sixel", True), ("kitty", True), ("half blocks", False)]
)
def test_pictures_are_shown_if_the_terminal_has_an_image_protocol(
    protocol: str, is_found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    renderable, widget = ModuleType("textual_image.renderable"), ModuleType("textual_image.widget")
    known = {"sixel": object(), "kitty": object(), "half blocks": object()}
    vars(renderable).update(
        SixelImage=known["sixel"], TGPImage=known["kitty"], Image=known[protocol]
    )
    vars(widget).update(Image=Frame)
    monkeypatch.setitem(sys.modules, "textual_image.renderable", renderable)
    monkeypatch.setitem(sys.modules, "textual_image.widget", widget)
    assert find_pictures() is (Frame if is_found else None)


def test_without_the_extra_no_picture_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "textual_image.renderable", None)
    assert find_pictures() is None
