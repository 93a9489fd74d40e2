"""Measures of a reach with known boundaries, and of tremor at rest and in movement."""

import math
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.arrays import lengths, mean_of, sums_of_axes
from sar_tui.motion.faults import is_clipped
from sar_tui.motion.filters import Spectrum, hann
from sar_tui.motion.quaternions import angle, conjugate, integrate, rotate
from sar_tui.motion.reach import Bounds, Detected, Reach
from sar_tui.motion.rest import TREMOR_HZ
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.smoothness import ldlj, movement_units, sparc

MEASURES_VERSION = 2
"""Version of the measures of a reach, stored with each."""
"""1: peaks are sought up to the turn, and only the measures exist that sessions of rules 1 to 4
stored.
"""
PEAKS_HZ = 15.0
"""Cutoff of the smoothing for peaks and smoothness."""
SHORTEST_WAY_S = 0.18
"""A shorter way out or back has no smoothness: the spectrum of even a minimum-jerk movement reaches
beyond the 10 Hz of SPARC, which would call it smoother than one that takes longer.
"""
TURN_WITHIN_S = 0.15
"""Largest distance of a turn without rest from where the detector saw it."""
REST_S = (1.2, 0.1)
"""From when to when before the onset the hand's rest is measured."""
SHORTEST_REST_S = 0.25
REST_PARTS = 4
STILL_RAD = 0.05
"""Largest turn of a hand at rest from one part of that time to another; in the mean of each, tremor
cancels.
"""
Band = tuple[float, float]
ACTION_HZ: Band = (6.0, 12.0)
"""Tremor in movement, above most of the movement itself; at rest all of `rest.TREMOR_HZ` is
tremor.
"""
_SHORTEST_S = 1.0
_PADDING = 4


class _Rates(NamedTuple):
    """The angular rate of a whole recording, shape (n, 3), rad/s, and for ``Detected.by_norm`` its
    norm, shape (n,).
    """

    rate: Floats
    norm: Floats | None

    @classmethod
    def of(cls, rate: Floats, by_norm: bool) -> "_Rates":
        return cls(rate, lengths(rate) if by_norm else None)

    def about(self, axis: Floats, part: slice) -> tuple[Floats, Floats]:
        """Return the rate in a part: positive on a way out and negative on a way back, to be used
        on each way.
        """
        if self.norm is not None:
            return self.norm[part], -self.norm[part]
        turning = self.rate[part] @ axis
        return turning, turning


_FINGERS = 1
"""The sensor's axis along fingers and forearm: y."""


class Turned(NamedTuple):
    """Angles in degrees; straightness 0 to 1. None: not measured, or not defined."""

    excursion_deg: float
    straightness: float | None
    return_error_deg: float | None
    inclination_rest_deg: float | None
    inclination_target_deg: float | None


def measure(found: Detected, recording: Recording) -> tuple[Reach, ...]:
    """Measure every reach that was found. The recording's flags, except that of gaps, are added to
    each reach's own.

    Peaks and smoothness use the rate about the reach's axis, or its norm (``Detected.by_norm``),
    smoothed lightly (15 Hz, zero phase: a fast reach's peak loses less than 1 %). Movement units
    and the path of the orientation are without the tremor found at rest.
    """
    if not found.reaches:
        return ()
    cutoff = min(PEAKS_HZ, found.rate_hz / 4)
    spectrum = found.spectrum or Spectrum(found.rate, found.rate_hz)
    light = _Rates.of(spectrum.below(cutoff), found.by_norm)
    calm = light
    if found.tremor_hz is not None:
        calm = _Rates.of(spectrum.below(cutoff, found.tremor_hz), found.by_norm)
    flags = tuple(flag for flag in recording.flags if flag != "gap")
    reaches = []
    for bounds in found.reaches:
        own_flags = (*flags, *_clipped(bounds, recording))
        reach = _measured(found, light, calm, _ordered(bounds), own_flags)
        reaches.append(_extended(reach, found, calm.rate, recording))
    return tuple(reaches)


def _clipped(bounds: Bounds, recording: Recording) -> tuple[str, ...]:
    """Return the flag of a reach in which the sensor was beyond its range, whether or not it said
    so.
    """
    inside = _between(recording.time_s, bounds.onset_s, bounds.end_s)
    return ("clipped",) if is_clipped(recording.rate[inside]) else ()


def _ordered(bounds: Bounds) -> Bounds:
    """Return the boundaries such that the reach ends after its onset, and all others lie
    between.
    """
    end_s = max(bounds.onset_s, bounds.end_s)
    arrival_s, departure_s = (
        min(max(at_s, bounds.onset_s), end_s) for at_s in (bounds.arrival_s, bounds.departure_s)
    )
    return msgspec.structs.replace(
        bounds, end_s=end_s, arrival_s=arrival_s, departure_s=departure_s
    )


def _measured(
    found: Detected,
    light: _Rates,
    calm: _Rates,
    bounds: Bounds,
    flags: tuple[str, ...],
) -> Reach:
    part = _between(found.time_s, bounds.onset_s, bounds.end_s)
    time, rate_hz, axis = found.time_s[part], found.rate_hz, np.asarray(bounds.axis)
    turn_s = _turn(time, light.rate[part] @ axis, bounds)
    arrival_s, departure_s = min(bounds.arrival_s, turn_s), max(bounds.departure_s, turn_s)
    if bounds.arrival_s >= bounds.departure_s:
        middle_s = (bounds.arrival_s + bounds.departure_s) / 2
        turn_s = turn_s if abs(turn_s - middle_s) <= TURN_WITHIN_S else middle_s
        arrival_s = departure_s = turn_s
    leaves = (time >= bounds.onset_s) & (time <= arrival_s)
    returns = (time >= departure_s) & (time <= bounds.end_s)
    (leaving, returning), (calm_leaving, calm_returning) = (
        light.about(axis, part),
        calm.about(axis, part),
    )
    way_out, way_back = np.maximum(leaving[leaves], 0.0), np.maximum(-returning[returns], 0.0)
    out_s, back_s = arrival_s - bounds.onset_s, bounds.end_s - departure_s
    out, back = leaving[leaves], returning[returns]
    time_to_peak_s = (
        min(out_s, float(time[leaves][out.argmax()]) - bounds.onset_s) if len(out) else 0.0
    )
    is_out_long, is_back_long = out_s >= SHORTEST_WAY_S, back_s >= SHORTEST_WAY_S
    return Reach(
        onset_s=bounds.onset_s,
        turn_s=turn_s,
        end_s=bounds.end_s,
        reach_time_s=bounds.end_s - bounds.onset_s,
        out_s=out_s,
        back_s=back_s,
        dwell_s=departure_s - arrival_s,
        peak_extension_rad_s=max(0.0, float(out.max(initial=0.0))),
        peak_return_rad_s=min(0.0, float(back.min(initial=0.0))),
        time_to_peak_s=time_to_peak_s,
        movement_units_out=movement_units(np.maximum(calm_leaving[leaves], 0.0), rate_hz),
        movement_units_back=movement_units(np.maximum(-calm_returning[returns], 0.0), rate_hz),
        sparc_out=sparc(way_out, rate_hz) if is_out_long else None,
        sparc_back=sparc(way_back, rate_hz) if is_back_long else None,
        ldlj_out=ldlj(way_out, rate_hz) if is_out_long else None,
        ldlj_back=ldlj(way_back, rate_hz) if is_back_long else None,
        tremor_index=None,
        confidence=bounds.confidence,
        flags=tuple(dict.fromkeys((*bounds.flags, *flags))),
    )


def _turn(time: Floats, turning: Floats, bounds: Bounds) -> float:
    """Return the middle of the rest at the target; without one, the nearest change of the rate's
    sign.
    """
    middle = (bounds.arrival_s + bounds.departure_s) / 2
    if bounds.departure_s > bounds.arrival_s or bounds.arrival_s >= bounds.end_s:
        return middle
    inside = ((time >= bounds.onset_s) & (time <= bounds.end_s)).nonzero()[0]
    falls = inside[:-1][(turning[inside[:-1]] > 0) & (turning[inside[1:]] <= 0)]
    return float(time[falls[np.abs(time[falls] - middle).argmin()]]) if len(falls) else middle


def _between(time: Floats, from_s: float, to_s: float) -> slice:
    """Return the samples between two times, both included."""
    return slice(int(np.searchsorted(time, from_s)), int(np.searchsorted(time, to_s, side="right")))


def _extended(reach: Reach, found: Detected, calm: Floats, recording: Recording) -> Reach:
    """Return a reach with its measures of orientation and of tremor."""
    time, rate_hz = found.time_s, found.rate_hz
    inside = _between(time, reach.onset_s, reach.end_s)
    most = inside.stop - inside.start - 1
    if most < 0:
        return reach
    moments = (reach.onset_s + reach.out_s, reach.turn_s, reach.end_s - reach.back_s)
    arrival, target, departure = np.minimum(np.searchsorted(time[inside], moments), most).tolist()
    rest = _rest(found, reach.onset_s)
    up = None if rest is None else _up(recording, *rest)
    before = found.rate[:0] if rest is None else found.rate[_between(time, *rest)]
    index, action = tremor_in_movement(found.rate[inside], rate_hz)
    return msgspec.structs.replace(
        reach,
        **turned(calm[inside], rate_hz, arrival, target, departure, up)._asdict(),
        tremor_rest_hz=found.tremor_hz,
        tremor_rest_rad_s=tremor_amplitude(before, rate_hz, TREMOR_HZ),
        tremor_index=index,
        tremor_action_rad_s=action,
    )


def _rest(found: Detected, onset_s: float) -> tuple[float, float] | None:
    """Return from when to when the hand rested right before the onset; None if it did not, or
    nothing was recorded.
    """
    from_s, to_s = (onset_s - before_s for before_s in REST_S)
    rate = found.rate[_between(found.time_s, from_s, to_s)]
    if len(rate) < SHORTEST_REST_S * found.rate_hz:
        return None
    course = np.cumsum(rate, axis=0) / found.rate_hz
    parts = [mean_of(part) for part in np.array_split(course, REST_PARTS)]
    return (from_s, to_s) if np.ptp(parts, axis=0).max() < STILL_RAD else None


def _up(recording: Recording, from_s: float, to_s: float) -> Floats | None:
    """Return the mean acceleration of a rest, which points upwards; None if it was not measured."""
    if recording.acceleration is None:
        return None
    felt = recording.acceleration[_between(recording.time_s, from_s, to_s)]
    mean: Floats = felt[np.isfinite(felt).all(axis=1)].sum(axis=0)
    return mean if np.linalg.norm(mean) > 0 else None


def turned(
    rate: Floats, rate_hz: float, arrival: int, target: int, departure: int, up: Floats | None
) -> Turned:
    """Return the measures of a reach.

    The angular rate is integrated from the onset on. Gravity is not followed during the reach,
    where the accelerometer feels the hand's own acceleration: over the few seconds of a reach, the
    gyroscope alone errs less.

    Args:
        rate: angular rate without bias from onset to end, shape (n, 3), rad/s, with n of at least
            1.
        rate_hz: samples per second.
        arrival, target, departure: index of the sample at which the hand arrives, is at the target,
            and leaves it. Without a way back, the hand leaves with the last sample.
        up: the direction of up at the onset in the sensor's axes, of any length, shape (3,); None
            if not known.
    """
    orientation = integrate(rate, 1.0 / rate_hz)
    angles = np.degrees(angle(orientation))
    speed = np.degrees(lengths(rate[: arrival + 1]))
    path = float((speed[1:] + speed[:-1]).sum()) / (2.0 * rate_hz)
    return Turned(
        excursion_deg=float(angles[: departure + 1].max()),
        straightness=min(1.0, float(angles[arrival]) / path) if path > 0 else None,
        return_error_deg=float(angles[-1]) if departure < len(rate) - 1 else None,
        inclination_rest_deg=None if up is None else _inclination(up),
        inclination_target_deg=None
        if up is None
        else _inclination(rotate(conjugate(orientation[target]), up)),
    )


def _inclination(up: Floats) -> float:
    """Return the angle of the fingers' axis above the horizontal, in degrees."""
    return math.degrees(math.asin(float(up[_FINGERS]) / float(np.linalg.norm(up))))


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
    power = sums_of_axes(
        np.abs(np.fft.rfft(moving / largest * window[:, np.newaxis], size, axis=0)) ** 2
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
    power = sums_of_axes(np.abs(np.fft.rfft(moving / largest * window[:, np.newaxis], axis=0)) ** 2)
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
