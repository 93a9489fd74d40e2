"""Student's t distribution, as far as bands and detectable changes need it."""

import math
from functools import cache

_STEPS = 60
"""Bisections; each halves the error."""
_HIGHEST = 64.0
"""More than any value between which 99 % lie."""


def within(t: float, df: int) -> float:
    """Return the probability of a value between -t and t (Abramowitz & Stegun 1964, 26.7.3 and
    26.7.4).
    """
    angle = math.atan(t / math.sqrt(df))
    cosine = math.cos(angle)
    is_odd = df % 2 == 1
    term = cosine if is_odd else 1.0
    total = 0.0 if df == 1 else term
    for power in range(3 if is_odd else 2, df - 1, 2):
        term *= cosine**2 * (power - 1) / power
        total += term
    if is_odd:
        return 2 / math.pi * (angle + math.sin(angle) * total)
    return math.sin(angle) * total


@cache
def quantile(df: int, share: float) -> float:
    """Return the value t that leaves a share of the distribution, at least a half, between -t and
    t.
    """
    low, high = 0.5, _HIGHEST
    for _ in range(_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle, df) < share else (low, middle)
    return (low + high) / 2


def t95(df: int) -> float:
    """Return the value that is exceeded, on either side, with a probability of 5 %."""
    return quantile(df, 0.95)
