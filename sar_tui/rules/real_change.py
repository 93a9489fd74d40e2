"""Change that is real: more than the noise of this person's own last attempts.

A difference between two means is compared with its minimal detectable change, MDC95 = 1.96 · √2 ·
SEM (Weir 2005). The standard error of measurement (SEM) of an attempt's mean is found in two ways,
of which the larger counts:

- the SD between the means of the earlier attempts. It holds whatever makes attempts differ, but a
  few attempts that happen to be alike would make it far too small;
- the SD of single trials within attempts, divided by the root of their number. It comes from many
  more trials, but holds only if nothing except chance makes attempts differ: people drift, tire,
  and have better moments.

Outliers are kept: the attempt that is compared with may be one, and must then widen the margin
instead of earning praise for the next. As all comes from few trials of one person, 1.96 gives way
to Student's t.

``tests/claims/test_praise.py`` counts how often "better" is said by chance, and how often a true
change is found.
"""

import math
from collections.abc import Sequence
from statistics import fmean
from typing import Literal

import msgspec

from sar_tui.rules.student import quantile

LEAST_ATTEMPTS = 3
"""Fewest earlier attempts: with two, a third that differs from both says nothing."""
LEAST_TRIALS = 5
"""Fewest trials in the earlier attempts."""
LATEST = 10
"""Most earlier attempts: what was done long ago says little of today's noise."""
TWO_SIDED = 0.05
"""Largest share of differences by chance, either way, that exceed the MDC95 of one measure."""
BETTER_BY_CHANCE = 0.04
"""Largest share of attempts in which one of several measures is called better by chance, under
normal noise.
"""
_ROUNDING = 1e-9
"""Share of a mean below which a difference is an error of rounding."""


class Sample(msgspec.Struct, frozen=True):
    """A mean of trials.

    Args:
        mean: in the measure's unit.
        n: number of trials.
        sd: SD between them, by n - 1; 0 for one.
        attempts: in which they were made.
    """

    mean: float
    n: int = 1
    sd: float = 0.0
    attempts: int = 1


class Change(msgspec.Struct, frozen=True):
    """A difference that was judged: ``by``, later minus earlier, and its MDC95, both in the
    measure's unit.
    """

    by: float
    mdc95: float
    verdict: Literal["better", "worse", "chance"]


def judge(
    now: Sample,
    before: Sample,
    earlier: Sequence[Sample],
    better: Literal["lower", "higher"],
    *,
    least: float = 0.0,
    measures: int = 1,
) -> Change | None:
    """Judge a difference against a person's own noise.

    Args:
        now: the present attempt.
        before: what it is compared with: one of the earlier attempts, or a mean of several.
        earlier: comparable attempts, oldest first; the noise is that of the last of them.
        better: the direction of improvement.
        least: smallest difference that is worth a word, whatever the noise.
        measures: that are judged together. With more than one, the difference must be the larger,
            so that the chance of any praise stays as small.

    Returns:
        None if the earlier attempts, or their trials, are too few.
    """
    latest = earlier[-LATEST:]
    trials = sum(each.n for each in latest)
    if len(latest) < LEAST_ATTEMPTS or trials < LEAST_TRIALS:
        return None
    by, error = now.mean - before.mean, _standard_error(now, before, latest)
    mdc95 = quantile(trials - 1, 1 - TWO_SIDED) * error
    needed = quantile(trials - 1, 1 - min(TWO_SIDED, 2 * BETTER_BY_CHANCE / measures)) * error
    rounding = _ROUNDING * max(abs(now.mean), abs(before.mean))
    if abs(by) <= needed + rounding or abs(by) < least - rounding:
        return Change(by, mdc95, "chance")
    return Change(by, mdc95, "better" if (by < 0) == (better == "lower") else "worse")


def _standard_error(now: Sample, before: Sample, earlier: Sequence[Sample]) -> float:
    """Return the standard error of the difference of two means; √2 SEM if both are single attempts
    alike.
    """
    between = spread_of([each.mean for each in earlier]) * math.sqrt(1 + 1 / before.attempts)
    freedom = sum(each.n - 1 for each in earlier)
    squares = sum((each.n - 1) * each.sd**2 for each in earlier)
    within = math.sqrt(squares / freedom * (1 / now.n + 1 / before.n)) if freedom else 0.0
    return max(between, within)


def spread_of(values: Sequence[float]) -> float:
    """Return the SD of values, by n - 1; 0 for one. ``statistics.stdev`` is exact, and thirty times
    as slow.
    """
    if len(values) < 2:
        return 0.0
    mean = fmean(values)
    return math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))
