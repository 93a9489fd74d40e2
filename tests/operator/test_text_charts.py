"""Small charts and cut texts of the panel, and the plot of the session's attempts on a large one."""

from pathlib import Path

import pytest
from rich.cells import cell_len

from sar_tui.loop import topics as t
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.trial_types import NO_METRIC, Metric
from sar_tui.operator.text_charts import cut, motion, responses, trend, two_lines, wrap
from sar_tui.plugins import Catalogue
from sar_tui.reports.charts import sparkline
from tests.operator import panel_driver as b

TIME = Metric("reaction_time", "ms", "lower")
PRACTICE = b.attempt(attempt=1, practice=True, level=1)
DONE = (
    PRACTICE,
    b.attempt(attempt=2, level=1),
    b.attempt(attempt=3, level=2, metric=700.0, outcome="failure"),
    b.attempt(attempt=4, level=2, metric=None, outcome="failure"),
)


def test_responses_have_different_signs_and_the_oldest_are_left_out() -> None:
    trials = [b.trial(1, "f", 400), b.trial(2, "j", 400, correct=False), b.trial(3, "d", None)]
    assert "".join(text for text, _ in responses(trials, 40)) == "✓f ✗j –d "
    many = [b.trial(0, "a", 1.0), *(b.trial(number, "f", 400) for number in range(1, 9))]
    assert "".join(text for text, _ in responses(many, 24)) == "✓f " * 8


def test_a_sparkline_reaches_from_the_least_to_the_greatest_and_leaves_gaps() -> None:
    assert sparkline([100.0, None, 200.0], 10) == "▁·█"
    assert sparkline([None], 10) == "·"
    assert sparkline([300.0, 300.0], 10) == "▁▁"


def test_motion_is_drawn_within_its_width_and_noise_stays_low() -> None:
    assert len(motion([0.1] * 400, 30)) <= 30
    assert set(motion([0.05] * 30, 30)) == {"▁"}
    assert motion([], 30) == ""


@pytest.mark.parametrize(
    "text", ["", "short", "one two three four five six", "漢字 漢字 漢字 漢字 漢字", "x" * 50]
)
def test_text_fits_exactly_two_lines(text: str) -> None:
    lines = two_lines(text, 10).split("\n")
    assert len(lines) == 2
    assert all(cell_len(line) <= 10 for line in lines)
    assert cell_len(cut(text, 10)) <= 10
    assert "".join(lines).endswith("…") == (cell_len(text) > 20)


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("", []),
        ("short", ["short"]),
        ("one two three four", ["one two", "three four"]),
        ("one two three four five", ["one two", "three fou…"]),
        ("one\ntwo", ["one", "two"]),
        ("one\ntwo\nthree", ["one", "two…"]),
        ("x" * 25, ["x" * 10, "x" * 9 + "…"]),
    ],
)
def test_text_is_wrapped_and_cut_with_an_ellipsis(text: str, lines: list[str]) -> None:
    assert wrap(text, 10, 2) == lines


# --- the plot of attempts


def test_it_shows_results_and_levels_without_practice() -> None:
    plot = trend(DONE, TIME, 54, 14)
    lines = plot.plain.split("\n")
    assert len(lines) == 14
    assert max(map(len, lines)) <= 54
    assert lines[1].strip() == "● reached  ○ missed  × no result  ╌ goal 520"
    assert lines[-3].split() == ["level", "1", "2", "2"]
    styles = {plot.plain[span.start]: span.style for span in plot.spans}
    assert (styles["●"], styles["○"], styles["×"]) == ("$success", "$warning", "$warning")


@pytest.mark.parametrize(
    ("attempts", "metric", "text"),
    [
        ((), TIME, "No attempt finished yet"),
        ((PRACTICE,), TIME, "No attempt finished yet"),
        (DONE, None, "No attempt finished yet"),
        (DONE, NO_METRIC, "This task has no result"),
    ],
)
def test_without_results_it_says_so(
    attempts: tuple[AttemptEnded, ...], metric: Metric | None, text: str
) -> None:
    assert trend(attempts, metric, 54, 14).plain == text


def test_attempts_without_goal_have_a_marker_and_no_line() -> None:
    free = [b.attempt(attempt=number, goal=None, outcome="none") for number in (2, 3)]
    plot = trend(free, TIME, 54, 14)
    assert "• no goal" in plot.plain
    assert "goal 0" not in plot.plain
    assert "╌" not in plot.plain
    assert {plot.plain[span.start]: span.style for span in plot.spans}["•"] == "$accent"


async def test_it_stands_beside_the_log_where_there_is_room(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    for size, is_shown in (((119, 40), False), ((120, 24), True)):
        async with b.open_panel(catalogue, tmp_path, size=size) as driver:
            await driver.publish(t.ATTEMPT_ENDED, b.attempt(attempt=3))
            assert ("reaction time (ms)" in driver.text) is is_shown
            assert "Encourage 1/10" in driver.text
