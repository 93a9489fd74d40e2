"""An attempt is seldom called better by chance, whatever the noise, and mostly after a true change."""

import random
from collections.abc import Sequence
from statistics import fmean

import pytest

from sar_tui.progress.change import mdc95
from sar_tui.rules.real_change import LEAST_TRIALS, Sample, judge, spread_of
from tests.claims.noise_worlds import WORLDS, Attempts, sem
from tests.examples import first

PAIRS = 600
EARLIER = (3, 5)
"""Numbers of earlier attempts."""
MDCS = 2.0
"""The true change that must be found, in MDC95."""


@pytest.mark.parametrize("world", first(1, WORLDS))
@pytest.mark.parametrize("earlier", EARLIER)
@pytest.mark.parametrize("trials", [1, 5])
def test_one_measure_is_seldom_praised_by_chance_and_mostly_after_two_mdc(
    world: str, earlier: int, trials: int
) -> None:
    by_chance, if_changed = shares_praised(world, earlier, trials, measures=1)
    if earlier * trials < LEAST_TRIALS:
        assert (by_chance, if_changed) == (0.0, 0.0)
    else:
        assert by_chance <= 0.1
        assert if_changed >= 0.8


@pytest.mark.parametrize("world", first(1, WORLDS))
@pytest.mark.parametrize("earlier", EARLIER)
def test_any_of_three_measures_is_seldom_praised_by_chance(world: str, earlier: int) -> None:
    by_chance, _ = shares_praised(world, earlier, trials=4, measures=3)
    assert by_chance <= 0.1


def shares_praised(world: str, earlier: int, trials: int, measures: int) -> tuple[float, float]:
    """Return the share of last attempts of which a measure is called better: with nothing changed,
    and after a true change of the first measure.
    """
    rng = random.Random(f"{world} {trials} {earlier} {measures}")
    change = MDCS * mdc95(sem(world, trials))
    drawn = [
        [samples_of(WORLDS[world](rng, earlier + 1, trials)) for _ in range(measures)]
        for _ in range(PAIRS)
    ]
    return (
        fmean(is_praised(each, 0.0) for each in drawn),
        fmean(is_praised(each, change) for each in drawn),
    )


def samples_of(attempts: Attempts) -> list[Sample]:
    return [Sample(fmean(trials), len(trials), spread_of(trials)) for trials in attempts]


def is_praised(measures: Sequence[Sequence[Sample]], change: float) -> bool:
    shifts = [change, *[0.0] * (len(measures) - 1)]
    for (*earlier, now), shift in zip(measures, shifts, strict=True):
        shifted = Sample(now.mean + shift, now.n, now.sd)
        found = judge(shifted, earlier[-1], earlier, "higher", measures=len(measures))
        if found and found.verdict == "better":
            return True
    return False
