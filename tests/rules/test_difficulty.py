"""The level changes by one within its bounds after a number of successes or failures in a row, stays,
or follows a list.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.messages import Outcome
from sar_tui.rules import level_choice
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.difficulty import Difficulty, ScoredAttempt
from sar_tui.rules.parameters import TaskParameters, build

OUTCOMES = st.lists(st.sampled_from(["success", "failure"]), max_size=80)


@st.composite
def set_ups(draw: st.DrawFn) -> tuple[TaskParameters, int]:
    """Valid parameters, and a number of levels of the task, at least the lowest and the first
    level.
    """
    low, first, high = sorted(draw(st.tuples(*[st.integers(1, 15)] * 3)))
    parameters = build(
        TaskParameters,
        {
            "min_level": low,
            "start_level": first,
            "max_level": high,
            "consecutive_successes": draw(st.integers(1, 4)),
            "consecutive_failures": draw(st.integers(1, 4)),
        },
    )
    return parameters, draw(st.integers(first, 20))


def levels(parameters: TaskParameters, count: int, outcomes: list[Outcome]) -> list[int]:
    state = level_choice.start(parameters, count)
    found = [state.level]
    for number, outcome in enumerate(outcomes, 1):
        state = level_choice.step(state, ScoredAttempt(number, outcome), parameters, count)
        found.append(state.level)
    return found


@given(set_ups(), OUTCOMES)
def test_the_level_changes_exactly_after_the_required_number_in_a_row(
    set_up: tuple[TaskParameters, int], outcomes: list[Outcome]
) -> None:
    parameters, count = set_up
    level, run, kind = parameters.start_level, 0, ""
    expected = [level]
    for outcome in outcomes:
        run = run + 1 if outcome == kind else 1
        kind = outcome
        needed = (
            parameters.consecutive_successes
            if outcome == "success"
            else parameters.consecutive_failures
        )
        if run == needed:
            run = 0
            if outcome == "success":
                level = min(level + 1, parameters.max_level, count)
            else:
                level = max(level - 1, parameters.min_level)
        expected.append(level)
    assert levels(parameters, count, outcomes) == expected


@given(st.integers(1, 10), OUTCOMES)
def test_a_fixed_level_stays(start: int, outcomes: list[Outcome]) -> None:
    parameters = build(TaskParameters, {"start_level": start, "difficulty_policy": "fixed"})
    assert set(levels(parameters, 10, outcomes)) == {start}


def test_each_change_of_level_has_a_reason_and_no_other_attempt_has_one() -> None:
    parameters = build(TaskParameters, {"consecutive_failures": 2, "start_level": 2})
    state, why = level_choice.start(parameters, 3), []
    outcomes: list[Outcome] = ["success", "success", "failure", "failure"]
    for number, outcome in enumerate(outcomes, 1):
        state = level_choice.step(state, ScoredAttempt(number, outcome), parameters, 3)
        why.append(state.why)
    assert why == ["Goal reached.", "", "", "Goal missed 2 times in a row."]


def test_an_initial_level_beyond_the_last_starts_and_stays_at_the_last() -> None:
    parameters = build(TaskParameters, {"start_level": 5, "min_level": 4})
    assert level_choice.start(parameters, 3) == Difficulty(3)
    assert levels(parameters, 3, ["success", "failure", "failure"]) == [3, 3, 3, 3]


# --- sequence


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
