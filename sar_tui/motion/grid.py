"""A recording on an even grid: missing samples are interpolated linearly, and holes are listed."""

from typing import NamedTuple

import numpy as np

from sar_tui.motion.samples import Floats, Recording

GAP_S = 0.1
"""Longest time between two samples that is not a hole."""


class Grid(NamedTuple):
    """Evenly spaced samples. ``holes``: shape (k, 2), s, where more than ``GAP_S`` is missing."""

    time_s: Floats
    rate: Floats
    rate_hz: float
    holes: Floats

    def has_hole(self, from_s: float, to_s: float) -> bool:
        """Return True if a hole lies between the two times."""
        return bool(((self.holes[:, 0] < to_s) & (self.holes[:, 1] > from_s)).any())


def even(recording: Recording) -> Grid:
    """Return a recording's angular rate on an even grid, at its median rate. Empty below two usable samples."""
    usable = np.isfinite(recording.rate).all(axis=1)
    time, rate = recording.time_s[usable], recording.rate[usable]
    if len(time) < 2:
        return Grid(np.empty(0), np.empty((0, 3)), 0.0, np.empty((0, 2)))
    step = 1.0 / recording.rate_hz
    steps = np.diff(time)
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-6) + 1)
    wide = steps > max(GAP_S, 1.5 * step)
    holes = np.column_stack((time[:-1][wide], time[1:][wide]))
    return Grid(grid, np.column_stack([np.interp(grid, time, axis) for axis in rate.T]), recording.rate_hz, holes)
