"""The single-axis detector. It copes with bias, noise, tremor, pauses and any orientation of the
sensor.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.arrays import changes, lengths, percentile, principal_axis
from sar_tui.motion.boundaries import checked, edges, stretches
from sar_tui.motion.filters import smooth, usable_cutoff
from sar_tui.motion.reach import OUTWARDS, Bounds, Detected, Hand
from sar_tui.motion.rest import SLOW_HZ, Grid, Rest, even
from sar_tui.motion.samples import Floats, Recording

CALM_HZ = 5.0
"""Cutoff of the stronger smoothing, in which submovements are told apart."""
MARGIN_S = 1.0
"""Time around a stretch of movement in which a reach may begin and end."""
ACROSS = math.cos(math.radians(80))
"""An axis more than 80° from z does not show the direction of a reach: its first phase is then the
way out.
"""
ADJACENT_S = 0.2
"""Longest pause after which a small movement still belongs to its neighbour."""
TINY_RAD = 0.02
"""Smaller movements are ignored."""
UNEVEN = 4.0
"""Largest ratio of the angles out and back in a reach."""
UNPAIRED = 10.0
"""Cost of a phase without a partner: more than that of any possible pair."""


class Phase(NamedTuple):
    """Movement in one direction, from sample ``first`` to before ``last``; ``angle`` in rad,
    signed.
    """

    first: int
    last: int
    angle: float


class SingleAxisParameters(msgspec.Struct, frozen=True, kw_only=True):
    """Definitions of movement and of a reach.

    Args:
        cutoff_hz: cutoff of the low-pass (second-order Butterworth).
        rest_s: duration of stillness that counts as rest; it gives the sensor's bias and noise.
        begin_rad_s: a movement exceeds this; the limit is higher if the hand is not quiet at rest.
        end_rad_s: a movement lasts while it is faster than this.
        least_rad: smallest angle of the way out and of the way back; a twitch is smaller.
        shortest_s: shortest duration of the way out and of the way back.
        pause_s: a shorter pause between movements in the same direction does not divide a phase.
        dwell_s: the longest rest at the target within a reach.
        longest_s: longest reach; a longer one is cut off.
    """

    cutoff_hz: float = 8.0
    rest_s: float = 1.0
    begin_rad_s: float = 0.1
    end_rad_s: float = 0.05
    least_rad: float = 0.1
    shortest_s: float = 0.25
    pause_s: float = 0.5
    dwell_s: float = 2.0
    longest_s: float = 15.0


class _Motion(NamedTuple):
    """A recording without its bias, smoothed strongly to find phases, and lightly to time them."""

    grid: Grid
    slow: Floats
    light: Floats
    rest: Rest
    begin: float
    end: float


def find(
    recording: Recording,
    parameters: SingleAxisParameters | None = None,
    hand: Hand = "right",
    grid: Grid | None = None,
) -> Detected:
    """Find the reaches in a whole recording.

    Rest gives the bias, the noise and the tremor's frequency. With these removed, phases of
    movement are found in the rate below 2.5 Hz about their principal axis; two that are opposite
    and alike are a reach. Its boundaries come from the rate below ``cutoff_hz``.

    Flags: ``no_rest`` (no rest before it: its bias is a guess), ``gap`` (over 100 ms of samples are
    missing in it), ``cut`` (the recording begins or ends in it), ``timed_out``, ``reversed`` (out
    is not the usual way for this hand), ``low_rate`` (too few samples per second for ``cutoff_hz``:
    it was lowered).

    ``grid`` is the recording's even grid, if it is known. Raises ValueError for fewer than 20
    samples per second.
    """
    parameters = parameters or SingleAxisParameters()
    grid = grid or even(recording)
    if len(grid.time_s) < 2:
        return Detected(grid.time_s, grid.rate, grid.rate_hz, ())
    cutoff = usable_cutoff(parameters.cutoff_hz, grid.rate_hz)
    rest, rate, spectrum = grid.unbiased(parameters.rest_s)
    slow = spectrum.below(SLOW_HZ, rest.tremor_hz)
    speed = lengths(slow)
    floor = percentile(speed[rest.still], 99)
    motion = _Motion(
        grid=grid,
        slow=slow,
        light=spectrum.below(cutoff, rest.tremor_hz),
        rest=rest,
        begin=max(parameters.begin_rad_s, 2.0 * floor),
        end=max(parameters.end_rad_s, 1.2 * floor),
    )
    reaches = tuple(
        reach
        for group in stretches(speed > motion.begin, parameters.dwell_s * grid.rate_hz)
        for reach in _reaches(motion, group, parameters, hand)
    )
    return Detected(grid.time_s, rate, grid.rate_hz, reaches, rest.tremor_hz, spectrum=spectrum)


def _reaches(
    motion: _Motion, group: slice, parameters: SingleAxisParameters, hand: Hand
) -> Iterator[Bounds]:
    """Yield the reaches in one stretch of movement, about its principal axis."""
    rate_hz = motion.grid.rate_hz
    axis = principal_axis(motion.slow[group])
    sided = abs(axis[2]) > ACROSS
    if sided:
        axis = axis * math.copysign(1.0, axis[2] * OUTWARDS[hand])
    margin = round(MARGIN_S * rate_hz)
    around = slice(max(0, group.start - margin), group.stop + margin)
    time, slow, light = (
        motion.grid.time_s[around],
        motion.slow[around] @ axis,
        motion.light[around] @ axis,
    )
    calm = smooth(light[:, None], rate_hz, CALM_HZ)[:, 0]
    floor = percentile(np.abs(motion.light[motion.rest.still] @ axis), 95)
    found = phases(
        slow,
        rate_hz,
        begin=motion.begin,
        end=motion.end,
        least_rad=parameters.least_rad,
        shortest_s=parameters.shortest_s,
        pause_s=parameters.pause_s,
    )
    for out, back in pairs(found, rate_hz, parameters.dwell_s):
        sign = math.copysign(1.0, out.angle)
        onset, arrival = edges(time, sign * light, sign * calm, out.first, out.last, margin, floor)
        departure, end = edges(
            time, -sign * light, -sign * calm, back.first, back.last, margin, floor
        )
        if min(arrival - onset, end - departure) < parameters.shortest_s:
            continue
        x, y, z = (sign * axis).tolist()
        bounds = Bounds(
            onset_s=max(onset, float(time[0])),
            arrival_s=arrival,
            departure_s=departure,
            end_s=min(end, float(time[-1])),
            axis=(x, y, z),
            flags=("reversed",) if sided and sign < 0 else (),
        )
        is_cut = out.first + around.start == 0 or back.last + around.start == len(
            motion.grid.time_s
        )
        yield checked(
            bounds,
            motion.grid,
            motion.rest,
            is_cut=is_cut,
            longest_s=parameters.longest_s,
            cutoff_hz=parameters.cutoff_hz,
        )


def phases(
    turning: Floats,
    rate_hz: float,
    *,
    begin: float,
    end: float,
    least_rad: float,
    shortest_s: float,
    pause_s: float,
) -> list[Phase]:
    """Return the phases in a smooth angular rate about one axis.

    Args:
        turning: shape (n,), rad/s.
        rate_hz: samples per second.
        begin: a movement exceeds this, rad/s.
        end: it lasts while it is above this, rad/s.
        least_rad: smallest angle of a phase.
        shortest_s: shortest duration of a phase.
        pause_s: movements in the same direction with a shorter pause between them are one phase;
            one of less than ``least_rad`` belongs to a neighbour only within ``ADJACENT_S``.
    """
    found: list[Phase] = []
    for lobe in _lobes(turning, rate_hz, begin, end):
        before = found[-1] if found else None
        if before and before.angle * lobe.angle > 0:
            large = min(abs(before.angle), abs(lobe.angle)) >= least_rad
            if lobe.first - before.last < (pause_s if large else ADJACENT_S) * rate_hz:
                found[-1] = Phase(before.first, lobe.last, before.angle + lobe.angle)
                continue
        found.append(lobe)
    shortest = shortest_s * rate_hz
    return [
        phase
        for phase in found
        if abs(phase.angle) >= least_rad and phase.last - phase.first >= shortest
    ]


def _lobes(turning: Floats, rate_hz: float, begin: float, end: float) -> list[Phase]:
    """Return stretches of movement in one direction, except the smallest."""
    side = np.where(np.abs(turning) > end, np.sign(turning), 0.0)
    edges = changes(side)
    found = []
    for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        lobe = turning[first:last]
        angle = float(lobe.sum()) / rate_hz
        if abs(angle) > TINY_RAD and np.abs(lobe).max() > begin:
            found.append(Phase(first, last, angle))
    return found


def pairs(found: list[Phase], rate_hz: float, dwell_s: float) -> list[tuple[Phase, Phase]]:
    """Return the pairs of phases that are a reach: opposite, of similar angle, with a short rest
    between them.

    The pairing has as many reaches as possible and, among those, the best fit (dynamic programming
    over the phases).

    Args:
        found: in order of time.
        rate_hz: samples per second.
        dwell_s: the longest rest at the target.
    """
    best: list[tuple[float, list[tuple[Phase, Phase]]]] = [(0.0, [])]
    for index, phase in enumerate(found):
        alone = (best[-1][0] + UNPAIRED, best[-1][1])
        misfit = _misfit(found[index - 1], phase, rate_hz, dwell_s) if index else math.inf
        together = (
            (best[-2][0] + misfit, [*best[-2][1], (found[index - 1], phase)]) if index else alone
        )
        best.append(min(alone, together, key=lambda option: option[0]))
    return best[-1][1]


def _misfit(out: Phase, back: Phase, rate_hz: float, dwell_s: float) -> float:
    """Return how badly two phases fit as a reach; infinite if they cannot be one."""
    rest_s = (back.first - out.last) / rate_hz
    uneven = abs(math.log(abs(out.angle / back.angle)))
    possible = out.angle * back.angle < 0 and rest_s <= dwell_s and uneven < math.log(UNEVEN)
    return uneven + rest_s if possible else math.inf
