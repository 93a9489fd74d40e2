"""A rest that must be taken, on the screen."""

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from tests.app.app_driver import OpenApp, plan


async def test_the_rest_tells_the_time_that_is_left_until_enter_helps_again(
    opened: OpenApp, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    resting = plan(
        catalogue, keyboard, attempts=3, rest_after_attempts=1, rest_seconds=65, encouragement=False
    )
    async with opened(resting) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        assert driver.sees("A short rest We go on in 1 minute 5 seconds.")
        await driver.wait(4000)
        assert "Now a rest. Put your hands down for a while." in driver.said
        assert driver.app.screen.stage.agent.widget.face == "sleeping"  # type: ignore[attr-defined]
        await driver.press("enter")
        await driver.wait(56_400)
        assert driver.sees("We go on in 5 seconds.")
        await driver.wait(5000)
        assert driver.sees("Press Enter for attempt 2 of 3.")
        assert driver.said == "Start when you are ready."
        assert not driver.sees("you ━"), "the agent speaks of something else"


async def test_the_therapist_ends_the_rest_from_the_pause_menu(
    opened: OpenApp, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    resting = plan(catalogue, keyboard, rest_after_attempts=1)
    async with opened(resting) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.press("escape", "up", "enter")
        assert driver.sees("End the rest")
        await driver.press("enter")
        assert driver.sees("Press Enter for attempt 2 of 2.")
        ended = [act for act in driver.messages("operator/act") if act["command"] == "skip"]
        assert [(act["actor"], act["reason"]) for act in ended] == [("therapist", "rest")]
