"""Nothing moves while a response is awaited, and the screens are readable without colour."""

import gc
import re
from typing import Any

import pytest
from textual.geometry import Region

from tests.app.app_driver import AppDriver, OpenSession
from tests.caches import compose_frames

_UNSTYLED = "c5c8c6"
"""Rich's name for no colour at all, in a picture."""


def count_frames(driver: AppDriver, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Return a list to which each further frame of the app is added."""
    compose_frames(monkeypatch)
    frames: list[object] = []
    draw = driver.app._display

    def counted(screen: Any, frame: Any) -> None:
        frames.append(frame)
        draw(screen, frame)

    monkeypatch.setattr(driver.app, "_display", counted)
    return frames


async def test_a_prompt_stands_still(driver: AppDriver, monkeypatch: pytest.MonkeyPatch) -> None:
    prompt = await driver.to_first_prompt()
    frames = count_frames(driver, monkeypatch)
    for _ in range(20):
        await driver.wait(200)
    assert frames == []
    await driver.press(prompt.expected)
    assert frames != []


async def test_a_prompt_repaints_itself(driver: AppDriver, monkeypatch: pytest.MonkeyPatch) -> None:
    first = await driver.to_first_prompt()
    await driver.answer(first)
    frames = count_frames(driver, monkeypatch)
    await driver.to_prompt()
    assert len(frames) == 1
    stage = driver.app.screen.query_one("#prompt").region
    spans = frames[0].spans  # type: ignore[attr-defined]
    assert all(stage.contains_region(Region(left, y, right - left, 1)) for y, left, right in spans)


async def test_no_garbage_is_collected_while_a_response_is_awaited(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.tui.gc_control.gc", gc)
    gc.unfreeze()
    async with open_session() as driver:
        prompt = await driver.to_first_prompt()
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
        await driver.answer(prompt)
        assert gc.isenabled()
        await driver.to_prompt()
        assert not gc.isenabled()
        await driver.press("escape")
        assert gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
    gc.freeze()  # as before


async def test_no_color_is_respected_and_the_text_stays_the_same(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    async with open_session(attempts=1) as driver:
        grey = [_is_grey(driver)]
        await driver.to_first_prompt()
        grey.append(_is_grey(driver))
        await driver.press("escape")
        grey.append(_is_grey(driver))
        await driver.press("enter")
        await driver.finish(await driver.to_prompt())
        driver.see("goals reached", "goal reached ●")
        grey.append(_is_grey(driver))
        assert grey == [True] * 4


async def test_there_is_colour_without_no_color(first_run: AppDriver) -> None:
    assert not _is_grey(first_run)


def _is_grey(driver: AppDriver) -> bool:
    """Return True if all text on the screen is drawn in shades of grey."""
    picture = driver.app.export_screenshot()
    colors = set(re.findall(r"-r\d+ \{ fill: #(......)", picture)) - {_UNSTYLED}
    return all(color[:2] == color[2:4] == color[4:] for color in colors)
