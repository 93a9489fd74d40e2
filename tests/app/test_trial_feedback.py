"""The answer to a trial on the screen: in the prompt's place for its time, then gone."""

from pathlib import Path

from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan
from tests.app.app_driver import AppDriver, OpenSession, open_app
from tests.documented import write_documented


def glyphs(driver: AppDriver) -> list[str]:
    """The signs on the screen, each as often as it stands there."""
    return [character for character in driver.text if character in "✓✗"]


async def test_a_tick_and_a_cross_are_shown_and_stamped(open_session: OpenSession) -> None:
    async with open_session(trial_feedback_ms=700) as driver:
        prompt = await driver.to_first_prompt()
        assert glyphs(driver) == []
        await driver.answer(prompt)
        assert "✓" in glyphs(driver)
        assert not driver.sees(prompt.text)
        assert driver.waiting.what == "result"
        await driver.wait(800)
        assert glyphs(driver) == []
        await driver.wait(1500)
        await driver.press("#")
        assert "✗" in glyphs(driver)
        await driver.wait(800)
        assert glyphs(driver) == []
        shown = driver.messages("screen/trial_feedback")
        assert [(one["attempt"], one["trial"], one["source"]) for one in shown] == [
            (1, 1, "refresh"),
            (1, 2, "refresh"),
        ]


async def test_a_pause_covers_it(open_session: OpenSession) -> None:
    async with open_session(trial_feedback_ms=700) as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.press("escape")
        assert driver.waiting.stage == "paused"
        assert glyphs(driver) == []


async def test_a_prompt_that_follows_at_once_takes_its_place(data: Path, tmp_path: Path) -> None:
    file = write_documented(tmp_path / "mytasks", "harvest") / "task.py"
    source = file.read_text("utf-8")
    file.write_text(
        source.replace("class Harvest(Task):", "class Harvest(Task):\n    has_foreperiod = False"),
        "utf-8",
    )
    catalogue = Catalogue(tasks=(tmp_path / "mytasks",))
    kind = catalogue.task("harvest")
    async with open_app(
        data, catalogue, Plan(kind, build(kind.Parameters, {}), "calm", "P01", seed=7)
    ) as driver:
        await driver.answer(await driver.to_first_prompt())
        assert driver.sees("0")
        assert not driver.sees("Left or right?")
        assert (await driver.to_prompt()).trial == 2
        assert driver.sees("Left or right?")
