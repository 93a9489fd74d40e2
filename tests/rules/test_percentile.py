"""The goal is the k-th best of the last m results, and the level stays."""

from collections.abc import Sequence
from itertools import permutations
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules import level_choice
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.difficulty import PercentileSettings, ScoredAttempt, rank_among
from sar_tui.rules.difficulty import percentile_goal as goal
from sar_tui.rules.parameters import TaskParameters, build

DEFAULT = PercentileSettings()
RESULTS = st.lists(st.none() | st.floats(100, 5000), max_size=40)


def value(
    results: Sequence[float | None],
    settings: PercentileSettings = DEFAULT,
    better: Literal["lower", "higher"] = "lower",
) -> float | None:
    made = goal(results, better, settings)
    return made.value if made else None


@pytest.mark.parametrize(("rank", "results"), [(1, 1), (2, 3), (3, 4), (4, 4)])
def test_of_exchangeable_results_exactly_k_of_m_plus_1_reach_the_goal(
    rank: int, results: int
) -> None:
    settings = PercentileSettings(percentile_rank=rank, percentile_results=results)
    orders = list(permutations(range(results + 1)))
    reached = sum(order[-1] < value(order[:-1], settings) for order in orders)  # type: ignore[operator]
    assert reached * (results + 1) == rank * len(orders)


def test_by_default_the_share_is_as_near_to_seven_of_ten_as_a_rank_can_be() -> None:
    for count in range(1, 30):
        off = [abs(rank / (count + 1) - 0.7) for rank in range(1, count + 1)]
        assert off[rank_among(count, DEFAULT) - 1] == pytest.approx(min(off))
    assert rank_among(29, DEFAULT) == 21


@given(RESULTS, st.integers(1, 20), st.integers(0, 19))
def test_the_goal_is_one_of_the_last_results_and_follows_their_direction(
    results: list[float | None], rank: int, more: int
) -> None:
    settings = PercentileSettings(percentile_rank=rank, percentile_results=rank + more)
    last = results[-settings.percentile_results :]
    found = value(results, settings)
    assert found is None if set(last) <= {None} else found in last
    mirrored = value([None if one is None else -one for one in results], settings, "higher")
    assert mirrored == (None if found is None else -found)


def test_an_attempt_without_a_result_ranks_last() -> None:
    settings = PercentileSettings(percentile_rank=2, percentile_results=3)
    assert value([None, 500.0, 400.0], settings) == 500.0
    assert value([None, None, 400.0], settings) == 400.0, (
        "a goal must be a result, so it is easier than it should be"
    )
    assert value([None, None, None], settings) is None


def test_the_reason_names_the_rank_and_the_results() -> None:
    assert [goal([500.0] * count, "lower", DEFAULT).why for count in (1, 9, 50)] == [  # type: ignore[union-attr]
        "The goal is the last result at this level.",
        "The goal is number 7 of the last 9 results at this level.",
        "The goal is number 21 of the last 29 results at this level.",
    ]


def test_the_level_stays() -> None:
    parameters = build(TaskParameters, {"difficulty_policy": "percentile", "start_level": 4})
    state = level_choice.start(parameters, 10)
    assert (
        level_choice.step(state, ScoredAttempt(1, "success", 500.0, 20, 20), parameters, 10)
        == state
    )


def test_a_rank_beyond_the_number_of_results_is_refused() -> None:
    with pytest.raises(ParameterError, match="The goal cannot be number 9 of 8 results"):
        build(TaskParameters, {"percentile_rank": 9, "percentile_results": 8})
