"""What goes wrong: a disk, a task, a window. A clear sentence, and nothing lost."""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.framework.task import Result, Task, Trial
from sar_tui.plugins import Catalogue
from tests.app.chair import known, plan, sit_down, stored


async def test_a_disk_that_refuses_sends_for_the_experimenter_and_the_session_goes_on_after(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard)) as chair:
        prompt = await chair.to_first_prompt()
        await chair.disk(False)
        assert chair.sees("Please fetch the experimenter")
        assert chair.sees("Everything you did is kept.")
        assert chair.sees("the disk is full or refuses to write")
        assert "Press: " not in chair.text

        await chair.press("enter", "escape", prompt.expected)
        await chair.wait(60_000)
        assert chair.sees("Please fetch the experimenter")

        await chair.disk(True)
        assert chair.sees("Thank you for waiting Everything is saved again. Press Enter to go on.")
        await chair.press("enter")
        assert (await chair.to_prompt()).text == prompt.text
        await chair.answer(prompt)
        assert chair.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_a_task_that_raises_sends_for_the_experimenter_and_the_app_fails(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    class Loose(keyboard):  # type: ignore[valid-type, misc]
        def perceived(self, trial: Trial, percept: Any) -> Result:
            if trial.situation.trial == 2:
                raise RuntimeError("a wire is loose")
            return Result(correct=True, response=percept.key, response_at=percept.at, value=1.0)

    async with sit_down(data, catalogue, plan(Loose)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        assert chair.sees("Please fetch the experimenter")
        assert chair.sees("Everything you did is kept.")
        assert "wire" not in chair.text
        assert "Traceback" not in chair.text
        assert chair.sees("Press Enter to close.")
        await chair.press("enter")
        assert not chair.app.is_running
        assert chair.app.return_code == 1
        assert "The task keyboard failed" in chair.app.failure
        assert "a wire is loose" in chair.app.failure
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert stored(data, "SELECT count(*) FROM trials") == [(1,)]


async def test_a_task_that_cannot_be_set_up_is_told_on_the_home_screen(data: Path, catalogue: Catalogue) -> None:
    class Missing(Catalogue):
        def task(self, name: str) -> type[Task]:
            class Unplugged(catalogue.task(name)):  # type: ignore[misc]
                def __init__(self, parameters: object) -> None:
                    raise OSError("no sensor")

            return Unplugged

    known(data, "P01")
    async with sit_down(data, Missing()) as chair:
        await chair.press("right", "right", "right", "enter")
        assert chair.screen_name == "HomeScreen"
        assert chair.sees("cannot be set up (OSError: no sensor)")


async def test_a_session_that_cannot_be_gone_on_with_ends_the_app_with_a_sentence(
    data: Path, catalogue: Catalogue
) -> None:
    async with sit_down(data, catalogue, "nosuchsession") as chair:
        assert not chair.app.is_running
        assert chair.app.return_code == 1
        assert chair.app.failure == "There is no session nosuchsession. `sar-tui sessions` lists them."


@pytest.mark.parametrize("size", [(79, 24), (80, 23), (20, 5)])
async def test_a_window_that_is_too_small_from_the_start_says_so_and_recovers(
    size: tuple[int, int], data: Path, catalogue: Catalogue
) -> None:
    async with sit_down(data, catalogue, size=size) as chair:
        assert chair.sees("This window is too small.")
        await chair.resize(60, 20)
        assert chair.sees("It has 60 by 20 characters; 80 by 24 are needed.")
        await chair.resize(80, 24)
        assert chair.screen_name == "HomeScreen"
        assert chair.sees("+ New participant")
        await chair.resize(50, 24)
        assert chair.sees("This window is too small.")
        await chair.resize(120, 40)
        assert chair.screen_name == "HomeScreen"
        assert chair.sees("+ New participant")
