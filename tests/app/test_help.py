"""Help, the footer and the palette name the available keys."""

import pytest

from tests.app.app_driver import OpenApp, OpenSession


@pytest.mark.parametrize("key", ["f1", "?"])
async def test_help_describes_a_screen_and_its_keys(opened: OpenApp, key: str) -> None:
    async with opened() as driver:
        await driver.press(key)
        assert driver.sees("Choose who trains; Enter, and Enter again starts.")
        for words in ("F2 Settings", "Ctrl-Q Quit", "F1 Help", "Press Enter to close this."):
            assert driver.sees(words)
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        await driver.press(key, key)
        assert driver.screen_name == "HomeScreen"


async def test_the_footer_shows_pause_only_where_a_pause_is_possible(
    open_session: OpenSession,
) -> None:
    async with open_session() as driver:
        assert "Esc Pause" in driver.rows[-1]
        assert "Ctrl-Q Quit" in driver.rows[-1]
        assert "Ctrl-P palette" in driver.rows[-1]
        await driver.press("escape")
        assert "Pause" not in driver.rows[-1]


async def test_the_palette_lists_help_themes_and_quit(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("ctrl+p")
        for words in ("Help", "Theme: Calm", "Theme: High contrast", "Quit"):
            assert driver.sees(words)
