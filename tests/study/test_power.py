"""Simulated power agrees with theory, and is the same wherever it is computed."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules.student import t95
from sar_tui.study import power
from sar_tui.study.outcome import Model
from tests.study import exact


def paired(dz: float) -> Model:
    return Model("within", dz * math.sqrt(2) * 22.8, 39, 22.8)


def two_groups(d: float) -> Model:
    return Model("groups", d, 0.8, 0.6)


def with_baseline(d: float, r: float) -> Model:
    return Model("groups, baseline", d, math.sqrt(r), math.sqrt(1 - r))


GOLDEN = [
    (paired(0.5), 34, 0.80778),
    (two_groups(0.5), 128, 0.80146),
    (with_baseline(0.5, 0.7), 40, 0.567),
]
CASES = [
    *[(paired(0.5), size, exact.within(0.5, size)) for size in (10, 34, 60)],
    *[(two_groups(0.5), size, exact.groups(0.5, size)) for size in (20, 128, 200)],
    *[
        (with_baseline(0.5, 0.7), size, exact.groups_with_baseline(0.5, 0.7, size))
        for size in (12, 40, 100)
    ],
]
"""Model, size, and exact power."""


@pytest.mark.parametrize(("model", "size", "known"), GOLDEN)
def test_exact_power_is_that_of_other_programs(model: Model, size: int, known: float) -> None:
    (found,) = [power for case, people, power in CASES if (case, people) == (model, size)]
    assert found == pytest.approx(known, abs=0.0005)


@pytest.mark.parametrize(("model", "size", "known"), CASES)
def test_a_quick_simulation_is_near_theory(model: Model, size: int, known: float) -> None:
    assert power.estimate(model, size).power == pytest.approx(known, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "size", "known"), CASES)
def test_many_draws_agree_with_theory_within_a_point(model: Model, size: int, known: float) -> None:
    found = power.estimate(model, size, draws=100_000)
    assert found.power == pytest.approx(known, abs=0.01)
    assert found.low - 0.005 < known < found.high + 0.005


@pytest.mark.parametrize("model", [paired(0.0), two_groups(0.0), with_baseline(0.0, 0.7)])
@pytest.mark.parametrize("dropout", [0.0, 0.25])
def test_without_an_effect_one_study_in_twenty_finds_one(model: Model, dropout: float) -> None:
    found = power.estimate(model._replace(dropout=dropout), 30)
    assert found.power == pytest.approx(0.05, abs=0.008)


@pytest.mark.parametrize(("model", "size", "known"), CASES[2::3])
def test_losing_people_is_like_studying_fewer(model: Model, size: int, known: float) -> None:
    enrolled = round(size / 0.8)
    lossy = power.estimate(model._replace(dropout=0.2), enrolled)
    assert lossy.power == pytest.approx(known, abs=0.02)
    assert lossy.power < power.estimate(model, enrolled).power


def test_a_study_that_everybody_may_leave_is_still_computed() -> None:
    for model in (paired(0.5), two_groups(0.5), with_baseline(0.5, 0.7)):
        found = power.estimate(model._replace(dropout=0.9), 4)
        assert 0 <= found.found < found.draws // 10


def test_the_regression_is_that_of_least_squares() -> None:
    model, size, draws = with_baseline(0.6, 0.6), 23, 40
    t, df = power._groups_with_baseline(model, size, draws, np.random.default_rng(3))
    generator = np.random.default_rng(3)
    half = size // 2
    shapes = ((draws, size - half), (draws, half))
    drawn = []
    for shape, effect in zip(shapes, (0.0, model.effect), strict=True):
        person = model.person_sd * generator.standard_normal(shape)
        x, y = person + model.within_sd * generator.standard_normal((2, *shape))
        drawn.append((x, y + effect))
    group = np.r_[np.zeros(size - half), np.ones(half)]
    for study in range(draws):
        x = np.r_[drawn[0][0][study], drawn[1][0][study]]
        y = np.r_[drawn[0][1][study], drawn[1][1][study]]
        design = np.column_stack([np.ones(size), x, group])
        coefficients, residual, _, _ = np.linalg.lstsq(design, y)
        variance = residual[0] / (size - 3) * np.linalg.inv(design.T @ design)[2, 2]
        assert t[study] == pytest.approx(coefficients[2] / math.sqrt(variance))
        assert df[study] == size - 3


def test_the_interval_is_wilsons() -> None:
    low, high = power.wilson(8000, 10_000)
    assert (round(low, 3), round(high, 3)) == (0.792, 0.808)
    assert power.wilson(0, 100)[0] == 0
    assert power.wilson(100, 100)[1] == 1


@given(st.integers(1, 10**6), st.floats(0, 1))
def test_the_interval_is_around_the_share(of: int, share: float) -> None:
    found = round(share * of)
    low, high = power.wilson(found, of)
    assert 0 <= low <= found / of <= high <= 1


# --- sizes


@pytest.mark.parametrize(
    ("model", "smallest"),
    [(paired(0.5), 34), (two_groups(0.5), 128), (with_baseline(0.5, 0.7), 68)],
)
def test_the_smallest_size_is_found(model: Model, smallest: int) -> None:
    curve = power.power_curve(model)
    assert curve.smallest is not None
    assert curve.smallest.size == pytest.approx(smallest, abs=2)
    assert curve.smallest in curve.estimates
    sizes = [each.size for each in curve.estimates]
    assert sizes == sorted(set(sizes))
    powers = [each.power for each in curve.estimates]
    assert powers == sorted(powers)


def test_sizes_that_are_asked_for_are_simulated() -> None:
    curve = power.power_curve(paired(0.5), [50, 20], draws=2000)
    assert {20, 50} <= {each.size for each in curve.estimates}


def test_an_effect_that_is_too_small_is_found_by_no_size() -> None:
    curve = power.power_curve(two_groups(0.01), draws=200)
    assert curve.smallest is None
    assert curve.estimates[-1].size == power.LARGEST


def test_a_large_effect_needs_the_fewest_people_who_can_be_tested() -> None:
    assert power.power_curve(paired(1000.0), draws=200).smallest == power.estimate(
        paired(1000.0), 2, draws=200
    )


# --- the same anywhere


def backwards(chunks: Sequence[power.Chunk]) -> Iterable[int]:
    return [power.found_in(chunk) for chunk in reversed(chunks)]


def test_the_order_of_chunks_changes_nothing_and_the_seed_does() -> None:
    model = with_baseline(0.5, 0.7)._replace(dropout=0.2)
    found = power.estimate(model, 40, draws=4500)
    assert power.estimate(model, 40, draws=4500, compute=backwards) == found
    assert power.estimate(model, 40, draws=4500, seed=2) != found


def test_more_draws_begin_with_the_same_studies() -> None:
    seen: list[list[int]] = []

    def noted(chunks: Sequence[power.Chunk]) -> list[int]:
        seen.append([power.found_in(chunk) for chunk in chunks])
        return seen[-1]

    for draws in (2000, 5000):
        power.estimate(paired(0.5), 20, draws=draws, compute=noted)
    assert seen[1][:2] == seen[0]


def test_two_processes_find_what_one_does() -> None:
    model = with_baseline(0.5, 0.7)._replace(dropout=0.2)
    with power.on_cores(2) as two, power.on_cores(1) as one:
        assert power.estimate(model, 40, compute=two) == power.estimate(model, 40, compute=one)


@pytest.mark.slow
def test_three_sizes_of_a_hundred_thousand_studies_take_less_than_a_minute() -> None:
    import time

    began = time.monotonic()
    with power.on_cores(2) as compute:
        for size in (100, 200, 400):
            power.estimate(with_baseline(0.3, 0.5), size, draws=100_000, compute=compute)
    assert time.monotonic() - began < 60


def test_critical_values_are_those_of_the_degrees_of_freedom() -> None:
    values = power._critical(np.array([3, 0, 10, 3]))
    assert list(values) == [t95(3), math.inf, t95(10), t95(3)]
