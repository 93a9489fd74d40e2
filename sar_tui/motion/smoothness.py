"""Smoothness of a movement, from its speed profile.

Each function takes one phase of a movement (out, or back), never both: the rest between them would
count as jerk. None means that there is no result: the phase is too short, holds no movement, or a
sample is not finite.
"""

import math
from itertools import pairwise

import numpy as np

from sar_tui.motion.arrays import turning_points
from sar_tui.motion.samples import Floats

_SHORTEST_S = 0.1
_FEWEST_SAMPLES = 5
_NO_JERK = 1e-12

_SPECTRUM_HZ = 10.0
_SPECTRUM_FLOOR = 0.05
_SPECTRUM_PADDING = 4

_JERK_HZ = 100.0

_UNIT_RISE = 0.1
_UNIT_APART_S = 0.15


def sparc(speed: Floats, rate_hz: float) -> float | None:
    """Return the spectral arc length: minus the length of the speed's normalised amplitude
    spectrum, 0 is smoothest.

    After Balasubramanian, Melendez-Calderon, Roby-Brami & Burdet (2015), "On the analysis of
    movement smoothness", J NeuroEng Rehabil 12:112, with its settings: the spectrum ends at 10 Hz
    or where it is last at 5 % of its maximum, whichever comes first; n samples are zero-padded to 2
    ** (ceil(log2(n)) + 4). The frequency axis is scaled to 1 over what is left of the spectrum. The
    same as ``sparc`` of the package monalysa for rates from 20 Hz.

    A minimum-jerk speed of 1 s, sampled at 100 Hz from 0 to 0.99 s, has −1.4058293244.

    Args:
        speed: shape (n,), not negative, any unit.
        rate_hz: samples per second.
    """
    profile = _measurable(speed, rate_hz, _SHORTEST_S)
    if profile is None:
        return None
    size = 2 ** (math.ceil(math.log2(len(profile))) + _SPECTRUM_PADDING)
    amplitude = np.abs(np.fft.rfft(profile, size))
    amplitude /= amplitude.max()
    known = min(len(amplitude), int(_SPECTRUM_HZ * size / rate_hz) + 2)
    amplitude = amplitude[:known][np.arange(known) * (rate_hz / size) <= _SPECTRUM_HZ]
    above = (amplitude >= _SPECTRUM_FLOOR).nonzero()[0]
    kept = amplitude[above[0] : above[-1] + 1] if len(above) else above
    if len(kept) < 2:
        return None
    return -float(np.hypot(1.0 / (len(kept) - 1), kept[1:] - kept[:-1]).sum())


def ldlj(speed: Floats, rate_hz: float) -> float | None:
    """Return the log dimensionless jerk of a speed profile: −ln(duration³ / peak² · ∫ jerk² dt), 0
    is smoothest.

    Jerk is the second derivative of speed. Same source as ``sparc``, and the same as
    ``log_dimensionless_jerk`` of monalysa at 100 Hz: the derivative is the second difference over
    (1 / rate)², the integral a sum over it, and the duration of n samples is n / rate. As such
    differences depend on the rate, other rates are resampled to 100 Hz first (to the nearest whole
    number of samples).

    A minimum-jerk speed of 1 s, sampled at 100 Hz from 0 to 0.99 s, has −5.2241390675.

    Args:
        speed: shape (n,), not negative, any unit.
        rate_hz: samples per second.
    """
    profile = _measurable(speed, rate_hz, _SHORTEST_S)
    if profile is None:
        return None
    profile, step_s = _resampled(profile, 1.0 / rate_hz, _JERK_HZ)
    jerk = np.diff(profile / profile.max(), n=2) / step_s**2
    dimensionless = (len(profile) * step_s) ** 3 * float(np.sum(jerk**2)) * step_s
    return -math.log(dimensionless) if dimensionless > _NO_JERK else None


def movement_units(speed: Floats, rate_hz: float) -> int:
    """Return the number of movement units: one for a smooth reach, more with every correction.

    A movement unit is an acceleration and the deceleration after it (von Hofsten 1991, J Mot Behav
    23:280-292); fewer peaks of speed are a mark of recovery after stroke (Rohrer et al. 2002, J
    Neurosci 22:8297-8304). A rise counts from 10 % of the profile's peak, and a peak within 150 ms
    of the last one counted belongs to it (the latter after Alt Murphy, Willén & Sunnerhagen 2011,
    Neurorehabil Neural Repair 25:71-80; their 20 mm/s has no angular equivalent, so the rise is
    relative).

    Args:
        speed: shape (n,), not negative, any unit.
        rate_hz: samples per second.
    """
    profile = _measurable(speed, rate_hz, 0.0)
    if profile is None:
        return 0
    apart = _UNIT_APART_S * rate_hz
    units, counted_at = 0, -math.inf
    for start, peak in pairwise(turning_points(profile, _UNIT_RISE)):
        if profile[peak] > profile[start] and peak - counted_at >= apart:
            units, counted_at = units + 1, peak
    return units


def _measurable(speed: Floats, rate_hz: float, shortest_s: float) -> Floats | None:
    """Return the profile with its peak scaled to 1; None if there is nothing to measure."""
    if not rate_hz > 0 or len(speed) < max(_FEWEST_SAMPLES, shortest_s * rate_hz):
        return None
    profile = np.asarray(speed, dtype=float)
    peak = float(profile.max())
    if not np.isfinite(profile).all() or not peak > 0:
        return None
    return profile / peak


def _resampled(profile: Floats, step_s: float, rate_hz: float) -> tuple[Floats, float]:
    """Return the profile between the same end points in steps of about 1 / rate_hz, and the step.

    Uses a sine series of the profile minus the line through its ends, cut off at half the lower of
    the two rates: smooth between samples (linear interpolation would be all jerk) and free of
    aliasing.
    """
    steps = len(profile) - 1
    wanted = max(round(steps * step_s * rate_hz), 2)
    if wanted == steps:
        return profile, step_s
    rest = profile - np.linspace(profile[0], profile[-1], steps + 1)
    spectrum = np.fft.rfft(np.concatenate([rest, -rest[-2:0:-1]]))
    series = np.zeros(wanted + 1, dtype=complex)
    shared = min(steps, wanted)
    series[:shared] = spectrum[:shared]
    line = np.linspace(profile[0], profile[-1], wanted + 1)
    smooth = np.fft.irfft(series, 2 * wanted)[: wanted + 1] * (wanted / steps)
    return line + smooth, steps * step_s / wanted
