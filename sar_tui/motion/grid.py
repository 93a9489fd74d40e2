"""A recording on an even grid: missing samples are interpolated linearly, and holes are listed."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from sar_tui.motion.filters import Spectrum
from sar_tui.motion.rest import Rest, find_rest
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.vectors import finite_only

GAP_S = 0.1
"""Longest time between two samples that is not a hole."""


class Unbiased(NamedTuple):
    """The rest in a recording, its angular rate without the bias at rest, rad/s, and the spectrum
    of that.
    """

    rest: Rest
    rate: Floats
    spectrum: Spectrum


@dataclass(frozen=True, eq=False)
class Grid:
    """Evenly spaced samples. ``holes``: shape (k, 2), s, where more than ``GAP_S`` is missing."""

    time_s: Floats
    rate: Floats
    rate_hz: float
    holes: Floats
    _unbiased: dict[float, Unbiased] = field(default_factory=dict)

    def unbiased(self, rest_s: float) -> Unbiased:
        """Return the rate without its bias, found once for all detectors; ``rest_s`` as in
        `rest.find_rest`.
        """
        if rest_s not in self._unbiased:
            rest = find_rest(self.rate, self.rate_hz, rest_s)
            rate = self.rate - rest.bias
            self._unbiased[rest_s] = Unbiased(rest, rate, Spectrum(rate, self.rate_hz))
        return self._unbiased[rest_s]

    def has_hole(self, from_s: float, to_s: float) -> bool:
        """Return True if a hole lies between the two times."""
        return bool(((self.holes[:, 0] < to_s) & (self.holes[:, 1] > from_s)).any())


def even(recording: Recording) -> Grid:
    """Return a recording's angular rate on an even grid, at its median rate. Empty below two usable
    samples.
    """
    time, rate = finite_only(recording.time_s, recording.rate)
    if len(time) < 2:
        return Grid(np.empty(0), np.empty((0, 3)), 0.0, np.empty((0, 2)))
    step = 1.0 / recording.rate_hz
    steps = np.diff(time)
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-6) + 1)
    wide = steps > max(GAP_S, 1.5 * step)
    holes = np.column_stack((time[:-1][wide], time[1:][wide]))
    return Grid(
        grid,
        np.column_stack([np.interp(grid, time, axis) for axis in rate.T]),
        recording.rate_hz,
        holes,
    )
