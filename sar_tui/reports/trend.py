"""Trend of a series by its median slope, which single outliers do not move. Pure."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from statistics import median

import msgspec

FEWEST = 5
"""Fewest values of a trend: with four, the interval would hold every slope."""
_Z = 1.959964


class Trend(msgspec.Struct, frozen=True):
    """Median slope of ``n`` values per step, with its 95 % interval. The values rise or fall if it
    leaves out zero.
    """

    n: int
    slope: float
    low: float
    high: float


def trend(values: Sequence[float]) -> Trend | None:
    """Return the trend of values in their order, a step apart; None with too few.

    The slope is the median of those of all pairs (Theil 1950), and its interval follows from the
    distribution of Kendall's score by the normal approximation, corrected for ties (Sen 1968).
    """
    n = len(values)
    if n < FEWEST:
        return None
    slopes = sorted(
        (later - earlier) / (j - i)
        for (i, earlier), (j, later) in combinations(enumerate(values), 2)
    )
    tied = sum(count * (count - 1) * (2 * count + 5) for count in Counter(values).values())
    spread = _Z * math.sqrt(max(0.0, (n * (n - 1) * (2 * n + 5) - tied) / 18))
    last = len(slopes) - 1
    low = max(0, round((len(slopes) - spread) / 2) - 1)
    high = min(last, round((len(slopes) + spread) / 2))
    return Trend(n, median(slopes), slopes[low], slopes[high])
