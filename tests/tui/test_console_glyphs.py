"""On the Linux console all screens are drawn with characters that its font has."""

from pathlib import Path

import pytest

from sar_tui.tui.base_app import drawn
from tests.app.app_driver import OpenApp, OpenSession, known
from tests.examples import first

THEMES = ("calm", "playful", "high-contrast")
FONT = frozenset(
    "‐‑‒–—―‘’‚“”„†‡•…‰‹›€←↑→↓∅∈−∞∩≈≠≡≤≥≪≫─━│┃┄┅┆┇┈┉┊┋┌┍┎┏┐┑┒┓└┕┖┗┘┙┚┛├┝┞┟┠┡┢┣┤┥┦┧┨┩┪┫┬┭┮┯┰┱┲┳┴┵┶┷┸┹┺┻┼"
    "╋╌╍╎╏═║╒╓╔╕╖╗╘╙╚╛╜╝╞╟╠╡╢╣╤╥╦╧╨╩╪╫╬╭╮╯╰╱╲╳╴╵╶╷╸╹╺╻╼╽╾╿█░▒■▮▲▴▶▸▼▾◀◂◈●☐☑☒♦✗✘"
)
"""Characters from U+2010 on that all of Lat15-Fixed16, Lat15-Terminus16, Lat15-VGA16, Uni2-Fixed16
and Uni2-VGA16 of console-setup 1.221 have, as their files say.
"""


def missing(text: str) -> set[str]:
    """Return the characters of a text that a font lacks."""
    return {character for character in text if ord(character) >= 0x180} - FONT


@pytest.mark.slow
@pytest.mark.parametrize("theme", first(1, THEMES))
async def test_a_session_is_drawn_with_the_characters_of_a_console(
    opened: OpenApp,
    open_session: OpenSession,
    data: Path,
    theme: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("TERM", "linux")
    known(data, "P01", theme)
    seen = []
    async with open_session(theme=theme, size=(100, 37)) as driver:
        prompt = await driver.to_first_prompt()
        seen.append(driver.text)
        await driver.answer(prompt, 2000)
        await driver.answer(await driver.to_prompt(), 2000)
        await driver.wait(1500)
        seen.append(driver.text)
        await driver.press("escape")
        seen.append(driver.text)
        await driver.press("enter")
        await driver.do_attempt(await driver.begin())
        await driver.see_the_summary()
        seen.append(driver.text)
    async with opened(size=(100, 37)) as driver:
        for key in ("f2", "f4"):
            seen.append(driver.text)
            await driver.press(key)
            seen.append(driver.text)
            await driver.press("escape")
    assert "█" in seen[0]
    assert [found for text in seen if (found := missing(text))] == []


def test_a_text_keeps_its_length() -> None:
    assert drawn("▌P01 ⠊⣿ ◠‿◠ ✓ año") == "│P01 ·· ^_^ * año"
