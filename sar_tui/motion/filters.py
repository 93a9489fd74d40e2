"""Low-pass and notch filters for angular rates: a causal one, and zero-phase ones."""

import math
from collections.abc import Sequence

import numpy as np

from sar_tui.motion.samples import Floats

Vector = tuple[float, float, float]

NOTCH_HZ = 0.6
"""Standard deviation of the Gaussian notch."""
LOW_RATE = 4.0
"""Least number of samples in a period of the cutoff frequency."""
LEAST_RATE_HZ = 20.0
"""Lowest sample rate at which reaches are detected."""


def usable_cutoff(cutoff_hz: float, rate_hz: float) -> float:
    """Return the cutoff, or a quarter of the sample rate if that is lower.

    Raises ValueError for fewer than 20 samples per second, which give only a few samples of a fast reach.
    """
    if not rate_hz >= LEAST_RATE_HZ:
        raise ValueError(
            f"The sensor gives {rate_hz:.3g} samples a second; finding reaches takes at least {LEAST_RATE_HZ:g}: "
            "set it to a shorter data interval."
        )
    return min(cutoff_hz, rate_hz / LOW_RATE)


class Lowpass:
    """A causal second-order Butterworth low-pass of three axes.

    The coefficients come from the analogue filter by the bilinear transform with its frequency pre-warped (Oppenheim &
    Schafer, Discrete-Time Signal Processing, 7.2.2). It starts settled at its first input, so a constant bias causes no
    transient.

    Args:
        cutoff_hz: half-power frequency; below half of ``rate_hz``.
        rate_hz: samples per second.
    """

    def __init__(self, cutoff_hz: float, rate_hz: float) -> None:
        warped = math.tan(math.pi * cutoff_hz / rate_hz)
        norm = 1.0 + math.sqrt(2.0) * warped + warped * warped
        self._b = warped * warped / norm
        self._a1 = 2.0 * (warped * warped - 1.0) / norm
        self._a2 = (1.0 - math.sqrt(2.0) * warped + warped * warped) / norm
        self._state: tuple[float, ...] | None = None

    def filter(self, inputs: Sequence[Vector]) -> list[Vector]:
        """Return the next outputs (transposed direct form II). The axes are written out: a loop takes twice as long."""
        if not inputs:
            return []
        b, twice_b, a1, a2 = self._b, 2.0 * self._b, self._a1, self._a2
        if self._state is None:
            self._state = (*(x * (1.0 - b) for x in inputs[0]), *(x * (b - a2) for x in inputs[0]))
        r0, r1, r2, s0, s1, s2 = self._state
        outputs = []
        for x0, x1, x2 in inputs:
            y0, y1, y2 = b * x0 + r0, b * x1 + r1, b * x2 + r2
            outputs.append((y0, y1, y2))
            r0, r1, r2 = twice_b * x0 - a1 * y0 + s0, twice_b * x1 - a1 * y1 + s1, twice_b * x2 - a1 * y2 + s2
            s0, s1, s2 = b * x0 - a2 * y0, b * x1 - a2 * y1, b * x2 - a2 * y2
        self._state = r0, r1, r2, s0, s1, s2
        return outputs


def smooth(x: Floats, rate_hz: float, cutoff_hz: float, notch_hz: float | None = None) -> Floats:
    """Return a recording without frequencies above ``cutoff_hz``, and without delay.

    Equivalent to a second-order Butterworth low-pass run forwards and backwards: gain 1 / (1 + (f / cutoff)⁴), applied
    to the spectrum. The ends are padded with their mirror image, so that a bias makes no step there.

    Args:
        x: shape (n, k), n of at least 2.
        rate_hz: samples per second.
        cutoff_hz: half-amplitude frequency.
        notch_hz: centre of a Gaussian notch of standard deviation ``NOTCH_HZ``; None for none.
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
