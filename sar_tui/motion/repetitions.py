"""How many repetitions a rhythmic exercise has, one after the other without the rests that reaches have between."""

import math
from itertools import pairwise

import msgspec
import numpy as np

from sar_tui.motion.samples import Floats
from sar_tui.motion.turning_points import turning_points

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
    """The repetitions of one recording.

    ``count``: how many, to the nearest whole one. ``period_s``: of the rhythm; None where there is none, and then
    ``count`` is 0. ``turns_s``: of each repetition the middle of its way, where it turns back if the recording starts
    at rest; s since the first sample.
    """

    count: int
    period_s: float | None = None
    turns_s: tuple[float, ...] = ()


def count_repetitions(rate: Floats, acceleration: Floats | None, rate_hz: float) -> Repetitions:
    """Count the repetitions of a rhythmic exercise: a limb that goes out and comes back, again and again.

    1. Rhythm. The period is that of all axes together (gyroscope and accelerometer, each scaled to its own power), by
       the normalised square difference of McLeod & Wyvill (2005), "A smarter way to find pitch": the first of its
       peaks within 90 % of the highest, so that neither two repetitions nor a half are taken for one.
    2. Angle. The limb's angle is the integral of the angular rate about the main axis of the rhythm (the first
       principal component at this period), without its drift: what goes out comes back.
    3. Swings. The angle is followed from turn to turn; a wobble of less than 35 % of a typical swing is part of the
       swing it interrupts. Two swings are a repetition. A swing at either end that the recording cuts off counts as
       the part that is there, in angle or in time, whichever is more; a rest there counts nothing.

    So tempo and size may change on the way, and there may be pauses. It needs two repetitions at least, from 0.5 to
    10 s each, that turn the sensor by 0.1 rad (6°) or more.

    Args:
        rate: angular rate, shape (n, 3), rad/s.
        acceleration: shape (n, 3), any unit; None where there is none.
        rate_hz: samples a second.

    Raises:
        ValueError: a sample is not finite, or the lengths differ.
    """
    _check(rate, acceleration)
    if not rate_hz > 0 or len(rate) < 2 * _PERIODS_S[0] * rate_hz:
        return Repetitions(0)
    every = max(int(rate_hz / _COARSE_HZ), 1)
    step_s = every / rate_hz
    turning = _smoothed(rate - rate.mean(axis=0), _SMOOTH_S * rate_hz)[::every]
    channels = [_scaled(turning)]
    if acceleration is not None:
        channels.append(_scaled(_smoothed(acceleration - acceleration.mean(axis=0), _SMOOTH_S * rate_hz)[::every]))
    period = _period(np.hstack(channels), step_s)
    if period is None:
        return Repetitions(0)
    angle = np.cumsum(turning @ _main_axis(_smoothed(turning, _AXIS_SMOOTH * period))) * step_s
    times, cycles = _cycles(_without_drift(angle, period), period)
    count = math.floor(cycles[-1] + 0.5)
    if not count:
        return Repetitions(0)
    middles = np.interp(np.arange(count) + 0.5, cycles, times)
    return Repetitions(count, period * step_s, tuple(float(middle) * step_s for middle in middles))


def _check(rate: Floats, acceleration: Floats | None) -> None:
    if not np.isfinite(rate).all() or (acceleration is not None and not np.isfinite(acceleration).all()):
        raise ValueError("A sample is not a number: leave such samples out, or fill them, before counting repetitions.")
    if acceleration is not None and len(acceleration) != len(rate):
        raise ValueError(f"{len(rate)} samples of angular rate and {len(acceleration)} of acceleration do not match.")


def _scaled(channels: Floats) -> Floats:
    """Channels with a mean power of 1 together; as they are if all zero."""
    power = float(np.mean(np.sum(channels**2, axis=1)))
    return channels / math.sqrt(power) if power > 0 else channels


def _smoothed(channels: Floats, spread: float) -> Floats:
    """Each column smoothed by a Gaussian, standard deviation ``spread`` samples; at the ends by what there is."""
    count = len(channels)
    reach = min(math.ceil(4 * spread), count - 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / spread) ** 2)
    size = 2 ** math.ceil(math.log2(count + 2 * reach))
    weighted = np.column_stack([channels, np.ones(count)])
    spectrum = np.fft.rfft(weighted, size, axis=0) * np.fft.rfft(kernel, size)[:, np.newaxis]
    summed = np.fft.irfft(spectrum, size, axis=0)[reach : reach + count]
    return np.asarray(summed[:, :-1] / summed[:, -1:])


def _period(channels: Floats, step_s: float) -> int | None:
    """The period of all channels together, in samples; None where there is no rhythm."""
    likeness = _likeness(channels)
    shortest, longest = (round(period / step_s) for period in _PERIODS_S)
    likeness = likeness[: min(longest + 2, 2 * len(channels) // 3)]
    signs = np.sign(likeness)
    edges = [*(np.flatnonzero(np.diff(signs)) + 1), len(likeness)]
    hills = [range(start, end) for start, end in pairwise(edges) if likeness[start] > 0]
    tops = [hill.start + int(np.argmax(likeness[hill.start : hill.stop])) for hill in hills]
    tops = [top for top in tops if shortest <= top < len(likeness) - 1]
    highest = max((likeness[top] for top in tops), default=0.0)
    if highest < _RHYTHM:
        return None
    return next(top for top in tops if likeness[top] >= _FIRST_PEAK * highest)


def _likeness(channels: Floats) -> Floats:
    """How like itself the signal is after each lag, −1 to 1: the normalised square difference function."""
    count = len(channels)
    size = 2 ** math.ceil(math.log2(2 * count))
    power = np.sum(np.abs(np.fft.rfft(channels, size, axis=0)) ** 2, axis=1)
    products = np.fft.irfft(power, size)[:count]
    energy = np.concatenate([[0.0], np.cumsum(np.sum(channels**2, axis=1))])
    lags = np.arange(count)
    both = energy[count - lags] + energy[count] - energy[lags]
    return np.asarray(2 * products / np.maximum(both, 1e-12 * both[0] + 1e-300))


def _main_axis(turning: Floats) -> Floats:
    """The axis about which it turns most: the first principal component."""
    return np.asarray(np.linalg.eigh(turning.T @ turning)[1][:, -1])


def _without_drift(angle: Floats, period: int) -> Floats:
    """The angle without what it gains from one turn to the next of the same kind: the gyroscope's bias."""
    turns = np.array(turning_points(angle.tolist(), _TURN * _typical_swing(angle, period)))
    if len(turns) < 4:
        return angle
    drift = float(np.median((angle[turns[2:]] - angle[turns[:-2]]) / (turns[2:] - turns[:-2])))
    return angle - drift * np.arange(len(angle))


def _typical_swing(angle: Floats, period: int) -> float:
    """How far it swings in a period, if up to most of the recording is rest."""
    windows = np.lib.stride_tricks.sliding_window_view(angle, period)
    return max(float(np.quantile(windows.max(axis=1) - windows.min(axis=1), _TYPICAL)), _SMALLEST_RAD)


def _cycles(angle: Floats, period: int) -> tuple[Floats, Floats]:
    """Instants, in samples, and how many repetitions there have been until each."""
    turns = turning_points(angle.tolist(), _TURN * _typical_swing(angle, period))
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
