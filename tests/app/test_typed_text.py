"""A typed answer on the screen: it stands below the prompt as far as it is typed."""

from pathlib import Path

from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import open_app
from tests.documented import write_documented


async def test_digits_are_echoed_as_they_are_typed_and_sent_with_enter(
    data: Path, tmp_path: Path
) -> None:
    folder = write_documented(tmp_path / "mytasks", "digitspan")
    catalogue = Catalogue(tasks=(folder.parent,))
    task = catalogue.task("digitspan")
    plan = Plan(task, build(task.Parameters, {"attempts": 1}), "calm", "P01", seed=7)
    async with open_app(data, catalogue, plan) as driver:
        prompt = await driver.to_first_prompt()
        for _ in prompt.expected:
            await driver.wait(800)
        assert driver.sees("Type the digits.")
        await driver.press("4", "a")
        assert driver.sees("4_")
        await driver.press("7")
        assert driver.sees("47_")
        await driver.press("backspace")
        assert driver.sees("4_")
        assert not driver.sees("47_")
        assert driver.stored("SELECT count(*) FROM trials") == [(0,)]
        await driver.press("enter")
        await driver.wait(100)
        assert not driver.sees("4_")
        assert driver.stored("SELECT response, correct FROM trials") == [("4", 0)]
