"""Low-pass and notch filters for angular rates: one that runs live, and those that look both ways."""

import math

import numpy as np

from sar_tui.motion.samples import Floats

NOTCH_HZ = 0.6
LOW_RATE = 4.0
LEAST_RATE_HZ = 20.0


def usable_cutoff(cutoff_hz: float, rate_hz: float) -> float:
    """The cutoff, or a quarter of the sample rate where that is lower.

    Raises ValueError for fewer than 20 samples a second: a fast reach would be a handful of them.
    """
    if not rate_hz >= LEAST_RATE_HZ:
        raise ValueError(
            f"The sensor gives {rate_hz:.3g} samples a second; finding reaches takes at least {LEAST_RATE_HZ:g}: "
            "set it to a shorter data interval."
        )
    return min(cutoff_hz, rate_hz / LOW_RATE)


class Lowpass:
    """A causal Butterworth low-pass of second order, one number at a time.

    The coefficients come from the analogue filter by the bilinear transform with its frequency pre-warped (Oppenheim &
    Schafer, Discrete-Time Signal Processing, 7.2.2). It starts settled at its first input, so a constant bias makes no
    transient.

    Args:
        cutoff_hz: where half of the power is left; below half of ``rate_hz``.
        rate_hz: samples a second.
    """

    __slots__ = ("_a1", "_a2", "_b", "_s1", "_s2", "_started")

    def __init__(self, cutoff_hz: float, rate_hz: float) -> None:
        warped = math.tan(math.pi * cutoff_hz / rate_hz)
        norm = 1.0 + math.sqrt(2.0) * warped + warped * warped
        self._b = warped * warped / norm
        self._a1 = 2.0 * (warped * warped - 1.0) / norm
        self._a2 = (1.0 - math.sqrt(2.0) * warped + warped * warped) / norm
        self._s1 = self._s2 = 0.0
        self._started = False

    def __call__(self, x: float) -> float:
        """The next output (transposed direct form II)."""
        b = self._b
        if not self._started:
            self._s1, self._s2, self._started = x * (1.0 - b), x * (b - self._a2), True
        y = b * x + self._s1
        self._s1 = 2.0 * b * x - self._a1 * y + self._s2
        self._s2 = b * x - self._a2 * y
        return y


def smooth(x: Floats, rate_hz: float, cutoff_hz: float, notch_hz: float | None = None) -> Floats:
    """A recording without what is faster than ``cutoff_hz``, and without delay.

    The same as a second-order Butterworth low-pass run forwards and then backwards: gain 1 / (1 + (f / cutoff)⁴),
    applied to the spectrum. The ends are continued by their mirror image, so that a bias makes no edge.

    Args:
        x: shape (n, k), n of at least 2.
        rate_hz: samples a second.
        cutoff_hz: where half of the amplitude is left.
        notch_hz: a frequency to take out as well, with a bell of ``NOTCH_HZ`` (standard deviation) about it.
    """
    pad = min(len(x) - 1, math.ceil(2.0 * rate_hz))
    mean = x.mean(axis=0)
    mirrored = np.concatenate((x[pad:0:-1], x, x[-2 : -pad - 2 : -1])) - mean
    size = 1 << (len(mirrored) - 1).bit_length()
    frequency = np.fft.rfftfreq(size, 1.0 / rate_hz)
    gain = 1.0 / (1.0 + (frequency / cutoff_hz) ** 4)
    if notch_hz is not None:
        gain *= 1.0 - np.exp(-0.5 * ((frequency - notch_hz) / NOTCH_HZ) ** 2)
    filtered = np.fft.irfft(np.fft.rfft(mirrored, size, axis=0) * gain[:, None], size, axis=0)
    result: Floats = filtered[pad : pad + len(x)] + mean
    return result
