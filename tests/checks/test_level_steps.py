"""Neighbouring levels that are far apart are named, and nothing is refused for it."""

from collections.abc import Sequence
from typing import Any

import pytest

from sar_tui.checks import level_steps
from sar_tui.loop.task import Task
from sar_tui.rules.parameters import TaskParameters, build


def attempts(*means: float, spread: float = 40.0, goal: float = 1000.0) -> list[dict[str, Any]]:
    """Return eight attempts at each level, with these mean results and about this standard
    deviation.
    """
    signs = (-1.2, -0.8, -0.5, -0.2, 0.2, 0.5, 0.8, 1.2)
    return [
        {"level": level, "metric": mean + sign * spread / 0.8, "goal": goal}
        for level, mean in enumerate(means, 1)
        for sign in signs
    ]


def test_a_jump_is_named_with_its_distance() -> None:
    found = level_steps.far_apart(attempts(600, 630, 840, 860), lower_is_better=True)
    assert "standard deviation of an attempt's result apart: 2 and 3 (5.1)." in found


@pytest.mark.parametrize("means", [(600,), (600, 620, 650), (840, 600), ()])
def test_close_levels_a_single_one_and_easier_ones_are_no_jump(means: Sequence[float]) -> None:
    assert level_steps.far_apart(attempts(*means), lower_is_better=True) == ""


def test_a_result_that_is_better_when_higher_gets_harder_downwards() -> None:
    assert "1 and 2" in level_steps.far_apart(attempts(840, 600), lower_is_better=False)


def test_a_goal_that_follows_the_level_makes_it_no_jump() -> None:
    easy, hard = attempts(600, goal=700), attempts(900, goal=1000)
    moved = [*easy, *(row | {"level": 2} for row in hard)]
    assert level_steps.far_apart(moved, lower_is_better=True) == ""


def test_an_attempt_without_a_result_is_left_out() -> None:
    rows = [*attempts(600, 840), {"level": 1, "metric": None, "goal": 1000.0}]
    assert "1 and 2" in level_steps.far_apart(rows, lower_is_better=True)


def test_each_level_is_visited_by_a_list(keyboard: type[Task]) -> None:
    seen: list[TaskParameters] = []

    def run(parameters: TaskParameters) -> list[dict[str, Any]]:
        seen.append(parameters)
        return []

    parameters = build(
        keyboard.Parameters,
        {"levels": ["fj", "fjd", "fjdk"], "attempts": 10, "practice_attempts": 2},
    )
    assert level_steps.warning(keyboard, parameters, run) == ""
    assert seen[0].level_sequence == (*[1] * 8, *[2] * 8, *[3] * 8)  # type: ignore[attr-defined]
    assert (seen[0].attempts, seen[0].practice_attempts) == (24, 0)
    many = build(
        keyboard.Parameters,
        {"levels": [f"f{chr(code)}" for code in range(200, 260)], "max_level": 60},
    )
    assert level_steps.warning(keyboard, many, run) == ""
    assert len(seen) == 1, "too many levels for a few attempts at each"
