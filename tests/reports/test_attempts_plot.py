"""Text plot of attempts."""

from itertools import product
from typing import Any

import pytest

from sar_tui.model.messages import Outcome
from sar_tui.model.trial_types import Metric
from sar_tui.reports.charts import BARS, ResultName, attempts_figure, result_name, round_numbers

LEVELS = [1, 2, 3, 4, 3, 4, 5, 4]
METRICS = [680.0, 813.0, 763.0, 1012.0, 818.0, 920.0, 1121.0, None]
RESULTS: list[ResultName] = [
    "reached", "reached", "reached", "missed", "reached", "reached", "missed", "no result"
]  # fmt: skip


def figure(**changes: Any) -> str:
    levels = changes.pop("levels", LEVELS)
    arguments = {"metric": "reaction time (ms)", "width": 76, "height": 12, "color": False,
                 "goals": [1000] * len(levels)} | changes  # fmt: skip
    return attempts_figure(levels, arguments.pop("metrics", METRICS), **arguments)


def flat(levels: list[int], **changes: Any) -> str:
    """Draw attempts whose results are all alike."""
    return figure(levels=levels, metrics=[700.0] * len(levels), **changes)


@pytest.mark.parametrize("size", [(76, 12), (100, 18), (50, 9), (30, 7)])
def test_it_has_the_requested_size_however_many_attempts_and_levels(size: tuple[int, int]) -> None:
    levels, metrics = [1 + n % 12 for n in range(200)], [1.0 + n % 7 for n in range(200)]
    many = figure(levels=levels, metrics=metrics, width=size[0], height=size[1])
    for drawn in (figure(width=size[0], height=size[1], results=RESULTS), many):
        lines = drawn.split("\n")
        assert len(lines) == size[1]
        assert max(map(len, lines)) <= size[0]


def test_it_names_the_axes_the_goal_and_the_markers_that_are_shown() -> None:
    heading, *_, last = figure(results=RESULTS).split("\n")
    for part in ("reaction time (ms)", "● reached", "○ missed", "× no result", "╌ goal 1000"):
        assert part in heading
    assert last.startswith("attempt ")
    assert last.split()[1:] == ["1", "2", "3", "4", "5", "6", "7", "8"]
    many = figure(levels=[1] * 200, metrics=[700.0] * 200)
    assert many.split("\n")[-1].split()[1:4] == ["1", "20", "40"]
    for body, counts in ((figure(results=RESULTS), (5, 2, 1)), (figure(), (7, 0, 1))):
        assert tuple(body.split("\n", 1)[1].count(marker) for marker in "●○×") == counts
    two = figure(levels=[1, 1], metrics=[400.0, 500.0], results=["inaccurate", "reached"])
    heading, *lines = two.split("\n")
    assert "● reached  ◇ inaccurate" in heading
    assert "missed" not in heading
    assert "no result" not in heading
    rows = [next(row for row, line in enumerate(lines) if marker in line) for marker in "◇●"]
    assert rows[0] > rows[1], "better attempts are lower"


def test_a_goal_that_changes_with_the_level_is_drawn_at_each_attempts_height() -> None:
    lines = figure(levels=[1, 2], metrics=[700.0, 700.0], goals=[500.0, 900.0]).split("\n")
    assert "╌ goal" in lines[0]
    assert "goal 500" not in lines[0]
    rows = [line for line in lines[1:] if "╌" in line]
    assert len(rows) == 2
    assert rows[0].index("╌") > rows[1].rindex("╌") - 1


def row_of(figure_text: str, marker: str) -> int:
    """Return the number of the first line of the body with a marker."""
    return next(row for row, line in enumerate(figure_text.split("\n")) if row and marker in line)


def test_an_attempt_without_result_is_below_the_axis_in_its_column() -> None:
    for count, width in product((1, 2, 7, 61), (30, 100)):
        with_all = next(row for row in flat([1] * count, width=width).split("\n")[1:] if "●" in row)
        for empty in {0, count // 2, count - 1}:
            times: list[float | None] = [700.0] * count
            times[empty] = None
            drawn = figure(levels=[1] * count, metrics=times, width=width)
            line = drawn.split("\n")[row_of(drawn, "└") + 1]
            assert line.strip() == "×"
            where = f"attempt {empty + 1} of {count} in {width} columns"
            assert with_all[line.index("×")] == "●", where


def test_figures_beside_each_other_have_their_axes_on_the_same_lines() -> None:
    full = figure(levels=[1, 1], metrics=[500.0, 700.0], beside=[600.0, None])
    with_a_gap = figure(levels=[1, 1], metrics=[600.0, None], beside=[500.0, 700.0])
    assert row_of(full, "└") == row_of(with_a_gap, "└")
    assert len(full.split("\n")) == len(with_a_gap.split("\n"))


def below_axis(drawn: str) -> list[str]:
    """Return the lines between the axis of the results and the numbers of the attempts."""
    return drawn.split("\n")[row_of(drawn, "└") + 1 : -1]


def test_levels_are_below_the_attempts_as_numbers_and_bars() -> None:
    drawn = flat(LEVELS, height=18)
    numbers, *bars = below_axis(drawn)
    results = next(line for line in drawn.split("\n")[1:] if "●" in line)
    assert numbers.split() == ["level", *map(str, LEVELS)]
    columns = [column for column, character in enumerate(results) if character == "●"]
    for level, column in zip(LEVELS, columns, strict=True):
        assert numbers[column] == str(level)
        heights = [(" " + BARS).index(line[column : column + 1] or " ") for line in bars]
        assert sum(heights) == round(level / max(LEVELS) * 2 * len(BARS))
    numbers = below_axis(flat([1] * 30 + [12] * 30 + [3] * 40))[0]
    assert numbers.split() == ["level", "1", "12", "3"], "numbered where they change"
    for height, lines in ((7, 1), (9, 2), (16, 3)):
        assert len(below_axis(flat(LEVELS, height=height))) == lines


@pytest.mark.parametrize("levels", [[0], [-1, 2], [1] * 5, [1000, 1]])
def test_any_level_has_a_bar_within_its_lines(levels: list[int]) -> None:
    drawn = flat(levels)
    assert set(below_axis(drawn)[1].strip()) <= set(BARS)
    assert len(drawn.split("\n")) == 12


@pytest.mark.parametrize(
    ("outcome", "value", "goal", "better", "name"),
    [
        ("success", 700.0, 1000.0, "lower", "reached"),
        ("failure", 1200.0, 1000.0, "lower", "missed"),
        ("failure", 1000.0, 1000.0, "lower", "missed"),
        ("failure", 400.0, 1000.0, "lower", "inaccurate"),
        ("failure", None, 1000.0, "lower", "no result"),
        ("failure", 400.0, None, "lower", "missed"),
        ("failure", 0.9, 0.5, "higher", "inaccurate"),
        ("failure", 0.4, 0.5, "higher", "missed"),
    ],
)
def test_a_failure_that_is_better_than_the_goal_is_inaccurate(
    outcome: Outcome, value: float | None, goal: float | None, better: Any, name: str
) -> None:
    assert result_name(outcome, value, goal, Metric("measure", "", better)) == name


def test_a_legend_that_does_not_fit_beside_the_heading_has_a_line_of_its_own() -> None:
    lines = figure(results=["inaccurate", *RESULTS[1:]], width=70).split("\n")
    assert len(lines) == 12
    assert lines[0] == "reaction time (ms)"
    assert lines[1].strip() == "● reached  ○ missed  ◇ inaccurate  × no result  ╌ goal 1000"


def test_colour_does_not_change_the_characters() -> None:
    import plotext

    def lines(drawn: str) -> list[str]:
        return [line.rstrip() for line in drawn.split("\n")]

    coloured, plain = (figure(color=color, results=RESULTS) for color in (True, False))
    assert "\x1b[" in coloured
    assert "\x1b" not in plain
    assert lines(plotext.uncolorize(coloured)) == lines(plain)
    plotext.plot([1, 2, 3])
    assert figure(results=RESULTS) == plain, "the same after other plots"
    plotext.clear_figure()


def test_one_attempt_is_enough_and_none_is_told_in_a_sentence() -> None:
    for metric, result in ((None, "no result"), (700.0, "missed"), (0.0, "missed")):
        assert "attempt" in figure(levels=[1], metrics=[metric], results=[result])
    assert figure(levels=[], metrics=[]) == "There are no attempts to show yet."


def test_attempts_without_any_result_or_goal_have_axes() -> None:
    drawn = figure(levels=[1, 1], metrics=[None, None], goals=[None, None])
    assert drawn.count("×") == 3, "one in the legend, and one for each attempt"


def test_there_is_a_number_at_an_axis_however_few_fit() -> None:
    assert round_numbers(0.05, 4.75, 2) == [2, 4]
    assert round_numbers(0.0, 1.0, 2) == [0.0, 0.5]
    assert round_numbers(1.1, 1.4, 1)
