"""Statistics of measurement errors, as timing claims report them."""

from collections.abc import Sequence
from statistics import fmean, median, quantiles, stdev

import msgspec

_NORMAL = 1.4826
"""The standard deviation of a normal distribution, in median absolute deviations."""


class ErrorStatistics(msgspec.Struct, frozen=True):
    """Statistics of ``n`` errors in ms.

    ``robust_sd_ms`` is the median absolute deviation scaled to be the standard deviation of normal
    errors, so that one stall of the machine does not hide the distribution of the others (Leys et
    al. 2013). ``iqr_ms`` is the interquartile range, ``p99_ms`` the 99th percentile of the errors'
    absolute values, ``max_ms`` the largest.
    """

    n: int
    mean_ms: float
    median_ms: float
    sd_ms: float
    iqr_ms: float
    robust_sd_ms: float
    p99_ms: float
    max_ms: float


def error_statistics(errors: Sequence[float]) -> ErrorStatistics:
    """Compute the statistics of errors in ms. Percentiles are interpolated between the errors (R's
    type 7).

    Raises:
        ValueError: there are fewer than two.
    """
    if len(errors) < 2:
        raise ValueError("Error statistics take two errors or more.")
    middle = median(errors)
    lower, _, upper = quantiles(errors, n=4, method="inclusive")
    sizes = [abs(error) for error in errors]
    return ErrorStatistics(
        n=len(errors),
        mean_ms=fmean(errors),
        median_ms=middle,
        sd_ms=stdev(errors),
        iqr_ms=upper - lower,
        robust_sd_ms=_NORMAL * median(abs(error - middle) for error in errors),
        p99_ms=quantiles(sizes, n=100, method="inclusive")[98],
        max_ms=max(sizes),
    )
