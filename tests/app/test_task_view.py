"""A task's own view draws itself in a session; one that fails costs the participant nothing. The view of
docs/write-your-own-task.md, taken from the page, passes the check and draws.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.plugins import Catalogue
from tests.app.app_driver import SHORT, AppDriver, OpenSession, open_app
from tests.documented import write_documented
from tests.examples import first_rows
from tests.sides_task import VIEW, write_sides


@pytest.fixture
def own_tasks(tmp_path: Path) -> Path:
    """A folder of tasks outside of the checkout, as `--tasks DIR` names it."""
    return write_sides(tmp_path / "mine").parent


async def play(driver: AppDriver) -> list[str]:
    """Do both attempts and return the screens seen: a prompt, between attempts, the summary."""
    prompt = await driver.to_first_prompt()
    seen = [driver.text]
    await driver.do_attempt(prompt)
    seen.append(driver.text)
    await driver.finish(await driver.begin())
    return [*seen, " ".join(driver.text.split())]


@pytest.mark.slow
async def test_a_task_outside_the_checkout_draws_in_all_places(
    open_task: OpenSession, data: Path, own_tasks: Path
) -> None:
    (own_tasks / "sides" / "view.py").write_text(VIEW)
    async with open_task(own_tasks / "sides", **SHORT) as driver:
        prompt, between, summary = await play(driver)
        assert "<<< Press: f >>>" in prompt
        assert "2 trials, drawn" in between
        assert "The view counts 4." in summary
        assert [fault.error for fault in driver.session.faults] == []
        await driver.press("enter")
    async with open_app(data, Catalogue(tasks=(own_tasks,))) as driver:
        driver.app.screen.query_one("#recent").focus()
        await driver.press("enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("The view counts 4.")


async def test_a_slider_follows_the_keys(
    open_task: OpenSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_documented(tmp_path / "mytasks", "slider", "task", "view")
    monkeypatch.chdir(tmp_path)
    async with open_task(Path("mytasks/slider"), attempts=1) as driver:
        await driver.to_first_prompt()
        await driver.wait(300)
        assert "─────●─────" in driver.text
        await driver.press("right")
        assert "──────●────" in driver.text
        await driver.press("left")
        assert "─────●─────" in driver.text
        assert [fault.error for fault in driver.session.faults] == []


FAULTS = [
    (VIEW, "raise RuntimeError('no such file')", "load"),
    ("return [(f", "return [(prompt.nothing + f", "prompt_lines"),
    ("self.trials += 1", "self.trial += 1", "event_handler/trial"),
    ("for a in attempts", "for a in attempt", "facts"),
    ("class SidesView(TaskView)", "class SidesView", "load"),
    ("self.trials = 0", "raise RuntimeError", "load"),
    ("{prompt.text}", "your prompt", "prompt_lines"),
    ("return [(f", "return 3 #", "prompt_lines"),
    ('colors["accent"]', "1 / 0", "drawing"),
    ("return lambda", "raise RuntimeError\n        return lambda", "between_attempts"),
]
"""Replacements in the view, and where each is noticed."""


@pytest.mark.parametrize(("old", "new", "topic"), first_rows(2, FAULTS))
async def test_a_view_that_fails_is_recorded_and_the_session_goes_on(
    open_task: OpenSession, own_tasks: Path, old: str, new: str, topic: str
) -> None:
    assert old in VIEW
    (own_tasks / "sides" / "view.py").write_text(VIEW.replace(old, new))
    async with open_task(own_tasks / "sides", **SHORT) as driver:
        prompt, between, summary = await play(driver)
        assert "Press: f" in prompt
        if topic in ("load", "prompt_lines"):
            assert "█" in prompt
        assert "Press Enter for attempt 2 of 2." in between
        assert "▀▀█ ▀▀█ █▀▀ of █▀▀ ▀▀▀ ▀▀▀ goals reached" in summary
        faults = driver.messages("framework/fault")
        assert {fault["topic"] for fault in faults} == {topic}
        assert {fault["node"] for fault in faults} == {"view"}
        assert driver.stored("SELECT count(*) FROM trials WHERE correct") == [(4,)]


@pytest.fixture
def arrows(tmp_path: Path) -> Path:
    """The task's folder, as the page describes it."""
    return write_documented(tmp_path / "mytasks", "arrows", "task", "view")


@pytest.mark.slow
def test_they_pass_the_check(arrows: Path) -> None:
    results = list(check(arrows))
    assert [each.problems for each in results if not each.ok] == []
    assert "draws its view in a whole session" in [each.check for each in results]


async def test_the_view_draws_in_a_session(open_task: OpenSession, arrows: Path) -> None:
    async with open_task(arrows, attempts=2) as driver:
        prompt = await driver.to_first_prompt()
        sign = {"left": "←", "right": "→", "up": "↑", "down": "↓"}[prompt.expected]
        assert sign * 80 in driver.text
        driver.see(f"Press: {prompt.expected}")
        await driver.do_attempt(prompt)
        assert "██████" in driver.text
        await driver.finish(await driver.begin())
        driver.see("Right arrows: 20.")
        assert [fault.error for fault in driver.session.faults] == []
