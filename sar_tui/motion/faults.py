"""Faults of a recording that its sensor did not report: it was beyond its range, or its unit is
another one.
"""

import math

import numpy as np

from sar_tui.motion.arrays import changes, finite_only
from sar_tui.motion.samples import Floats

PLATEAU = 5
"""Least number of equal samples in a row that are a plateau."""
SIDE, STEEP = 3, 10
"""Number of samples of a plateau's sides, and by how many of the sensor's steps each rises or falls
at least.
"""
MOVING_RAD_S = 0.3
"""No range is as small as this."""
TOO_FAR_RAD = 4 * math.pi
"""Turn about one axis within ``TURN_S`` that no hand makes: two whole turns."""
TURN_S = (0.5, 1.0, 3.0)


def is_clipped(rate: Floats) -> bool:
    """Return True if a gyroscope was beyond its range: its largest value stays exactly the same
    while the hand is fast.

    A sensor of few steps also repeats its largest value, but where the hand is slow to change: the
    sides of the plateau tell them apart.

    Args:
        rate: angular rate, shape (n, 3), rad/s, as measured: neither filtered nor interpolated, nor
            without its bias.
    """
    return any(_has_plateau(side * axis) for axis in rate.T for side in (1.0, -1.0))


def _has_plateau(values: Floats) -> bool:
    largest = values.max(initial=0.0)
    if largest < MOVING_RAD_S or np.count_nonzero(values == largest) < PLATEAU:
        return False
    steps = np.abs(np.diff(values))
    step = steps[steps > 0].min(initial=np.inf)
    edges = changes(values == largest)
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if last - first < PLATEAU or first < SIDE or last + SIDE > len(values):
            continue
        rises, falls = largest - values[first - SIDE], largest - values[last + SIDE - 1]
        if min(rises, falls) >= STEEP * step * (1 - 1e-9):
            return True
    return False


def turns_too_far(time_s: Floats, rate: Floats) -> bool:
    """Return True if the hand would turn farther than any hand can, so that the rate is most likely
    in deg/s.

    A reach in deg/s, read as rad/s, turns by 57 times its angle. What counts is the turn about one
    axis of the sensor, one way, within a few seconds: two whole turns or more.

    Args:
        time_s: shape (n,), rising, in s.
        rate: angular rate, shape (n, 3), rad/s.
    """
    time_s, rate = finite_only(time_s, rate)
    if len(time_s) < 2 or np.abs(rate).max() * max(TURN_S) <= TOO_FAR_RAD:
        return False
    steps = np.minimum(np.diff(time_s), 0.1)[:, None] * (rate[1:] + rate[:-1]) / 2.0
    angle = np.concatenate((np.zeros((1, 3)), np.cumsum(steps, axis=0)))
    for within_s in TURN_S:
        later = np.searchsorted(time_s, time_s + within_s, side="right") - 1
        if np.abs(angle[later] - angle).max() > TOO_FAR_RAD:
            return True
    return False
