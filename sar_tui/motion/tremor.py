"""Tremor in an angular rate: its share of a movement, and its amplitude.

None means that there is no result: the stretch is too short, or a sample is not finite.
"""

import math

import numpy as np
import numpy.typing as npt

from sar_tui.motion.filters import hann
from sar_tui.motion.rest import TREMOR_HZ
from sar_tui.motion.samples import Floats
from sar_tui.motion.vectors import mean_of

Band = tuple[float, float]

ACTION_HZ: Band = (6.0, 12.0)
"""Tremor in movement, above most of the movement itself; at rest all of `rest.TREMOR_HZ` is
tremor.
"""

_SHORTEST_S = 1.0
_PADDING = 4


def tremor_index(rate: Floats, rate_hz: float) -> float | None:
    """Return the share of 3-12 Hz in the power of movement up to 12 Hz, 0 to 1, all three axes
    together.

    Parkinsonian tremor lies at 3-8 Hz and essential tremor at 4-12 Hz (Luft et al. 2019, Sensors
    19:4301), voluntary movement mostly below; power in the band against power below it separates
    persons with essential tremor from others (Ali et al. 2022, Sci Rep 12:5242, of acceleration).
    The mean of each axis (the gyroscope's bias) is removed, and a Hann window keeps a movement that
    was cut off from leaking into the band. A fast movement has power of its own there: compare like
    with like. Needs a second of samples, at 24 per second or more.

    Args:
        rate: angular rate, shape (n, 3), rad/s.
        rate_hz: samples per second.
    """
    return tremor_in_movement(rate, rate_hz)[0]


def tremor_in_movement(rate: Floats, rate_hz: float) -> tuple[float | None, float | None]:
    """Return what `tremor_index` does, and the amplitude in ``ACTION_HZ`` as `tremor_amplitude`
    does.

    Both come from one Fourier transform: every fourth frequency of the padded one is one of the
    other.
    """
    low, high = TREMOR_HZ
    if rate_hz < 2 * high or len(rate) < _SHORTEST_S * rate_hz or not np.isfinite(rate).all():
        return None, None
    moving = rate - mean_of(rate)
    largest = float(np.abs(moving).max())
    if largest <= 1e-12 * np.abs(rate).max():
        return None, 0.0
    size, window = len(rate) * _PADDING, hann(len(rate))
    power = np.sum(
        np.abs(np.fft.rfft(moving / largest * window[:, np.newaxis], size, axis=0)) ** 2, axis=1
    )
    frequency = np.fft.rfftfreq(size, 1.0 / rate_hz)
    action = power[::_PADDING][_inside(frequency[::_PADDING], ACTION_HZ)]
    amplitude = _amplitude(action, largest, window)
    all_power = float(power[frequency <= high].sum())
    if not all_power > 0:
        return None, amplitude
    return float(power[(frequency >= low) & (frequency <= high)].sum()) / all_power, amplitude


def tremor_amplitude(rate: Floats, rate_hz: float, band_hz: Band) -> float | None:
    """Return the amplitude in rad/s of the oscillation in a band of frequencies: A for A sin(2πft)
    about one axis.

    It is that of all three axes together, under a Hann window and without each axis' mean. A fast
    movement has some in the band itself. Needs a second of samples, two or more per period of the
    highest frequency.

    Args:
        rate: angular rate, shape (n, 3), rad/s.
        rate_hz: samples per second.
        band_hz: lowest and highest frequency.
    """
    if rate_hz < 2 * band_hz[1] or len(rate) < _SHORTEST_S * rate_hz or not np.isfinite(rate).all():
        return None
    moving = rate - mean_of(rate)
    largest = float(np.abs(moving).max())
    if not largest:
        return 0.0
    window = hann(len(rate))
    power = np.sum(
        np.abs(np.fft.rfft(moving / largest * window[:, np.newaxis], axis=0)) ** 2, axis=1
    )
    return _amplitude(
        power[_inside(np.fft.rfftfreq(len(rate), 1.0 / rate_hz), band_hz)], largest, window
    )


def _inside(frequency: Floats, band_hz: Band) -> npt.NDArray[np.bool_]:
    low, high = band_hz
    inside: npt.NDArray[np.bool_] = (frequency >= low) & (frequency <= high)
    return inside


def _amplitude(power: Floats, largest: float, window: Floats) -> float:
    """Return the amplitude of an oscillation from its power in a spectrum of values up to 1 under a
    window.
    """
    return 2.0 * largest * math.sqrt(float(power.sum()) / (len(window) * float(np.sum(window**2))))
