"""In the long run a policy succeeds in the share of attempts that the literature gives for it."""

import numpy as np
import pytest

from sar_tui.rules.difficulty import (
    FIRST_STEP,
    INCLUDED,
    Bounds,
    Difficulty,
    DifficultyPolicy,
    OneUpOneDownSettings,
    Place,
    ScoredAttempt,
    TargetSettings,
)

ONE_UP_ONE_DOWN, TARGET = INCLUDED["one-up-one-down"], INCLUDED["target"]

BOUNDS = Bounds(1, 8)
SUCCESS = (0.99, 0.95, 0.9, 0.75, 0.55, 0.3, 0.1, 0.02)
"""Probability of a success at each level."""


def chain(
    policy: DifficultyPolicy, settings: object, start: Difficulty
) -> tuple[list[Difficulty], np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    """Return the states that can be reached, and the matrix of the probabilities from each (row) to
    each.
    """
    found = [start]
    moves: list[tuple[int, int, float]] = []
    for here, state in enumerate(found):
        success = SUCCESS[state.level - 1]
        for outcome, probability in (("success", success), ("failure", 1 - success)):
            after = settled(policy.step(state, ScoredAttempt(1, outcome), settings, BOUNDS))  # type: ignore[arg-type]
            if after not in found:
                found.append(after)
            moves.append((here, found.index(after), probability))
    matrix = np.zeros((len(found), len(found)))
    for here, there, probability in moves:
        matrix[here, there] += probability
    return found, matrix


def settled(state: Difficulty) -> Difficulty:
    """Return the state without its words, and with steps that have shrunk to the floor."""
    place = state.memory
    if isinstance(place, Place):
        return Difficulty(state.level, Place(round(place.place, 9), 1, 100))
    return Difficulty(state.level, place)


def stationary(policy: DifficultyPolicy, settings: object, start: Difficulty) -> list[float]:
    """Return the share of each level in the long run: the eigenvector of the matrix."""
    states, matrix = chain(policy, settings, start)
    equations = np.vstack([matrix.T - np.eye(len(states)), np.ones(len(states))])
    shares = np.linalg.lstsq(equations, np.array([0.0] * len(states) + [1.0]), rcond=None)[0]
    found = [0.0] * len(SUCCESS)
    for state, share in zip(states, shares.tolist(), strict=True):
        found[state.level - 1] += share
    return found


def success(shares: list[float]) -> float:
    return sum(share * each for share, each in zip(shares, SUCCESS, strict=True))


ONE_EACH = OneUpOneDownSettings()
TWO_UP = OneUpOneDownSettings(consecutive_successes=2)
SEVENTY = TargetSettings(target_of="attempts")
START = Difficulty(3, Place(3.0, 1, 100))


def test_one_up_one_down_is_in_detailed_balance_and_succeeds_in_half_of_the_attempts() -> None:
    shares = stationary(ONE_UP_ONE_DOWN, ONE_EACH, Difficulty(3))
    for level in range(7):
        up, down = shares[level] * SUCCESS[level], shares[level + 1] * (1 - SUCCESS[level + 1])
        assert up == pytest.approx(down)
    assert success(shares) == pytest.approx(0.5, abs=0.01)


def test_two_up_one_down_and_a_target_of_seventy_succeed_in_seven_of_ten_attempts() -> None:
    two_up = stationary(ONE_UP_ONE_DOWN, TWO_UP, Difficulty(3))
    assert success(two_up) == pytest.approx(0.707, abs=0.03)
    assert success(stationary(TARGET, SEVENTY, START)) == pytest.approx(0.7, abs=0.005)


def test_a_target_of_half_with_steps_of_one_level_is_one_up_one_down() -> None:
    half = TargetSettings(target_of="attempts", target_share=50, target_step=2)
    assert FIRST_STEP / 101 < 2, "the step has shrunk to its floor"
    expected = stationary(ONE_UP_ONE_DOWN, ONE_EACH, Difficulty(3))
    assert stationary(TARGET, half, START) == pytest.approx(expected)
