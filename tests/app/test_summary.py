"""The summary of a session: its facts, its plot, and the earlier session beside it."""

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import pytest

from sar_tui.app.screens.summary import LARGE, SMALL, Layout, beside, draw_picture, facts
from sar_tui.model.language import Language
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.trial_types import Metric
from sar_tui.tui.heading import figures_in_blocks
from sar_tui.widgets.block_digits import draw_digits, draw_share
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, open_app
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


NO_DAY = attempts((1, 1400.0, False), (1, None, False))


def drawn(played: Sequence[AttemptEnded], room: int = 80) -> list[str]:
    """Return a participant's words and picture, in a small window."""
    lines = beside(facts(played, TIME, Language()), played, room)
    return [line.plain.replace("\N{NO-BREAK SPACE}", " ").rstrip() for line in lines]


def picture(played: Sequence[AttemptEnded], layout: Layout = SMALL) -> list[str]:
    """Return one participant's picture, with its words."""
    content = draw_picture(played, 70, Language(), layout)
    lines = content.plain.replace("\N{NO-BREAK SPACE}", " ").split("\n")
    return [line.rstrip() for line in lines]


def test_the_picture_has_a_mark_for_each_attempt_and_levels_that_never_fall() -> None:
    goals, levels, best = drawn(GOOD_DAY)
    assert goals.split("   ")[0] == "4 of 5 goals reached"
    assert goals.endswith("● ● ● ● ○")
    assert levels.startswith("You began at level 1 and finished at level 5")
    assert levels.endswith("▂ ▃ ▅ ▆ █")
    assert best == "Your best: 0.40 seconds"


def test_a_level_that_fell_again_is_told_and_drawn_by_its_highest() -> None:
    played = attempts((3, 700.0, True), (4, 800.0, True), (3, None, False))
    _, levels, _ = drawn(played)
    assert levels.startswith("You began at level 3 and got up to level 4")
    assert levels.endswith("▆ █ █")


def test_where_the_level_only_fell_no_level_is_told() -> None:
    lines = drawn(attempts((3, 1400.0, False), (2, 1200.0, False), (1, 900.0, True)))
    assert [line.partition("   ")[0] for line in lines] == [
        "1 of 3 goals reached", "Your best: 0.90 seconds"
    ]  # fmt: skip
    assert not any(char in "".join(lines) for char in "▁▂▃▄▅▆▇█")


@pytest.mark.parametrize("room", [80, 40])
def test_without_a_goal_reached_nothing_is_drawn(room: int) -> None:
    assert drawn(NO_DAY, room) == ["You did 2 attempts."]
    assert picture(NO_DAY) == [""]


def test_the_picture_is_below_the_words_where_there_is_no_room_beside_them() -> None:
    assert len(drawn(GOOD_DAY, 50)) == len(drawn(GOOD_DAY)) + 2


def test_words_say_what_the_picture_shows() -> None:
    assert picture(GOOD_DAY) == [
        "                              5",
        "              1      ▂▂▂ ▅▅▅ ███",
        "       level ▃▃▃ ▆▆▆ ███ ███ ███",
        "goal reached  ●   ●   ●   ●   ○",
    ]


def test_where_no_level_rose_only_the_marks_are_drawn() -> None:
    assert picture(GOOD_DAY[:1]) == ["goal reached  ●"]


def test_in_a_large_window_the_picture_is_tall() -> None:
    _, *lines, blank, _ = picture(GOOD_DAY, LARGE)
    heights = [sum(line.ljust(45)[column] != " " for line in lines) for column in range(13, 43, 6)]
    assert heights == sorted(heights)
    assert heights[-1] == len(lines) == 5
    assert blank == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("9 of 10 goals reached", " goals reached"),
        ("9 von 10 Zielen erreicht", " Zielen erreicht"),
        ("0.45 seconds", " seconds"),
    ],
)
def test_only_figures_are_in_block_letters(text: str, words: str) -> None:
    drawn = [line.replace("\N{NO-BREAK SPACE}", " ") for line in figures_in_blocks(text, 100)]
    assert drawn[-1].endswith(words)
    assert len({len(line) for line in drawn}) == 1
    assert figures_in_blocks(text, 20) == []


def test_the_words_of_large_figures_stand_in_the_middle_below_them() -> None:
    assert [
        row.replace("\N{NO-BREAK SPACE}", " ") for row in draw_share("9 of 10 goals reached")
    ] == [
        "█▀█    ▄█  █▀█",
        "▀▀█ of  █  █ █",
        "▀▀▀    ▀▀▀ ▀▀▀",
        "goals reached ",
    ]
    *_, words = figures_in_blocks("9 of 10 goals reached", 100, is_below=True)
    sides = words.replace("\N{NO-BREAK SPACE}", " ").split("G O A L S   R E A C H E D")
    assert abs(len(sides[0]) - len(sides[1])) <= 1
    assert draw_share("You did 1 attempt.") == []


def test_no_small_digit_can_be_taken_for_another() -> None:
    drawn = {digit: "".join(draw_digits(digit)) for digit in "0123456789"}
    halves = {
        digit: "".join({"█": "11", "▀": "10", "▄": "01", " ": "00"}[sign] for sign in rows)
        for digit, rows in drawn.items()
    }
    for one, other in combinations(halves, 2):
        apart = sum(a != b for a, b in zip(halves[one], halves[other], strict=True))
        assert apart >= (4 if "1" in (one, other) else 1), (one, other)


async def test_a_completed_session_is_praised_with_its_number_and_the_next_meeting(
    open_session: OpenSession,
) -> None:
    for number in (1, 2):
        async with open_session(days_between_visits=1) as driver:
            await to_comparison(driver)
            driver.see("W E L L D O N E", f"That was session {number}.", "See you tomorrow.")
            driver.see("Press Enter to finish.")


async def test_a_session_that_ended_early_is_thanked_for(open_session: OpenSession) -> None:
    async with open_session() as driver:
        await driver.to_first_prompt()
        await driver.press("escape", *["down"] * 3, "enter", "down", "enter")
        driver.see("Thank you for today", "No attempt was finished. That is all right.")
        driver.lacks("W E L L", "session 1")


async def test_a_therapist_sees_results_and_levels_over_attempts(
    open_session: OpenSession, opened: OpenApp
) -> None:
    async with open_session() as driver:
        await driver.do_session()
    async with opened() as driver:
        await driver.press("f6", "enter")
        driver.see(
            "You did 2 attempts; goal reached in 2.", "reaction time (s)", "level", "attempt"
        )


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
            driver.see("▀▀█ ▀▀█ █▀▀ of █▀▀ ▀▀▀ ▀▀▀ goals reached")
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
        driver.see("20 attempts, 4 prompts each", "start level 1", "Today: 2 attempts")
        assert "of 2 reached" not in driver.text
        await driver.press("f4")
        driver.see("How pleasant?")
        assert "level at goal is not known" not in driver.text
        for _ in range(6):
            await driver.press("right")
        await driver.press("escape", "f6", "enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("You did 2 attempts.")
