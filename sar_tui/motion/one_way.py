"""Movements from a rest in one orientation to a rest in another, about whatever axes: reaches
without a way back.
"""

from itertools import pairwise

from sar_tui.motion import quaternions
from sar_tui.motion.arrays import lengths, percentile
from sar_tui.motion.boundaries import checked, first_peak, onset, stretches
from sar_tui.motion.filters import usable_cutoff
from sar_tui.motion.orientation import (
    CALM_HZ,
    MARGIN_S,
    MOVING,
    NOISE,
    SUBMOVEMENT,
    OrientationParameters,
)
from sar_tui.motion.reach import Bounds, Detected
from sar_tui.motion.rest import SLOW_HZ, even
from sar_tui.motion.samples import Recording


def find(recording: Recording, parameters: OrientationParameters | None = None) -> Detected:
    """Find the movements of a whole recording that turn the hand and leave it turned. Each is all
    way out.

    A rest of ``pause_s`` or more divides movements, so a way back after such a rest is a movement
    of its own. One that comes back to ``return_share`` of its largest angle, or less, is left out.

    Flags and errors are as in ``single_axis.find``, but for ``reversed``.
    """
    parameters = parameters or OrientationParameters()
    grid = even(recording)
    if len(grid.time_s) < 2:
        return Detected(grid.time_s, grid.rate, grid.rate_hz, (), by_norm=True)
    cutoff = usable_cutoff(parameters.cutoff_hz, grid.rate_hz)
    rest, rate, spectrum = grid.unbiased(parameters.rest_s)
    slow, light, calm = (
        lengths(spectrum.below(hz, rest.tremor_hz))
        for hz in (SLOW_HZ, cutoff, min(CALM_HZ, cutoff))
    )
    at_rest = percentile(slow[rest.still], 99)
    begin, end = (
        max(parameters.begin_rad_s, 2.0 * at_rest),
        max(parameters.end_rad_s, 1.2 * at_rest),
    )
    noise, margin = NOISE * percentile(light[rest.still], 50), round(MARGIN_S * grid.rate_hz)
    movements = [
        part
        for part in stretches(slow > end, parameters.pause_s * grid.rate_hz)
        if slow[part].max() > begin
    ]
    limits = [
        0,
        *(round((one.stop + other.start) / 2) for one, other in pairwise(movements)),
        len(slow),
    ]
    found = []
    for part, (earliest, latest) in zip(movements, pairwise(limits), strict=True):
        first, last = max(earliest, part.start - margin), min(latest, part.stop + margin)
        orientation = quaternions.integrate(rate[first:last], 1.0 / grid.rate_hz)
        turned = quaternions.multiply(quaternions.conjugate(orientation[0]), orientation)
        angle = quaternions.angle(turned)
        if angle[-1] < parameters.least_rad or angle[-1] <= parameters.return_share * angle.max():
            continue
        level = MOVING * float(calm[part].max())
        rises = slice(first, part.start + first_peak(calm[part], SUBMOVEMENT) + 1)
        falls = slice(part.stop - 1 - first_peak(calm[part][::-1], SUBMOVEMENT), last)
        onset_s = max(
            onset(grid.time_s[rises], light[rises], noise, level), float(grid.time_s[first])
        )
        end_s = min(
            onset(grid.time_s[falls][::-1], light[falls][::-1], noise, level),
            float(grid.time_s[last - 1]),
        )
        if end_s - onset_s < parameters.shortest_s / 2:
            continue
        x, y, z = (quaternions.to_rotation(turned[-1]) / angle[-1]).tolist()
        bounds = Bounds(
            onset_s=onset_s, arrival_s=end_s, departure_s=end_s, end_s=end_s, axis=(x, y, z)
        )
        is_cut = part.start == 0 or part.stop == len(slow)
        found.append(
            checked(
                bounds,
                grid,
                rest,
                is_cut=is_cut,
                longest_s=parameters.longest_s,
                cutoff_hz=parameters.cutoff_hz,
            )
        )
    return Detected(
        grid.time_s,
        rate,
        grid.rate_hz,
        tuple(found),
        rest.tremor_hz,
        by_norm=True,
        spectrum=spectrum,
    )
