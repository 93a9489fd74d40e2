"""A task without a result on the screens: home, session, summary, the list of sessions,
progress.
"""

from pathlib import Path

import pytest

from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import open_app
from tests.tasks.test_documented_tasks import documented


@pytest.mark.slow
async def test_a_session_is_played_and_its_screens_show_no_result(
    data: Path, tmp_path: Path
) -> None:
    catalogue = documented(tmp_path / "mytasks", "pleasant")
    kind = catalogue.task("pleasant")
    plan = Plan(kind, build(kind.Parameters, {"attempts": 2}), "calm", "P01", seed=7)
    async with open_app(data, catalogue, plan) as driver:
        await driver.press("enter")
        assert not driver.sees("goal")
        for _ in range(2):
            await driver.begin()
            for trial in range(4):
                if trial:
                    await driver.to_prompt()
                await driver.wait(500)
                await driver.press("7")
        assert driver.waiting.stage == "review"
        await driver.see_the_summary()
        assert driver.sees("You did 2 attempts.")
        assert "goal" not in driver.text
        assert [fault.error for fault in driver.session.faults] == []
        rows = driver.stored(
            "SELECT metric, goal, outcome, json_extract(qualities, '$.mean_rating') FROM attempts"
        )
        assert rows == [(None, None, "none", 7.0)] * 2
    async with open_app(data, catalogue) as driver:
        assert driver.sees("20 × 4 · start level 1")
        assert driver.sees("Today: 2 attempts")
        assert "of 2 reached" not in driver.text
        await driver.press("f4")
        assert driver.sees("How pleasant?")
        assert "level at goal is not known" not in driver.text
        for _ in range(6):
            await driver.press("right")
        await driver.press("escape", "f6", "enter")
        assert driver.screen_name == "PastSessionScreen"
        assert driver.sees("You did 2 attempts.")
