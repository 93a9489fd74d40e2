"""The task and the view of docs/write-your-own-task.md, taken from the page: they pass the check
and run in the app.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import open_app
from tests.documented import write_documented


@pytest.fixture
def arrows(tmp_path: Path) -> Path:
    """The task's folder, as the page describes it."""
    return write_documented(tmp_path / "mytasks", "arrows", "task", "view")


@pytest.mark.slow
def test_they_pass_the_check(arrows: Path) -> None:
    results = list(check(arrows))
    assert [each.problems for each in results if not each.ok] == []
    assert "draws its view in a whole session" in [each.check for each in results]


async def test_the_view_draws_in_a_session(data: Path, arrows: Path) -> None:
    catalogue = Catalogue(tasks=(arrows.parent,))
    task = catalogue.task("arrows")
    plan = Plan(task, build(task.Parameters, {"attempts": 2}), "calm", "P01", seed=7)
    async with open_app(data, catalogue, plan) as driver:
        prompt = await driver.to_first_prompt()
        sign = {"left": "←", "right": "→", "up": "↑", "down": "↓"}[prompt.expected]
        assert sign * 80 in driver.text
        assert driver.sees(f"Press: {prompt.expected}")
        await driver.do_attempt(prompt)
        assert "██████" in driver.text
        await driver.do_attempt(await driver.begin())
        await driver.see_the_summary()
        assert driver.sees("Right arrows: 20.")
        assert [fault.error for fault in driver.session.faults] == []
