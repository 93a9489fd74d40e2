"""The summary of a session: its facts, its plot, and the earlier session beside it."""

from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from pathlib import Path

import pytest
from textual.widgets import Static

from sar_tui.app.screens.summary import Summary
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from tests.app.app_driver import AppDriver, OpenSession, open_app
from tests.tasks.test_documented_tasks import documented

TIME = Metric("reaction_time", "ms", "lower")


def attempts(*played: tuple[int, float | None, bool]) -> list[AttemptEnded]:
    """Return attempts of a level, with a result, that reached the goal or did not."""
    return [
        AttemptEnded(
            attempt=number, practice=False, level=level, metric=metric, metric_unit="ms",
            accuracy=1.0, correct=5, trials=5, goal=1000.0,
            outcome="success" if reached else "failure", feedback="none", started=0, ended=0,
        )
        for number, (level, metric, reached) in enumerate(played, 1)
    ]  # fmt: skip


GOOD_DAY = attempts(
    (1, 400.0, True), (2, 600.0, True), (3, 800.0, True), (4, 950.0, True), (5, 1100.0, False)
)


Plot = Callable[[Sequence[AttemptEnded], bool], Awaitable[list[str]]]


@pytest.fixture
async def plot(data: Path, catalogue: Catalogue) -> AsyncIterator[Plot]:
    """Return the lines of a summary's plot, for its participant or for others."""
    async with open_app(data, catalogue) as driver:

        async def drawn(played: Sequence[AttemptEnded], for_participant: bool) -> list[str]:
            summary = Summary(TIME, for_participant=for_participant)
            await driver.app.screen.mount(summary)
            summary.styles.height, summary.styles.width = 20, 80
            summary.query_one("#plot").styles.height = 15
            summary.show(played)
            await driver.settle()
            return str(summary.query_one("#plot", Static).content).splitlines()

        yield drawn


def heights(lines: Sequence[str]) -> list[int]:
    """Return the rows of the markers in the plot, from left to right; the lowest is 0."""
    plot = lines[1 : next(row for row, line in enumerate(lines) if "└" in line)]
    places = [
        (column, row)
        for row, line in enumerate(plot)
        for column, char in enumerate(line)
        if char in "●○"
    ]
    return [len(plot) - row for _, row in sorted(places)]


async def test_a_risen_level_with_slower_results_is_no_fall(plot: Plot) -> None:
    lines = await plot(GOOD_DAY, True)
    shown = heights(lines)
    assert len(shown) == 5
    assert shown == sorted(shown)
    assert lines[0].startswith("goals reached")
    assert not any("▁" <= char <= "█" for line in lines for char in line), "no bar falls either"
    assert next(line for line in lines if line.startswith("level")).split() == ["level", *"12345"]


async def test_faster_results_are_not_drawn_as_a_fall(plot: Plot) -> None:
    played = attempts(
        (3, 1400.0, False), (2, 1200.0, False), (1, 900.0, True), (1, 800.0, True), (1, None, False)
    )
    shown = heights(await plot(played, True))
    assert shown == sorted(shown)
    assert shown[0] == shown[1]
    assert shown[3] == shown[4]


@pytest.mark.parametrize(
    "played", [attempts((1, 1400.0, False)), attempts((1, None, False), (1, None, False))]
)
async def test_without_a_goal_nothing_is_drawn(plot: Plot, played: list[AttemptEnded]) -> None:
    assert await plot(played, True) == []


async def test_a_therapist_sees_results_and_levels_over_attempts(plot: Plot) -> None:
    lines = await plot([*GOOD_DAY, *attempts((5, 900.0, False))], False)
    assert lines[0].startswith("reaction time (s)")
    assert "◇ inaccurate" in lines[0], "fast enough, but too few were right"
    assert any("█" in line for line in lines)


async def to_comparison(driver: AppDriver) -> None:
    await driver.do_session()
    await driver.app.workers.wait_for_complete(
        [each for each in driver.app.workers if each.name == "comparison"]
    )
    await driver.settle()


@pytest.mark.slow
async def test_only_a_later_like_session_is_compared(open_session: OpenSession) -> None:
    compared = []
    for settings in ({}, {}, {"threshold": 900.0}):
        async with open_session(max_level=1, **settings) as driver:
            await to_comparison(driver)
            driver.see("You did 2 attempts; goal reached in 2.")
            compared.append(driver.sees("Today 0.40 seconds, "))
    assert compared == [False, True, False]


@pytest.mark.slow
async def test_a_played_session_shows_no_result(
    open_task: OpenSession, data: Path, tmp_path: Path
) -> None:
    catalogue = documented(tmp_path / "mytasks", "pleasant")
    async with open_task(tmp_path / "mytasks" / "pleasant", attempts=2) as driver:
        await driver.press("enter")
        driver.lacks("goal")
        for _ in range(2):
            await driver.begin()
            for trial in range(4):
                if trial:
                    await driver.to_prompt()
                await driver.wait(500)
                await driver.press("7")
        assert driver.waiting.stage == "review"
        await driver.see_the_summary()
        driver.see("You did 2 attempts.")
        assert "goal" not in driver.text
        assert [fault.error for fault in driver.session.faults] == []
        rows = driver.stored(
            "SELECT metric, goal, outcome, json_extract(qualities, '$.mean_rating') FROM attempts"
        )
        assert rows == [(None, None, "none", 7.0)] * 2
    async with open_app(data, catalogue) as driver:
        driver.see("20 × 4 · start level 1", "Today: 2 attempts")
        assert "of 2 reached" not in driver.text
        await driver.press("f4")
        driver.see("How pleasant?")
        assert "level at goal is not known" not in driver.text
        for _ in range(6):
            await driver.press("right")
        await driver.press("escape", "f6", "enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("You did 2 attempts.")
