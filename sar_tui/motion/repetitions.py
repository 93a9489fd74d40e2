"""Repetitions of a rhythmic exercise: movements out and back in a row, without the rests between
reaches.
"""

import math
from itertools import pairwise

import msgspec
import numpy as np

from sar_tui.motion.arrays import principal_axis, turning_points
from sar_tui.motion.rest import even
from sar_tui.motion.samples import Floats, Recording

_SMOOTH_S = 0.1
_COARSE_HZ = 50.0
_PERIODS_S = (0.5, 10.0)
_RHYTHM = 0.3
_FIRST_PEAK = 0.9
_AXIS_SMOOTH = 0.2
_TYPICAL = 0.8
_TURN = 0.35
_MOVES = 0.2
_SMALLEST_RAD = 0.1


class Repetitions(msgspec.Struct, frozen=True):
    """Repetitions in one recording.

    ``count``: to the nearest whole repetition; 0 without a rhythm. ``period_s``: period of the
    rhythm; None without one. ``turns_s``: the middle of each repetition, in s since the first
    sample. If the recording starts at rest, the movement turns back there.
    """

    count: int
    period_s: float | None = None
    turns_s: tuple[float, ...] = ()


def find_repetitions(recording: Recording) -> Repetitions:
    """Count the repetitions in a recording, with ``turns_s`` on its time axis.

    The samples are brought to an even grid first: missing ones are interpolated.
    """
    grid = even(recording)
    if not len(grid.time_s):
        return Repetitions(0)
    acceleration = recording.acceleration
    if acceleration is not None:
        usable = np.isfinite(acceleration).all(axis=1)
        time_s, axes = recording.time_s[usable], acceleration[usable].T
        acceleration = (
            np.column_stack([np.interp(grid.time_s, time_s, a) for a in axes])
            if len(time_s)
            else None
        )
    found = count_repetitions(grid.rate, acceleration, grid.rate_hz)
    return Repetitions(
        found.count, found.period_s, tuple(float(grid.time_s[0]) + turn for turn in found.turns_s)
    )


def count_repetitions(rate: Floats, acceleration: Floats | None, rate_hz: float) -> Repetitions:
    """Count the repetitions of a rhythmic exercise, in which a limb repeatedly moves out and back.

    1. Rhythm. The period of all axes together (gyroscope and accelerometer, each scaled to its own
       power) is found by the normalised square difference of McLeod & Wyvill (2005), "A smarter way
       to find pitch". The first peak within 90 % of the highest is taken, which avoids half and
       double periods.
    2. Angle. The angular rate about the main axis of the rhythm (the first principal component at
       this period) is integrated, and its drift is removed, because each movement out is followed
       by one back.
    3. Swings. The angle is followed from turn to turn. A wobble of less than 35 % of a typical
       swing belongs to the swing that it interrupts. Two swings are a repetition. A swing that the
       recording cuts off counts by the share that was recorded, in angle or in time, whichever is
       larger. Rest at either end does not count.

    Tempo and amplitude may change, and there may be pauses. At least two repetitions are needed, of
    0.5 to 10 s each, that turn the sensor by 0.1 rad (6°) or more.

    Args:
        rate: angular rate, shape (n, 3), rad/s.
        acceleration: shape (n, 3), any unit; None if not measured.
        rate_hz: samples per second.

    Raises:
        ValueError: if a sample is not finite, or the lengths differ.
    """
    _check(rate, acceleration)
    if not rate_hz > 0 or len(rate) < 2 * _PERIODS_S[0] * rate_hz:
        return Repetitions(0)
    every = max(int(rate_hz / _COARSE_HZ), 1)
    step_s = every / rate_hz
    turning = _smoothed(rate - rate.mean(axis=0), _SMOOTH_S * rate_hz)[::every]
    channels = [_scaled(turning)]
    if acceleration is not None:
        channels.append(
            _scaled(
                _smoothed(acceleration - acceleration.mean(axis=0), _SMOOTH_S * rate_hz)[::every]
            )
        )
    period = _period(np.hstack(channels), step_s)
    if period is None:
        return Repetitions(0)
    angle = np.cumsum(turning @ principal_axis(_smoothed(turning, _AXIS_SMOOTH * period))) * step_s
    times, cycles = _cycles(_without_drift(angle, period), period)
    count = math.floor(cycles[-1] + 0.5)
    if not count:
        return Repetitions(0)
    middles = np.interp(np.arange(count) + 0.5, cycles, times)
    return Repetitions(count, period * step_s, tuple(float(middle) * step_s for middle in middles))


def _check(rate: Floats, acceleration: Floats | None) -> None:
    if not np.isfinite(rate).all() or (
        acceleration is not None and not np.isfinite(acceleration).all()
    ):
        raise ValueError(
            "A sample is not a number: remove or interpolate such samples before counting "
            "repetitions."
        )
    if acceleration is not None and len(acceleration) != len(rate):
        raise ValueError(
            f"{len(rate)} samples of angular rate and {len(acceleration)} of acceleration do not "
            "match."
        )


def _scaled(channels: Floats) -> Floats:
    """Return channels scaled to a joint mean power of 1; unchanged if all are zero."""
    power = float(np.mean(np.sum(channels**2, axis=1)))
    return channels / math.sqrt(power) if power > 0 else channels


def _smoothed(channels: Floats, spread: float) -> Floats:
    """Smooth each column with a Gaussian of standard deviation ``spread`` samples, truncated at the
    ends.
    """
    count = len(channels)
    reach = min(math.ceil(4 * spread), count - 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / spread) ** 2)
    size = 2 ** math.ceil(math.log2(count + 2 * reach))
    weighted = np.column_stack([channels, np.ones(count)])
    spectrum = np.fft.rfft(weighted, size, axis=0) * np.fft.rfft(kernel, size)[:, np.newaxis]
    summed = np.fft.irfft(spectrum, size, axis=0)[reach : reach + count]
    return np.asarray(summed[:, :-1] / summed[:, -1:])


def _period(channels: Floats, step_s: float) -> int | None:
    """Return the period of all channels together, in samples; None without a rhythm."""
    similarity = _similarity(channels)
    shortest, longest = (round(period / step_s) for period in _PERIODS_S)
    similarity = similarity[: min(longest + 2, 2 * len(channels) // 3)]
    signs = np.sign(similarity)
    edges = [*(np.flatnonzero(np.diff(signs)) + 1), len(similarity)]
    hills = [range(start, end) for start, end in pairwise(edges) if similarity[start] > 0]
    tops = [hill.start + int(np.argmax(similarity[hill.start : hill.stop])) for hill in hills]
    tops = [top for top in tops if shortest <= top < len(similarity) - 1]
    highest = max((similarity[top] for top in tops), default=0.0)
    if highest < _RHYTHM:
        return None
    return next(top for top in tops if similarity[top] >= _FIRST_PEAK * highest)


def _similarity(channels: Floats) -> Floats:
    """Return the normalised square difference function: self-similarity at each lag, −1 to 1."""
    count = len(channels)
    size = 2 ** math.ceil(math.log2(2 * count))
    power = np.sum(np.abs(np.fft.rfft(channels, size, axis=0)) ** 2, axis=1)
    products = np.fft.irfft(power, size)[:count]
    energy = np.concatenate([[0.0], np.cumsum(np.sum(channels**2, axis=1))])
    lags = np.arange(count)
    both = energy[count - lags] + energy[count] - energy[lags]
    return np.asarray(2 * products / np.maximum(both, 1e-12 * both[0] + 1e-300))


def _without_drift(angle: Floats, period: int) -> Floats:
    """Return the angle without its drift between turns of the same kind, which comes from the
    gyroscope's bias.
    """
    turns = np.array(turning_points(angle, _TURN * _typical_swing(angle, period)))
    if len(turns) < 4:
        return angle
    drift = float(np.median((angle[turns[2:]] - angle[turns[:-2]]) / (turns[2:] - turns[:-2])))
    return angle - drift * np.arange(len(angle))


def _typical_swing(angle: Floats, period: int) -> float:
    """Return the range of the angle in a typical period, even if most of the recording is rest."""
    windows = np.lib.stride_tricks.sliding_window_view(angle, period)
    return max(
        float(np.quantile(windows.max(axis=1) - windows.min(axis=1), _TYPICAL)), _SMALLEST_RAD
    )


def _cycles(angle: Floats, period: int) -> tuple[Floats, Floats]:
    """Return instants, in samples, and the number of repetitions up to each."""
    turns = turning_points(angle, _TURN * _typical_swing(angle, period))
    if len(turns) < 3:
        return np.zeros(1), np.zeros(1)
    times = np.array([0, *turns, len(angle) - 1])
    swings = np.abs(np.diff(angle[times]))
    typical = float(np.median(swings[1:-1]))
    moves = np.abs(np.diff(angle, prepend=angle[0])) > _MOVES * typical / (period / 2)
    durations = np.diff(np.cumsum(moves)[times])
    in_angle, in_time = swings / typical, durations / np.median(durations[1:-1])
    there = np.minimum(np.maximum(in_angle, in_time), 1)
    there[2:-2] = 1
    return times.astype(float), np.concatenate([[0.0], np.cumsum(there)]) / 2
