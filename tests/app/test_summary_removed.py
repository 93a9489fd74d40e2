"""A summary that is removed while it waits to be drawn draws nothing, and ends nothing."""

from pathlib import Path

from textual.widgets import Static

from sar_tui.app.screens.summary import Summary
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.store import sessions
from tests.app.app_driver import open_app, plan


async def test_a_summary_without_its_parts_draws_nothing(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with open_app(data, catalogue, plan(catalogue, keyboard)) as driver:
        await driver.do_session()
        summary = driver.app.screen.query_one(Summary)
        rows = sessions.rows(driver.app.database, "attempts", driver.session_id)
        summary.show([sessions.attempt_ended(row) for row in rows])  # asks to be drawn after the next refresh
        await summary.query_one("#plot", Static).remove()
        await driver.settle()
        summary.on_resize()
        assert driver.app.is_running
