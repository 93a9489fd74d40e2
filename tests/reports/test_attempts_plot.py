"""Text plot of attempts."""

import pytest

from sar_tui.reports.attempts_plot import attempts_figure

LEVELS = [1, 2, 3, 4, 3, 4, 5, 4]
METRICS = [680.0, 813.0, 763.0, 1012.0, 818.0, 920.0, 1121.0, None]
OUTCOMES = ["success", "success", "success", "failure", "success", "success", "failure", "failure"]


def figure(**changes: object) -> str:
    arguments = {"metric": "reaction time (ms)", "width": 76, "height": 12, "color": False} | changes
    levels = arguments.pop("levels", LEVELS)
    arguments.setdefault("goals", [1000] * len(levels))  # type: ignore[arg-type]
    return attempts_figure(levels, arguments.pop("metrics", METRICS), **arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [(76, 12), (100, 18), (50, 9), (30, 7)])
def test_it_has_the_requested_size(size: tuple[int, int]) -> None:
    lines = figure(width=size[0], height=size[1], outcomes=OUTCOMES).split("\n")
    assert len(lines) == size[1]
    assert max(map(len, lines)) <= size[0]


def test_it_names_both_axes_the_goal_and_the_markers() -> None:
    heading, *_, last = figure(outcomes=OUTCOMES).split("\n")
    for part in ("reaction time (ms)", "● reached", "○ missed", "× no result", "╌ goal 1000", "░ level"):
        assert part in heading
    assert last.startswith("attempt ")
    assert last.split()[1:] == ["1", "2", "3", "4", "5", "6", "7", "8"]


def test_a_goal_that_changes_with_the_level_is_drawn_at_each_attempts_height() -> None:
    lines = figure(levels=[1, 2], metrics=[700.0, 700.0], goals=[500.0, 900.0]).split("\n")
    assert "╌ goal " in lines[0]
    assert "goal 500" not in lines[0]
    rows = [line for line in lines[1:] if "╌" in line]
    assert len(rows) == 2
    assert rows[0].index("╌") > rows[1].rindex("╌") - 1


def test_success_failure_and_no_result_have_different_markers() -> None:
    body = figure(outcomes=OUTCOMES).split("\n", 1)[1]
    assert (body.count("●"), body.count("○"), body.count("×")) == (5, 2, 1)


def test_without_outcomes_all_attempts_look_alike() -> None:
    body = figure().split("\n", 1)[1]
    assert (body.count("●"), body.count("○"), body.count("×")) == (7, 0, 1)


def test_better_attempts_are_lower_and_levels_label_the_right_axis() -> None:
    lines = figure(levels=[1, 2], metrics=[500.0, 900.0], outcomes=["success"] * 2).split("\n")[1:]
    rows = [number for number, line in enumerate(lines) if "●" in line]
    assert lines[rows[0]].index("●") > lines[rows[-1]].index("●")
    assert [line.rstrip()[-1] for line in lines if "├" in line] == ["2", "1"]


def test_colour_does_not_change_the_characters() -> None:
    import plotext

    coloured = figure(color=True, outcomes=OUTCOMES)
    assert "\x1b[" in coloured
    assert "\x1b" not in figure(outcomes=OUTCOMES)
    assert [line.rstrip() for line in plotext.uncolorize(coloured).split("\n")] == [
        line.rstrip() for line in figure(outcomes=OUTCOMES).split("\n")
    ]


def test_a_plot_is_the_same_after_other_plots() -> None:
    import plotext

    first = figure()
    plotext.plot([1, 2, 3])
    assert figure() == first
    plotext.clear_figure()


@pytest.mark.parametrize("metrics", [[None], [700.0], [0.0]])
def test_one_attempt_is_enough(metrics: list[float | None]) -> None:
    assert "attempt" in figure(levels=[1], metrics=metrics, outcomes=["failure"])


def test_many_attempts_and_levels_still_fit() -> None:
    lines = figure(levels=[1 + n % 12 for n in range(200)], metrics=[1.0 + n % 7 for n in range(200)]).split("\n")
    assert len(lines) == 12
    assert max(map(len, lines)) <= 76
    assert lines[-1].split()[1:4] == ["1", "20", "40"]


def test_a_session_without_attempts_is_described_in_a_sentence() -> None:
    assert figure(levels=[], metrics=[]) == "There are no attempts to show yet."
