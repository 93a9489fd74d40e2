"""Lists can be turned over by pages, whatever the size of the window."""

import pytest

from sar_tui.app.screens.pause import PauseMenu
from tests.app.app_driver import OpenSession


@pytest.mark.parametrize("key", ["pageup", "pagedown"])
async def test_a_page_is_turned_in_a_list_that_is_not_laid_out(
    open_session: OpenSession, key: str
) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.press("escape")
        menu = driver.app.screen.query_one(PauseMenu)
        menu._lines.clear()
        menu._index_to_line.clear()
        getattr(menu, f"action_{key[:4]}_{key[4:]}")()
        await driver.settle()
        assert driver.app.is_running
