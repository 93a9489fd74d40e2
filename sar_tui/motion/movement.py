"""Stretches of movement in a recording, and warnings of the reaches in them: the same for every
kind of detector.
"""

from collections.abc import Iterator

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.filters import LOW_RATE
from sar_tui.motion.grid import Grid
from sar_tui.motion.reach import Bounds
from sar_tui.motion.rest import Rest
from sar_tui.motion.samples import Floats


def stretches(moving: npt.NDArray[np.bool_], longest_rest: float) -> Iterator[slice]:
    """Yield stretches of movement that are not divided by a rest longer than ``longest_rest``
    samples.
    """
    index = moving.nonzero()[0]
    if not len(index):
        return
    rests = (index[1:] - index[:-1] > longest_rest).nonzero()[0]
    starts, stops = (0, *(rests + 1).tolist()), (*(rests + 1).tolist(), len(index))
    for start, stop in zip(starts, stops, strict=True):
        yield slice(int(index[start]), int(index[stop - 1]) + 1)


def checked(
    bounds: Bounds, grid: Grid, rest: Rest, *, is_cut: bool, longest_s: float, cutoff_hz: float
) -> Bounds:
    """Return a reach with the flags ``no_rest``, ``cut``, ``timed_out``, ``gap`` and ``low_rate``
    that apply to it.

    Args:
        bounds: the reach as found.
        grid, rest: of its recording.
        is_cut: True if the recording begins or ends in it.
        longest_s: a longer reach is cut off there.
        cutoff_hz: the low-pass that the detector wants.
    """
    end_s = max(bounds.onset_s, bounds.end_s)
    flags = list(bounds.flags)
    if not rest.whole or not (rest.still & (grid.time_s < bounds.onset_s)).any():
        flags.append("no_rest")
    if is_cut:
        flags.append("cut")
    if end_s - bounds.onset_s > longest_s:
        flags.append("timed_out")
        end_s = bounds.onset_s + longest_s
    if grid.has_hole(bounds.onset_s, end_s):
        flags.append("gap")
    if grid.rate_hz < LOW_RATE * cutoff_hz:
        flags.append("low_rate")
    return msgspec.structs.replace(
        bounds,
        end_s=end_s,
        arrival_s=min(max(bounds.arrival_s, bounds.onset_s), end_s),
        departure_s=min(max(bounds.departure_s, bounds.onset_s), end_s),
        flags=tuple(flags),
    )


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
