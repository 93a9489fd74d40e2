"""Arithmetic on arrays: vectors in space, order statistics, changes and turning points of signals."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sar_tui.motion.samples import Floats


def lengths(vectors: Floats) -> Floats:
    """Return the length of each vector, shape (..., 3) to (...).

    The same numbers as ``numpy.linalg.norm`` along the last axis, in a third of the time.
    """
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    found: Floats = np.sqrt(x * x + y * y + z * z)
    return found


def mean_of(vectors: Floats) -> Floats:
    """Return the mean of vectors, shape (n, 3) with n of at least 1. The same numbers as
    ``numpy.mean``, sooner.
    """
    found: Floats = np.add.reduce(vectors, axis=0) / len(vectors)
    return found


def sums_of_axes(vectors: Floats) -> Floats:
    """Return the sum of each vector's three values, shape (n, 3) to (n,). The same numbers as
    ``numpy.sum`` along the last axis, sooner.
    """
    found: Floats = vectors[:, 0] + vectors[:, 1] + vectors[:, 2]
    return found


def principal_axis(rate: Floats) -> Floats:
    """Return the main axis of rotation, a unit vector of shape (3,); ``rate`` without bias, shape
    (n, 3).
    """
    axis: Floats = np.linalg.eigh(rate.T @ rate)[1][:, -1]
    return axis


def order_statistic(x: Floats, share: float) -> float:
    """Return the value at a share, 0 to 1, of the sorted array; 0 for an empty one.

    `percentile` interpolates between two such values.
    """
    index = round(share * (len(x) - 1))
    return float(np.partition(x, index)[index]) if len(x) else 0.0


def percentile(x: Floats, share: float) -> float:
    """Return a percentile; 0 for an empty array. The same as that of numpy, which takes four times
    as long.
    """
    if not len(x):
        return 0.0
    place = share / 100.0 * (len(x) - 1)
    below = min(int(place), len(x) - 2) if len(x) > 1 else 0
    above = min(below + 1, len(x) - 1)
    ordered = np.partition(x, (below, above))
    low, high, part = float(ordered[below]), float(ordered[above]), place - below
    return low + (high - low) * part if part < 0.5 else high - (high - low) * (1.0 - part)


def finite_only(time_s: Floats, vectors: Floats) -> tuple[Floats, Floats]:
    """Return times, shape (n,), and vectors, shape (n, 3), without those that have a number that is
    not finite.
    """
    finite = np.isfinite(vectors)
    if finite.all():
        return time_s, vectors
    usable = finite.all(axis=1)
    return time_s[usable], vectors[usable]


def changes(values: npt.NDArray[Any]) -> npt.NDArray[np.intp]:
    """Return the indices at which a signal changes its value; before its start and after its end it
    counts as 0.

    Of a mask, they are the first index of each run of True and the first one after it, in turn.

    Args:
        values: shape (n,).
    """
    padded = np.zeros(len(values) + 2, values.dtype)
    padded[1:-1] = values
    found: npt.NDArray[np.intp] = (padded[1:] != padded[:-1]).nonzero()[0]
    return found


def turning_points(values: Sequence[float] | Floats, swing: float) -> list[int]:
    """Return the indices of the extremes between which the signal moves by ``swing`` (above 0) or
    more, alternating.

    Smaller movements the other way belong to the swing that they interrupt. The first index is
    where the first swing starts, the last where the last swing ends; empty without a swing.
    """
    found: list[int] = []
    signal = np.asarray(values, dtype=float)
    if not len(signal):
        return found
    low = high = 0
    lowest = highest = float(signal[0])
    rising: bool | None = None
    extremes = _extremes(signal)
    for index, value in zip(extremes.tolist(), signal[extremes].tolist(), strict=True):
        if rising is not False and value > highest:
            high, highest = index, value
        if rising is not True and value < lowest:
            low, lowest = index, value
        if rising is not True and value - lowest >= swing:
            found.append(low)
            rising, high, highest = True, index, value
        elif rising is not False and highest - value >= swing:
            found.append(high)
            rising, low, lowest = False, index, value
    return [*found, high if rising else low] if found else found


def _extremes(signal: Floats) -> npt.NDArray[np.intp]:
    """Return the index of each extreme of a signal; of a plateau its first."""
    steps = signal[1:] - signal[:-1]
    changed = steps.nonzero()[0]
    ways = steps[changed] > 0
    last = np.ones(len(changed), dtype=bool)
    last[:-1] = ways[1:] != ways[:-1]
    found: npt.NDArray[np.intp] = changed[last] + 1
    return found
