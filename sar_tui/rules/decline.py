"""Decline that is real: two attempts in a row that are worse than this person's own noise allows.
Pure.

A correction tells a person to move in another way, so it must not be drawn by chance. The mean of
the last two attempts is compared with the *baseline*, the attempts before them, by Student's t for
a new mean against earlier values: the standard error is s · √(1/2 + 1/k), where s is the SD between
the means of the k attempts of the baseline. That SD holds whatever makes attempts differ. It is
widened by √(1 + 2r) where neighbours are alike (r, their autocorrelation, if positive): the
attempts of a person who drifts differ by more than neighbours show (Bayley & Hammersley 1946, Suppl
J R Stat Soc 8:184-197). Of several measures that are judged together each gets its share of the
chance (Bonferroni).

Both attempts must also be worse by themselves: single spoilt attempts, which come with heavy tails,
then seldom earn a correction. So a decline is found in its second attempt at the earliest, and a
slow one, which takes the baseline along, hardly at all.

``tests/claims/test_corrections.py`` counts how often one is found by chance, and how soon a true
decline is found.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from statistics import fmean
from typing import Literal

import msgspec

from sar_tui.rules.real_change import spread_of
from sar_tui.rules.student import quantile, t95

RECENT = 2
"""Attempts that must be worse."""
LEAST_BASELINE = 8
"""Fewest attempts before those two: an SD of fewer says too little of a person's noise."""
LONGEST_BASELINE = 20
"""Most attempts before those two."""
BY_CHANCE = 0.05
"""Largest share of attempts in which a decline of any of the measures is found by chance, under
normal noise.
"""
EACH = 1.0
"""Each of the two attempts is worse than the baseline's mean by more than this, in its SD."""
_ROUNDING = 1e-9
"""Share of a mean below which a difference is an error of rounding."""


class Decline(msgspec.Struct, frozen=True):
    """A measure that got worse.

    Args:
        usual: mean of the baseline.
        by: mean of the last two attempts minus ``usual``.
        mdc95: the difference that chance alone exceeds in 5 % of such comparisons, either way.
    """

    usual: float
    by: float
    mdc95: float

    @property
    def size(self) -> float:
        """The difference in MDC95, by which declines of several measures are compared."""
        return abs(self.by) / self.mdc95 if self.mdc95 else math.inf


def decline(
    values: Sequence[float],
    better: Literal["lower", "higher"],
    *,
    least: float = 0.0,
    measures: int = 1,
) -> Decline | None:
    """Return the decline of a measure in the last two attempts; None if there is none, or no
    baseline yet.

    Args:
        values: its mean in each comparable attempt of one person, oldest first; the last is the
            present one.
        better: the direction of improvement.
        least: smallest difference that is worth a word, whatever the noise.
        measures: number of measures that are judged together.
    """
    baseline, recent = values[:-RECENT][-LONGEST_BASELINE:], values[-RECENT:]
    if len(baseline) < LEAST_BASELINE:
        return None
    usual, spread = (
        fmean(baseline),
        spread_of(baseline) * math.sqrt(1 + 2 * max(0.0, _autocorrelation(baseline))),
    )
    worse = [value - usual if better == "lower" else usual - value for value in recent]
    by = fmean(worse)
    error = spread * math.sqrt(1 / RECENT + 1 / len(baseline))
    freedom = len(baseline) - 1
    needed = quantile(freedom, 1 - 2 * BY_CHANCE / measures) * error  # one-sided
    rounding = _ROUNDING * abs(usual)
    if by <= needed + rounding or by < least - rounding or min(worse) <= EACH * spread + rounding:
        return None
    return Decline(usual, by if better == "lower" else -by, t95(freedom) * error)


def _autocorrelation(values: Sequence[float]) -> float:
    """Return the correlation of neighbours, 0 for values that are all the same."""
    mean = fmean(values)
    deviations = [value - mean for value in values]
    squares = sum(each * each for each in deviations)
    return (
        sum(one * next_one for one, next_one in pairwise(deviations)) / squares if squares else 0.0
    )
