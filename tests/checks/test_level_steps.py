"""Neighbouring levels that are far apart are named, and nothing is refused for it."""

from typing import Any

import pytest

from sar_tui.checks.task_sessions import far_apart, level_steps_warning
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


FOLLOWED = [*attempts(600, goal=700), *(row | {"level": 2} for row in attempts(900, goal=1000))]


@pytest.mark.parametrize(
    ("rows", "lower_is_better", "found"),
    [
        (attempts(600, 630, 840, 860), True, "2 and 3 (5.1)."),
        (attempts(840, 600), False, "1 and 2"),
        ([*attempts(600, 840), {"level": 1, "metric": None, "goal": 1000.0}], True, "1 and 2"),
        (attempts(600), True, ""),
        (attempts(600, 620, 650), True, ""),
        (attempts(840, 600), True, ""),
        (attempts(), True, ""),
        (FOLLOWED, True, ""),
    ],
    ids=["distance", "higher", "no result", "single", "close", "easier", "none", "goal follows"],
)
def test_a_jump_is_named_with_its_distance(
    rows: list[dict[str, Any]], lower_is_better: bool, found: str
) -> None:
    said = far_apart(rows, lower_is_better=lower_is_better)
    assert (found in said, bool(said)) == (True, bool(found))


def test_each_level_is_visited_by_a_list(keyboard: type[Task]) -> None:
    seen: list[TaskParameters] = []

    def run(parameters: TaskParameters) -> list[dict[str, Any]]:
        seen.append(parameters)
        return []

    def warned(**settings: object) -> str:
        return level_steps_warning(keyboard, build(keyboard.Parameters, settings), run)

    assert warned(levels=["fj", "fjd", "fjdk"], attempts=10, practice_attempts=2) == ""
    assert seen[0].level_sequence == (*[1] * 8, *[2] * 8, *[3] * 8)  # type: ignore[attr-defined]
    assert (seen[0].attempts, seen[0].practice_attempts) == (24, 0)
    assert warned(levels=[f"f{chr(code)}" for code in range(200, 260)], max_level=60) == ""
    assert len(seen) == 1, "too many levels for a few attempts at each"
