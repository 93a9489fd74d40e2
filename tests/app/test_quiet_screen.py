"""Nothing moves while a response is awaited, and no colour is needed to read the screen."""

import gc
import re
from pathlib import Path
from typing import Any

import pytest
from textual.geometry import Region

from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.app.chair import Chair, plan, sit_down

_UNSTYLED = "c5c8c6"
"""Rich's name for no colour at all, in a picture."""


def count_frames(chair: Chair, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Every frame that the app draws from here on."""
    frames: list[object] = []
    draw = chair.app._display

    def counted(screen: Any, frame: Any) -> None:
        frames.append(frame)
        draw(screen, frame)

    monkeypatch.setattr(chair.app, "_display", counted)
    return frames


async def test_no_frame_is_drawn_between_a_prompt_and_its_response(
    data: Path, catalogue: Catalogue, keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        frames = count_frames(chair, monkeypatch)
        for _ in range(20):
            await chair.wait(200)
        assert frames == []
        await chair.press(prompt.expected)
        assert frames != []


async def test_a_prompt_repaints_its_own_region_only(
    data: Path, catalogue: Catalogue, keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        first = await chair.to_first_prompt()
        await chair.answer(first)
        frames = count_frames(chair, monkeypatch)
        await chair.to_prompt()
        assert len(frames) == 1
        stage = chair.app.screen.query_one("#prompt").region
        spans = frames[0].spans  # type: ignore[attr-defined]
        assert all(stage.contains_region(Region(left, y, right - left, 1)) for y, left, right in spans)


async def test_no_widget_of_a_session_moves_by_itself(data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        await chair.to_first_prompt()
        assert not chair.app.animator._animations
        for widget in chair.app.screen.walk_children(with_self=True):
            assert widget.auto_refresh is None, widget
            assert not [timer for timer in widget._timers if timer._active.is_set()], widget


async def test_no_garbage_is_collected_while_a_response_is_awaited(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        assert not gc.isenabled()
        await chair.answer(prompt)
        assert gc.isenabled()
        await chair.to_prompt()
        assert not gc.isenabled()
        await chair.press("escape")
        assert gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


async def test_no_color_is_respected_and_the_screens_say_the_same(
    data: Path, catalogue: Catalogue, keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    async with sit_down(data, catalogue, plan(keyboard, attempts=1)) as chair:
        grey = [_is_grey(chair)]
        await chair.to_first_prompt()
        grey.append(_is_grey(chair))
        await chair.press("escape")
        grey.append(_is_grey(chair))
        await chair.press("enter")
        await chair.do_attempt(await chair.to_prompt())
        await chair.see_the_summary()
        assert chair.sees("● reached ○ missed")
        grey.append(_is_grey(chair))
        assert grey == [True] * 4


async def test_there_is_colour_where_it_is_not_refused(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        assert not _is_grey(chair)


def _is_grey(chair: Chair) -> bool:
    """Whether all text on the screen is drawn in shades of grey."""
    picture = chair.app.export_screenshot()
    colors = set(re.findall(r"-r\d+ \{ fill: #(......)", picture)) - {_UNSTYLED}
    return all(color[:2] == color[2:4] == color[4:] for color in colors)
