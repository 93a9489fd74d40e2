"""Sessions of other sites in the app: they are listed and opened, and changed only at their
site.
"""

from pathlib import Path

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from tests.app.app_driver import open_app, plan, stored
from tests.store.merge.sites import change, merge, site


async def test_a_session_of_another_site_is_seen_and_left_as_it_is(
    data: Path, tmp_path: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    bern = tmp_path / "bern"
    async with open_app(bern, catalogue, plan(catalogue, keyboard, "P01")) as driver:
        await driver.answer(await driver.to_first_prompt())
    change(bern, "INSERT INTO site VALUES (1, 'BERN')")
    merge(site(data, "ZURICH"), bern)
    async with open_app(data, catalogue) as driver:
        assert driver.sees("+ New participant"), "nobody of this site is known yet"
        assert driver.sees("P01@BERN")
        assert not driver.sees("Enter resumes")
        driver.app.screen.query_one("#recent").focus()
        await driver.settle()
        assert "Dismiss" not in driver.rows[-1]
        await driver.press("delete", "enter")
        assert driver.sees("P01@BERN · Keyboard reaction")
        await driver.press("escape", "escape", "enter")
        await driver.write(*"p01@bern")
        assert driver.sees("P01@BERN is a participant of BERN")
        await driver.press("escape")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert stored(data, "SELECT code, site FROM participants") == [("P01@BERN", "BERN")]
