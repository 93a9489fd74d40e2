"""A recording on an even grid, and its rests: the sensor's bias and noise, the hand's tremor."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sar_tui.motion.arrays import finite_only, lengths, mean_of, sums_of_axes
from sar_tui.motion.filters import Spectrum, hann
from sar_tui.motion.samples import Floats, Recording

SLOW_HZ = 2.5
"""Voluntary movement lies below this frequency, tremor above it."""
STILL_RAD_S = 0.05
"""A hand is still where its rate below ``SLOW_HZ`` varies less (standard deviation, all axes
together), rad/s.
"""
STEADY_RAD_S = 0.06
"""Largest change of the bias between rests, rad/s; a larger one is a slow, steady movement."""
STEP_S = 0.1
"""Time between the starts of two windows."""
STEADY_HZ, LARGE_RAD_S = 1.0, 0.15
"""Cutoff below which a hand rests that a tremor leaves nothing still below ``SLOW_HZ``; and the
least standard deviation of the rate above ``SLOW_HZ`` with which such a rest is sought.
"""
NEARBY_S = 2.0
"""Time on either side over which the bias is averaged."""
TREMOR_HZ = (3.0, 12.0)
TREMOR_RAD_S = 0.03
"""Smallest amplitude of a tremor."""
PEAKED = 4.0
"""A tremor's peak exceeds the median of the tremor band by this factor."""
SPECTRA = 40
"""Largest number of windows whose spectra are averaged."""
GAP_S = 0.1
"""Longest time between two samples that is not a hole."""


class Rest(NamedTuple):
    """The rest in a recording of n samples.

    ``bias``: shape (n, 3), rad/s, from the rests nearby. ``still``: shape (n,), True where the hand
    rests. ``whole``: True if it rests for as long as requested. ``tremor_hz``: the tremor's
    frequency at rest, None without tremor.
    """

    bias: Floats
    still: npt.NDArray[np.bool_]
    whole: bool
    tremor_hz: float | None


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


def find_rest(rate: Floats, rate_hz: float, rest_s: float, *, tremor: bool = True) -> Rest:
    """Find where the hand rests for ``rest_s`` or longer, and estimate bias and tremor there.

    A rest is a window in which the slow part of the rate is steady, at a level that agrees with the
    others. Shorter windows, down to a quarter, are used if there is none of that length. If nothing
    is still, the bias is the mean of all samples, which is right for a hand that has returned to
    its start.

    Args:
        rate: angular rate on a uniform grid, shape (n, 3), rad/s.
        rate_hz: samples per second.
        rest_s: duration of a rest.
        tremor: False to leave out the tremor's frequency.
    """
    spectrum = Spectrum(rate, rate_hz)
    slow = spectrum.below(SLOW_HZ)
    large_hz = _large_tremor_hz(rate, spectrum, rest_s, rate_hz) if tremor else None
    if large_hz is not None:
        slow = spectrum.below(SLOW_HZ, large_hz)
    for share in (1.0, 0.5, 0.25):
        size = max(2, round(share * rest_s * rate_hz))
        begins = np.arange(0, len(rate) - size + 1, max(1, round(STEP_S * rate_hz)))
        mean, spread = _windows(slow, begins, size)
        steady = _steady(spread)
        if len(steady):
            chosen = _inner(steady[_agreeing(mean[steady])], len(begins))
            tremor_hz = large_hz
            if tremor and large_hz is None:
                tremor_hz = _tremor_hz(rate, begins[chosen], size, rate_hz)
            still, bias = _rest(rate, begins[chosen], mean[chosen], size)
            return Rest(bias, still, share == 1.0, tremor_hz)
    nowhere = np.zeros(len(rate), dtype=bool)
    return Rest(np.tile(rate.mean(axis=0), (len(rate), 1)), nowhere, False, None)


def _steady(spread: Floats) -> npt.NDArray[np.intp]:
    """Return the windows in which the hand is still, by the standard deviation in each."""
    limit = np.clip(2.0 * spread.min(initial=STILL_RAD_S), STILL_RAD_S / 4, STILL_RAD_S)
    found: npt.NDArray[np.intp] = (spread < limit).nonzero()[0]
    return found


def _large_tremor_hz(
    rate: Floats, spectrum: Spectrum, rest_s: float, rate_hz: float
) -> float | None:
    """Return the frequency of a tremor at rest that is so large that the hand does not seem still;
    None without one.

    It is sought where the hand is still below ``STEADY_HZ``.
    """
    shaking = rate - spectrum.below(SLOW_HZ)
    if float((shaking * shaking).sum()) / len(rate) < LARGE_RAD_S**2:
        return None
    size = max(2, round(rest_s * rate_hz))
    begins = np.arange(0, len(rate) - size + 1, max(1, round(STEP_S * rate_hz)))
    steady = _steady(_windows(spectrum.below(STEADY_HZ), begins, size)[1])
    if not len(steady):
        return None
    return _tremor_hz(rate, begins[steady], size, rate_hz)


def _rest(
    rate: Floats, begins: npt.NDArray[np.int_], levels: Floats, size: int
) -> tuple[npt.NDArray[np.bool_], Floats]:
    """Return where the hand is still and the bias, of windows of ``size`` samples at ``begins``,
    with their levels.
    """
    edges = np.zeros(len(rate) + 1, dtype=int)
    edges[begins] += 1
    edges[begins + size] -= 1
    still = np.cumsum(edges[:-1]) > 0
    nearby = _running_mean(levels, round(NEARBY_S / STEP_S))
    index, middles = np.arange(float(len(rate))), begins + size / 2
    return still, np.column_stack([np.interp(index, middles, axis) for axis in nearby.T])


def _windows(x: Floats, begins: npt.NDArray[np.int_], size: int) -> tuple[Floats, Floats]:
    """Return the mean of each axis, shape (k, 3), and the joint standard deviation, shape (k,), of
    each window.
    """
    centre = mean_of(x)
    centred = x - centre
    sums = np.concatenate((np.zeros((1, 3)), np.cumsum(centred, axis=0)))
    squares = np.concatenate(([0.0], np.cumsum(sums_of_axes(centred**2))))
    mean = (sums[begins + size] - sums[begins]) / size
    variance = (squares[begins + size] - squares[begins]) / size - sums_of_axes(mean**2)
    return mean + centre, np.sqrt(np.maximum(variance, 0.0))


def _agreeing(levels: Floats) -> npt.NDArray[np.int_]:
    """Return the indices of the levels, shape (k, 3), that belong to one slowly changing bias: that
    of most of them.
    """
    some = levels[:: max(1, len(levels) // 200)]
    apart = lengths(np.moveaxis(np.array([axis[:, None] - axis for axis in some.T]), 0, -1))
    agreement = (apart < STEADY_RAD_S).sum(axis=1)
    anchor = int(lengths(levels - some[agreement.argmax()]).argmin())
    chosen, each = [anchor], levels.tolist()  # plain numbers: an array of three takes longer
    for order in (range(anchor + 1, len(each)), range(anchor - 1, -1, -1)):
        near = x, y, z = each[anchor]
        for index in order:
            level = each[index]
            if math.dist(level, near) < STEADY_RAD_S:
                chosen.append(index)
                near = x, y, z = (
                    0.8 * x + 0.2 * level[0],
                    0.8 * y + 0.2 * level[1],
                    0.8 * z + 0.2 * level[2],
                )
    return np.array(sorted(chosen))


def _inner(chosen: npt.NDArray[np.int_], count: int) -> npt.NDArray[np.int_]:
    """Drop the first and last two windows of each rest, which adjoin movement, unless no others are
    left.
    """
    calm = np.zeros(count + 4, dtype=bool)
    calm[:2] = calm[-2:] = True
    calm[chosen + 2] = True
    inner = chosen[calm[chosen] & calm[chosen + 1] & calm[chosen + 3] & calm[chosen + 4]]
    return inner if len(inner) else chosen


def _running_mean(levels: Floats, reach: int) -> Floats:
    """Return the mean of each level and up to ``reach`` neighbours on either side."""
    sums = np.concatenate((np.zeros((1, 3)), np.cumsum(levels, axis=0)))
    index = np.arange(len(levels))
    first, last = np.maximum(index - reach, 0), np.minimum(index + reach + 1, len(levels))
    mean: Floats = (sums[last] - sums[first]) / (last - first)[:, None]
    return mean


def _tremor_hz(
    rate: Floats, begins: npt.NDArray[np.int_], size: int, rate_hz: float
) -> float | None:
    """Return the frequency of a clear peak of the rests' mean spectrum in the tremor band; None
    without one.

    A hand whose whole movement is smaller than a tremor has none, whatever its spectrum.
    """
    some = begins[:: max(1, len(begins) // SPECTRA)]
    windows = rate[some[:, None] + np.arange(size)]
    taper = hann(size)[:, None]
    windows = (windows - windows.mean(axis=1, keepdims=True)) * taper
    per_sine = 2 / float(taper.sum())
    # Cauchy-Schwarz
    largest = per_sine * math.sqrt(size * float((windows**2).sum()) / len(windows))
    if largest < (1 - 1e-9) * TREMOR_RAD_S:
        return None
    frequency = np.fft.rfftfreq(4 * size, 1 / rate_hz)
    first, last = (
        np.searchsorted(frequency, TREMOR_HZ[0]),
        np.searchsorted(frequency, TREMOR_HZ[1], "right"),
    )
    band = np.fft.rfft(windows, 4 * size, axis=1)[:, first:last]
    amplitude = np.abs(band) * per_sine
    spectrum = np.sqrt((amplitude**2).sum(axis=2).mean(axis=0))
    peak = float(spectrum.max(initial=0.0))
    if peak <= max(TREMOR_RAD_S, PEAKED * float(np.median(spectrum))):
        return None
    return float(frequency[first:last][spectrum.argmax()])


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
