"""The levels follow a list."""

import pytest

from sar_tui.rules import level_choice
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.difficulty import Difficulty, ScoredAttempt
from sar_tui.rules.parameters import TaskParameters, build


def listed(*levels: int, **settings: object) -> TaskParameters:
    return build(
        TaskParameters, {"difficulty_policy": "sequence", "level_sequence": levels, **settings}
    )


def test_each_attempt_has_the_level_of_its_place_and_the_last_one_stays() -> None:
    parameters = listed(2, 2, 5, 1)
    state = level_choice.start(parameters, 10)
    found = [(state.level, state.why)]
    for number in range(1, 6):
        state = level_choice.step(state, ScoredAttempt(number, "failure"), parameters, 10)
        found.append((state.level, state.why))
    assert found == [
        (2, ""), (2, ""), (5, "Number 3 of 4 in the list."), (1, "Number 4 of 4 in the list."),
        (1, ""), (1, ""),
    ]  # fmt: skip


def test_levels_outside_the_bounds_become_the_bounds() -> None:
    parameters = listed(1, 9, start_level=2, min_level=2, max_level=8)
    assert level_choice.start(parameters, 6).level == 2
    assert level_choice.step(Difficulty(2), ScoredAttempt(1, "success"), parameters, 6).level == 6


def test_after_a_level_set_by_hand_the_list_goes_on_at_its_place() -> None:
    parameters = listed(1, 2, 3, 4)
    assert level_choice.step(Difficulty(9), ScoredAttempt(2, "failure"), parameters, 10).level == 3


def test_an_empty_list_is_refused() -> None:
    with pytest.raises(ParameterError, match="Name the levels of the sequence"):
        listed()
