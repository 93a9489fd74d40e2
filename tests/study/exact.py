"""Exact power of the three designs, by the noncentral t distribution."""

import math

from scipy.integrate import quad
from scipy.stats import f, nct
from scipy.stats import t as student


def _two_sided(shift: float, df: float) -> float:
    critical = student.ppf(0.975, df)
    return float(nct.sf(critical, df, shift) + nct.cdf(-critical, df, shift))


def within(dz: float, size: int) -> float:
    return _two_sided(dz * math.sqrt(size), size - 1)


def groups(d: float, size: int) -> float:
    return _two_sided(d * math.sqrt(size / 4), size - 2)


def groups_with_baseline(d: float, r: float, size: int) -> float:
    """Return the power, averaged over the baselines that chance brings (Shieh 2020,
    10.1007/s11336-019-09692-3): how far they are apart follows an F distribution.
    """

    def given(apart: float) -> float:
        leverage = 4 / size * (1 + apart / (size - 2))
        return _two_sided(d / math.sqrt((1 - r**2) * leverage), size - 3)

    apart = f(1, size - 2)
    # by probability, where the density has no pole
    return float(quad(lambda p: given(apart.ppf(p)), 0, 1, limit=200)[0])
