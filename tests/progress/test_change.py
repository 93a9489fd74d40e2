"""Noise, change, and the gain of a retest."""

import math
import statistics
from typing import Any

import pytest

from sar_tui.progress.change import baseline, difference, mdc95, verdict

FIRST = (146, 148, 170, 90, 157, 156, 176, 205)
SECOND = (140, 152, 152, 99, 145, 153, 167, 218)
"""Two tests of eight people: the worked example of Weir (2005), whose SEM is 7.6 and minimal
difference 21.
"""


def test_the_mdc95_is_that_of_the_published_example() -> None:
    sem = statistics.stdev(a - b for a, b in zip(FIRST, SECOND, strict=True)) / math.sqrt(2)
    assert sem == pytest.approx(7.6, abs=0.05)
    assert mdc95(sem) == pytest.approx(21, abs=0.1)


def test_an_sem_from_three_sessions_needs_a_larger_difference(stats: Any) -> None:
    assert mdc95(1.0, 3) == pytest.approx(stats.t.ppf(0.975, 2) * math.sqrt(2))
    assert mdc95(1.0, 1000) == pytest.approx(mdc95(1.0), rel=0.01)


def test_before_three_sessions_of_baseline_nothing_is_known_and_the_first_is_practice() -> None:
    for sessions in range(4):
        found = baseline([3.0, 3.1, 2.9, 3.2][:sessions])
        assert found is None
        assert verdict(9.0, found) == difference(9.0, 3.0, found) == "not yet known"
    found = baseline([2.0, 3.1, 2.9, 3.0, 9.0])
    assert found is not None
    assert found.mean == pytest.approx(3.0)
    assert found.practice == pytest.approx(1.0)
    assert found.sem == pytest.approx(0.1)
    assert found.rise == 0.0


def test_a_change_is_what_exceeds_the_mdc() -> None:
    found = baseline([2.0, 3.1, 2.9, 3.0])
    assert found is not None
    assert verdict(found.mean + found.mdc95 * 0.99, found) == "noise"
    assert verdict(found.mean + found.mdc95 * 1.01, found) == "more"
    assert verdict(found.mean - found.mdc95 * 1.01, found) == "less"
    assert difference(4.0, 3.5, found) == "noise"
    assert difference(4.0, 3.0, found) == "more"
    assert difference(3.0, 4.0, found) == "less"


def test_a_baseline_that_still_rises_asks_more_of_a_gain_but_not_of_a_loss() -> None:
    found = baseline([2.0, 2.9, 3.0, 3.1])
    assert found is not None
    assert verdict(found.mean + found.mdc95 + 0.19, found) == "noise"
    assert verdict(found.mean + found.mdc95 + 0.21, found) == "more"
    assert verdict(found.mean - found.mdc95 - 0.01, found) == "less"


def test_sessions_that_are_all_alike_have_not_changed() -> None:
    """The mean of equal numbers may differ from them by a rounding error."""
    for value in (3.6822406560608103, 0.1, 12.0, -950.3):
        found = baseline([value] * 4)
        assert verdict(value, found) == verdict(value * (1 - 1e-15), found) == "noise"
        assert difference(value, value * (1 + 1e-15), found) == "noise"
