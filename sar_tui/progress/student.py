"""Student's t distribution, as far as 95 % bands need it."""

import math
from functools import cache

_STEPS = 60
"""Bisections; each halves the error."""


def within(t: float, df: int) -> float:
    """Return the probability of a value between -t and t (Abramowitz & Stegun 1964, 26.7.3 and 26.7.4)."""
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
def t95(df: int) -> float:
    """Return the value that is exceeded, on either side, with a probability of 5 %."""
    low, high = 1.0, 13.0
    for _ in range(_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle, df) < 0.95 else (low, middle)
    return (low + high) / 2
