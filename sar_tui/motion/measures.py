"""Measures of a reach with known boundaries."""

import numpy as np

from sar_tui.motion.filters import Spectrum
from sar_tui.motion.reach import Reach
from sar_tui.motion.reach_bounds import Bounds, Detected
from sar_tui.motion.samples import Floats
from sar_tui.motion.smoothness import ldlj, movement_units, sparc, tremor_index

PEAKS_HZ = 15.0
"""Cutoff of the smoothing for peaks and smoothness."""


def measure(found: Detected, flags: tuple[str, ...] = ()) -> tuple[Reach, ...]:
    """Measure every reach that was found. ``flags`` of the recording are added to each reach's own.

    Peaks and smoothness use the rate about the reach's axis, smoothed lightly (15 Hz, zero phase: a fast reach's
    peak loses less than 1 %). Movement units are counted without the tremor found at rest.
    """
    if not found.reaches:
        return ()
    cutoff = min(PEAKS_HZ, found.rate_hz / 4)
    spectrum = Spectrum(found.rate, found.rate_hz)
    light = spectrum.below(cutoff)
    calm = light if found.tremor_hz is None else spectrum.below(cutoff, found.tremor_hz)
    return tuple(
        _measured(found, light @ np.asarray(bounds.axis), calm @ np.asarray(bounds.axis), bounds, flags)
        for bounds in found.reaches
    )


def _measured(found: Detected, turning: Floats, calm: Floats, bounds: Bounds, flags: tuple[str, ...]) -> Reach:
    time, rate_hz = found.time_s, found.rate_hz
    turn_s = _turn(time, turning, bounds)
    arrival_s, departure_s = min(bounds.arrival_s, turn_s), max(bounds.departure_s, turn_s)
    out = turning[(time >= bounds.onset_s) & (time <= turn_s)]
    back = turning[(time > turn_s) & (time <= bounds.end_s)]
    leaves = (time >= bounds.onset_s) & (time <= arrival_s)
    returns = (time >= departure_s) & (time <= bounds.end_s)
    way_out, way_back = np.maximum(turning[leaves], 0.0), np.maximum(-turning[returns], 0.0)
    whole = (time >= bounds.onset_s) & (time <= bounds.end_s)
    return Reach(
        onset_s=bounds.onset_s,
        turn_s=turn_s,
        end_s=bounds.end_s,
        reach_time_s=bounds.end_s - bounds.onset_s,
        out_s=arrival_s - bounds.onset_s,
        back_s=bounds.end_s - departure_s,
        dwell_s=departure_s - arrival_s,
        peak_extension_rad_s=max(0.0, float(out.max(initial=0.0))),
        peak_return_rad_s=min(0.0, float(back.min(initial=0.0))),
        time_to_peak_s=float(out.argmax()) / rate_hz if len(out) else 0.0,
        movement_units_out=movement_units(np.maximum(calm[leaves], 0.0), rate_hz),
        movement_units_back=movement_units(np.maximum(-calm[returns], 0.0), rate_hz),
        sparc_out=sparc(way_out, rate_hz),
        sparc_back=sparc(way_back, rate_hz),
        ldlj_out=ldlj(way_out, rate_hz),
        ldlj_back=ldlj(way_back, rate_hz),
        tremor_index=tremor_index(found.rate[whole], rate_hz),
        flags=tuple(dict.fromkeys((*bounds.flags, *flags))),
    )


def _turn(time: Floats, turning: Floats, bounds: Bounds) -> float:
    """Return the middle of the rest at the target; without one, the nearest change of the rate's sign."""
    middle = (bounds.arrival_s + bounds.departure_s) / 2
    if bounds.departure_s > bounds.arrival_s or bounds.arrival_s >= bounds.end_s:
        return middle
    inside = np.flatnonzero((time >= bounds.onset_s) & (time <= bounds.end_s))
    falls = inside[:-1][(turning[inside[:-1]] > 0) & (turning[inside[1:]] <= 0)]
    return float(time[falls[np.abs(time[falls] - middle).argmin()]]) if len(falls) else middle
