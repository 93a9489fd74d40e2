"""The level at goal: found on a known line, judged by scipy, and never claimed without grounds."""

import math
import random
from typing import Any

import pytest

from sar_tui.progress.level_estimate import (
    Attempt,
    Estimate,
    Slope,
    brackets_goal,
    is_well_known,
    level_at_goal,
    near_goal,
    shared_slope,
    slope_of,
)


def session(
    seed: int, *, slope: float = 170.0, at_goal: float = 3.4, sd: float = 40.0, n: int = 20
) -> list[Attempt]:
    """Return attempts that hover about the goal, one level up or down at a time."""
    rng, bits, made = random.Random(seed), 1, []
    for _ in range(n):
        distance = slope * (bits - at_goal) + rng.gauss(0, sd)
        made.append(Attempt(float(bits), 20.0, distance))
        bits = max(0, bits + (1 if distance < 0 else -1))
    return made


def found(attempts: list[Attempt], borrowed: Slope | None = None) -> Estimate:
    estimate = level_at_goal(attempts, borrowed)
    assert estimate is not None
    return estimate


def test_without_noise_the_level_at_goal_is_exact() -> None:
    estimate = found(session(0, sd=0.0))
    assert estimate.value == pytest.approx(3.4)
    assert (estimate.low, estimate.high) == (pytest.approx(3.4), pytest.approx(3.4))


@pytest.mark.parametrize("seed", range(5))
def test_the_slope_its_error_and_the_band_are_those_of_scipy(seed: int, stats: Any) -> None:
    attempts = session(seed)
    distances, levels = [each.distance for each in attempts], [each.difficulty for each in attempts]
    judge = stats.linregress(levels, distances)
    slope = slope_of(attempts)
    assert slope is not None
    assert slope.value == pytest.approx(judge.slope)
    assert math.sqrt(slope.variance) == pytest.approx(judge.stderr)
    robust = stats.theilslopes(distances, levels, method="joint")
    estimate = found(attempts)
    assert estimate.low < -robust.intercept / robust.slope < estimate.high


def test_the_band_is_fiellers_set(stats: Any) -> None:
    """Its ends are where the line's own 95 % error reaches the goal."""
    attempts = session(2, n=5)[:5] + session(3)[5:]
    estimate, near, slope = found(attempts), near_goal(attempts), slope_of(attempts)
    assert slope is not None
    n = len(near)
    mean = sum(each.difficulty for each in near) / n
    height = sum(each.distance for each in near) / n
    rests = (each.distance - height - slope.value * (each.difficulty - mean) for each in near)
    variance = sum(rest**2 for rest in rests) / (n - 2) / n
    t = stats.t.ppf(0.975, n - 2)
    for end in (estimate.low, estimate.high):
        line = height + slope.value * (end - mean)
        error = t * math.sqrt(variance + slope.variance * (end - mean) ** 2)
        assert abs(line) == pytest.approx(error)


def test_results_on_one_side_of_the_goal_yield_no_estimate() -> None:
    easy = [Attempt(float(bits), 20.0, -100.0 + bits) for bits in range(10)]
    assert not brackets_goal(easy)
    assert level_at_goal(easy) is None
    assert level_at_goal([]) is None


def test_a_session_at_one_level_borrows_the_slope_of_the_others() -> None:
    rng = random.Random(4)
    fixed = [Attempt(3.0, 20.0, 170 * (3.0 - 3.1) + rng.gauss(0, 40)) for _ in range(20)]
    assert slope_of(fixed) is None
    assert level_at_goal(fixed) is None
    others = [slope for seed in range(4) if (slope := slope_of(session(seed)))]
    estimate = found(fixed, shared_slope(others))
    assert estimate.borrowed
    assert estimate.low < 3.1 < estimate.high


def test_a_line_that_falls_with_difficulty_yields_no_estimate() -> None:
    falling = [Attempt(-each.difficulty, each.weight, each.distance) for each in session(1)]
    slope = slope_of(falling)
    assert slope is not None
    assert not is_well_known(slope)
    assert level_at_goal(falling) is None


def test_a_slope_that_is_not_well_known_is_used_only_if_there_is_no_other() -> None:
    noisy = session(2, sd=170.0)
    slope = slope_of(noisy)
    assert slope is not None
    assert not is_well_known(slope)
    alone, helped = found(noisy), found(noisy, Slope(170.0, 100.0))
    assert (alone.borrowed, helped.borrowed) == (False, True)
    assert helped.high - helped.low < alone.high - alone.low


def test_slopes_that_differ_between_sessions_are_less_sure() -> None:
    same = shared_slope([Slope(170.0, 25.0, 18)] * 4)
    spread = shared_slope([Slope(value, 25.0, 18) for value in (110.0, 150.0, 190.0, 230.0)])
    assert same is not None
    assert spread is not None
    assert (same.value, spread.value) == (pytest.approx(170.0), pytest.approx(170.0))
    assert same.variance < spread.variance
    assert shared_slope([]) is None


def test_the_run_in_ends_with_the_first_result_across_the_goal() -> None:
    distances = (-300.0, -200.0, -100.0, 40.0, -20.0, 30.0, -10.0, 20.0)
    attempts = [Attempt(1.0, 1.0, distance) for distance in distances]
    assert [each.distance for each in near_goal(attempts)] == [-20.0, 30.0, -10.0, 20.0]
    assert near_goal(attempts[:6]) == attempts[:6]
