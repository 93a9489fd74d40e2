"""The trend of a series, judged by scipy."""

import random

import pytest

from sar_tui.reports.wizard_study import FEWEST, trend


@pytest.mark.parametrize("seed", range(4))
def test_the_slope_and_its_interval_are_those_of_scipy(seed: int) -> None:
    stats = pytest.importorskip("scipy.stats")
    chance = random.Random(seed)
    values = [chance.choice((0.5, 3.0)) * step + chance.gauss(0, 4) for step in range(6 + 3 * seed)]
    values[2] = values[1]  # a tie
    found, theirs = trend(values), stats.theilslopes(values, alpha=0.95)
    assert found is not None
    assert (found.slope, found.low, found.high) == pytest.approx(
        (theirs.slope, theirs.low_slope, theirs.high_slope)
    )


def test_few_values_have_no_trend_and_equal_ones_a_flat_one() -> None:
    assert trend([1.0] * (FEWEST - 1)) is None
    flat = trend([7.0] * FEWEST)
    assert flat is not None
    assert (flat.slope, flat.low, flat.high) == (0, 0, 0)
