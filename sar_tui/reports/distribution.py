"""Distribution of times: statistics and a histogram. Pure."""

import math
from collections.abc import Sequence
from statistics import median, quantiles

import msgspec

BINS = 12
"""Largest number of bars."""
_LONGEST = 4
"""Largest width of a histogram bar per time, in characters."""


class Distribution(msgspec.Struct, frozen=True):
    """Statistics of ``n`` times in ms: percentiles (``p5`` …), ``iqr`` (p75 − p25), the longest
    (``worst``).
    """

    n: int
    median: float
    iqr: float
    p5: float
    p25: float
    p75: float
    p95: float
    worst: float


def distribution(times: Sequence[float]) -> Distribution | None:
    """Return the statistics of times (ms), or None without times. Percentiles are interpolated (R's
    type 7).
    """
    if not times:
        return None
    cuts = quantiles(times, n=20, method="inclusive") if len(times) > 1 else [times[0]] * 19
    p5, p25, p75, p95 = (round(cuts[twentieth - 1], 3) for twentieth in (1, 5, 15, 19))
    return Distribution(
        n=len(times),
        median=round(median(times), 3),
        iqr=round(cuts[14] - cuts[4], 3),
        p5=p5,
        p25=p25,
        p75=p75,
        p95=p95,
        worst=round(max(times), 3),
    )


class Bin(msgspec.Struct, frozen=True):
    """Number of times from ``low`` up to but not including ``high`` (ms)."""

    low: float
    high: float
    n: int


def bins(times: Sequence[float], most: int = BINS) -> list[Bin]:
    """Count times (ms) in bins of one round width: 1, 2 or 5 times a power of ten, 1 ms or more; at
    most ``most`` bins.

    The first holds the shortest time, the last the longest; empty bins between them are included.
    """
    if not times:
        return []
    low, high = min(times), max(times)
    width = _width(low, high, most)
    first, last = math.floor(low / width), math.floor(high / width)
    counts = [0] * (last - first + 1)
    for time in times:
        counts[math.floor(time / width) - first] += 1
    return [
        Bin((first + n) * width, (first + n + 1) * width, count) for n, count in enumerate(counts)
    ]


def _width(low: float, high: float, most: int) -> float:
    power = 10.0 ** math.floor(math.log10(max(high - low, most) / most))
    steps = (step * scale for scale in (power, power * 10, power * 100) for step in (1, 2, 5))
    return next(step for step in steps if math.floor(high / step) - math.floor(low / step) < most)


def histogram(times: Sequence[float], width: int) -> list[str]:
    """Draw times (ms), one line for each bin, at most ``width`` characters wide."""
    found = bins(times)
    if not found:
        return []
    names = [f"{each.low:g}–{each.high:g} ms" for each in found]
    margin, figures = max(map(len, names)), len(str(max(each.n for each in found)))
    room = max(1, width - margin - figures - 3)
    cells = min(room / max(each.n for each in found), _LONGEST)
    return [
        f"{name:>{margin}} {'█' * math.ceil(each.n * cells - 1e-9)} {each.n}"
        for name, each in zip(names, found, strict=True)
    ]
