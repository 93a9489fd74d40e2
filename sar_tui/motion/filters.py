"""Low-pass and notch filters for angular rates: a causal one, and zero-phase ones."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sar_tui.motion.arrays import mean_of
from sar_tui.motion.samples import Floats

Vector = tuple[float, float, float]

NOTCH_HZ = 0.6
"""Standard deviation of the Gaussian notch."""
LOW_RATE = 4.0
"""Least number of samples in a period of the cutoff frequency."""
LEAST_RATE_HZ = 20.0
"""Lowest sample rate at which reaches are detected."""

_LARGEST_EXPONENT = 500.0
_LONGEST_STRETCH = 2048
_Complex = npt.NDArray[np.complex128]


def usable_cutoff(cutoff_hz: float, rate_hz: float) -> float:
    """Return the cutoff, or a quarter of the sample rate if that is lower.

    Raises TooSlow for fewer than 20 samples per second, which give only a few samples of a fast
    reach.
    """
    if not rate_hz >= LEAST_RATE_HZ:
        raise TooSlow(
            f"The sensor gives {rate_hz:.3g} samples a second; finding reaches takes at least "
            f"{LEAST_RATE_HZ:g}: set it to a shorter data interval."
        )
    return min(cutoff_hz, rate_hz / LOW_RATE)


class TooSlow(ValueError):
    """There are too few samples per second."""


class Lowpass:
    """A causal second-order Butterworth low-pass of three axes.

    It starts settled at its first input, so a constant bias causes no transient.

    Args:
        cutoff_hz: half-power frequency; below half of ``rate_hz``.
        rate_hz: samples per second.
    """

    def __init__(self, cutoff_hz: float, rate_hz: float) -> None:
        self._b, self._a1, self._a2 = _coefficients(rate_hz, cutoff_hz)
        self._state: tuple[float, ...] | None = None

    def filter(self, inputs: Sequence[Vector]) -> list[Vector]:
        """Return the next outputs (transposed direct form II). The axes are written out: a loop
        takes twice as long.
        """
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
            r0, r1, r2 = (
                twice_b * x0 - a1 * y0 + s0,
                twice_b * x1 - a1 * y1 + s1,
                twice_b * x2 - a1 * y2 + s2,
            )
            s0, s1, s2 = b * x0 - a2 * y0, b * x1 - a2 * y1, b * x2 - a2 * y2
        self._state = r0, r1, r2, s0, s1, s2
        return outputs


def lowpass(x: Floats, rate_hz: float, cutoff_hz: float) -> Floats:
    """Return what `Lowpass` gives for samples of shape (n, 3), n of at least 1, except for the last
    digits; faster.

    Its response is b·x[n] + 2 Re(c·w[n−1]) with w[n] = p·w[n−1] + x[n], p being a pole: a partial
    fraction expansion. w is pⁿ times a cumulative sum of x[n]·p⁻ⁿ, in stretches so short that p⁻ⁿ
    does not overflow.
    """
    b, weight, powers, inverse = _expansion(rate_hz, cutoff_hz)
    moved = x - x[0]  # it starts settled at its first input
    state = np.empty((len(x) + 1, x.shape[1]), dtype=complex)
    state[0] = 0.0
    for first in range(0, len(x), len(powers)):
        part = moved[first : first + len(powers)]
        summed = np.cumsum(part * inverse[: len(part)], axis=0) + state[first]
        np.multiply(summed, powers[: len(part)], out=state[first + 1 : first + 1 + len(part)])
    filtered: Floats = (weight * state[:-1]).real
    filtered += b * moved
    filtered += x[0]
    return filtered


@lru_cache(maxsize=16)
def _expansion(rate_hz: float, cutoff_hz: float) -> tuple[float, complex, _Complex, _Complex]:
    """Return b and 2c of `lowpass`, and p and 1/p to the powers 1, 2, …, of shape (m, 1)."""
    b, a1, a2 = _coefficients(rate_hz, cutoff_hz)
    pole = complex(-a1 / 2.0, math.sqrt(a2 - a1 * a1 / 4.0))
    weight = 2.0 * (b * (2.0 - a1) + b * (1.0 - a2) / pole) / (1.0 - pole.conjugate() / pole)
    length = min(_LONGEST_STRETCH, max(1, int(-_LARGEST_EXPONENT / math.log(abs(pole)))))
    exponents = np.arange(1, length + 1)[:, None] * np.log(pole)
    return b, weight, np.exp(exponents), np.exp(-exponents)


def _coefficients(rate_hz: float, cutoff_hz: float) -> tuple[float, float, float]:
    """Return the coefficients of a second-order Butterworth low-pass: b₀, which is also b₁ / 2 and
    b₂, a₁ and a₂.

    They come from the analogue filter by the bilinear transform with its frequency pre-warped
    (Oppenheim & Schafer, Discrete-Time Signal Processing, 7.2.2).
    """
    warped = math.tan(math.pi * cutoff_hz / rate_hz)
    norm = 1.0 + math.sqrt(2.0) * warped + warped * warped
    a1 = 2.0 * (warped * warped - 1.0) / norm
    return warped * warped / norm, a1, (1.0 - math.sqrt(2.0) * warped + warped * warped) / norm


@lru_cache(maxsize=16)
def hann(size: int) -> Floats:
    """Return a Hann window, shape (size,). Do not change it."""
    return np.hanning(size)


class Spectrum:
    """A recording's spectrum, from which it is smoothed in several ways.

    Equivalent to a second-order Butterworth low-pass run forwards and backwards: gain 1 / (1 + (f /
    cutoff)⁴), applied to the spectrum. The ends are padded with their mirror image, so that a bias
    makes no step there.

    Args:
        x: shape (n, k), n of at least 2.
        rate_hz: samples per second.
    """

    def __init__(self, x: Floats, rate_hz: float) -> None:
        self._length = len(x)
        self._rate_hz = rate_hz
        self._pad = pad = min(len(x) - 1, math.ceil(2.0 * rate_hz))
        self._mean = mean_of(x)
        mirrored = np.concatenate((x[pad:0:-1], x, x[-2 : -pad - 2 : -1])) - self._mean
        self._size = 1 << (len(mirrored) - 1).bit_length()
        self._spectrum = np.fft.rfft(mirrored, self._size, axis=0)
        self._below: dict[tuple[float, float | None], Floats] = {}

    def below(self, cutoff_hz: float, notch_hz: float | None = None) -> Floats:
        """Return the recording without frequencies above a cutoff, and without delay; arguments as
        for ``smooth``.

        The same array each time: do not change it.
        """
        if (cutoff_hz, notch_hz) in self._below:
            return self._below[cutoff_hz, notch_hz]
        gain = _gain(self._size, self._rate_hz, cutoff_hz, notch_hz)
        filtered = np.fft.irfft(self._spectrum * gain, self._size, axis=0)
        result: Floats = filtered[self._pad : self._pad + self._length] + self._mean
        self._below[cutoff_hz, notch_hz] = result
        return result


@lru_cache(maxsize=16)
def _gain(size: int, rate_hz: float, cutoff_hz: float, notch_hz: float | None) -> Floats:
    """Return the gain of each frequency of a spectrum of ``size`` samples, of shape (size / 2 + 1,
    1).
    """
    frequency = np.fft.rfftfreq(size, 1.0 / rate_hz)
    gain = 1.0 / (1.0 + (frequency / cutoff_hz) ** 4)
    if notch_hz is not None:
        gain *= 1.0 - np.exp(-0.5 * ((frequency - notch_hz) / NOTCH_HZ) ** 2)
    column: Floats = gain[:, None]
    return column


def smooth(x: Floats, rate_hz: float, cutoff_hz: float, notch_hz: float | None = None) -> Floats:
    """Return a recording without frequencies above ``cutoff_hz``, and without delay (see
    ``Spectrum``).

    Args:
        x: shape (n, k), n of at least 2.
        rate_hz: samples per second.
        cutoff_hz: half-amplitude frequency.
        notch_hz: centre of a Gaussian notch of standard deviation ``NOTCH_HZ``; None for none.
    """
    return Spectrum(x, rate_hz).below(cutoff_hz, notch_hz)
