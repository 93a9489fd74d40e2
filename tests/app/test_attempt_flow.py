"""The screen between attempts of a continuous task, and of one whose interrupted attempts begin
again.
"""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from sar_tui.model.messages import SessionCommand
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import AppDriver, open_app
from tests.tasks.test_documented_tasks import documented


@pytest.fixture
async def two_back(data: Path, tmp_path: Path) -> AsyncIterator[AppDriver]:
    """A session of the documented task, on its first prompt."""
    catalogue = documented(tmp_path / "mytasks", "twoback")
    kind = catalogue.task("twoback")
    parameters = build(kind.Parameters, {"attempts": 3, "feedback_schedule": "none"})
    async with open_app(data, catalogue, Plan(kind, parameters, "calm", "P01", seed=7)) as driver:
        await driver.to_first_prompt()
        yield driver


async def test_the_screen_says_that_the_next_attempt_begins_by_itself(two_back: AppDriver) -> None:
    for _ in range(19):
        await two_back.to_prompt()
    await two_back.wait(2100)
    assert two_back.waiting.stage == "attempt"
    assert two_back.sees("The next one begins by itself.")
    assert not two_back.sees("Press Enter")
    assert (await two_back.to_prompt()).attempt == 2


async def test_the_screen_says_that_an_attempt_begins_again_and_counts_it_once(
    two_back: AppDriver,
) -> None:
    await two_back.to_prompt()
    await two_back.press("escape")
    assert two_back.app.live
    two_back.app.live.operate(SessionCommand(command="resume"))
    await two_back.settle()
    assert two_back.sees("This attempt begins again.")
    assert two_back.sees("Attempts 0 of 3")
    assert (await two_back.begin()).attempt == 2
    assert two_back.sees("Attempt 1 of 3")
