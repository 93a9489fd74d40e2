"""Lists can be turned over by pages, whatever the size of the window."""

from pathlib import Path

import pytest

from sar_tui.app.screens.pause import PauseMenu
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from tests.app.app_driver import open_app, plan


@pytest.mark.parametrize("key", ["pageup", "pagedown"])
async def test_a_page_is_turned_in_a_list_that_is_not_laid_out(
    key: str, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with open_app(data, catalogue, plan(catalogue, keyboard)) as driver:
        await driver.to_first_prompt()
        await driver.press("escape")
        menu = driver.app.screen.query_one(PauseMenu)
        menu._lines.clear()
        menu._index_to_line.clear()
        getattr(menu, f"action_{key[:4]}_{key[4:]}")()
        await driver.settle()
        assert driver.app.is_running
