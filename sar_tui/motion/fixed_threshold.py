"""The fixed-threshold detector (thesis 4.2.2): the hand moves while it turns about z faster than a
threshold.
"""

import msgspec
import numpy as np

from sar_tui.motion.arrays import finite_only
from sar_tui.motion.reach import OUTWARDS, Bounds, Detected, Hand
from sar_tui.motion.rest import Grid, even
from sar_tui.motion.samples import Floats, Recording


class FixedThresholdParameters(msgspec.Struct, frozen=True, kw_only=True):
    """Parameters of the detector.

    Args:
        threshold_rad_s: the hand moves where the rate about z exceeds this, in either direction.
        still_ms: a reach is over when the rate then stays below for this long.
    """

    threshold_rad_s: float = 0.1
    still_ms: float = 800.0


def find(
    recording: Recording,
    parameters: FixedThresholdParameters | None = None,
    hand: Hand = "right",
    grid: Grid | None = None,
) -> Detected:
    """Find the reaches: every stretch of movement that a rest of ``still_ms`` follows. It ends
    where that rest begins.

    A last stretch without that rest is flagged ``endless``, and ends with the recording.
    ``reversed``, ``gap`` and ``grid`` are as in ``single_axis.find``.
    """
    parameters = parameters or FixedThresholdParameters()
    grid = grid or even(recording)
    if not len(grid.time_s):
        return Detected(grid.time_s, grid.rate, grid.rate_hz, ())
    time_s, rate = finite_only(recording.time_s, recording.rate)
    segments = _segments(time_s, np.abs(rate[:, 2]), parameters)
    reaches = tuple(
        _bounds(grid, segment, parameters.threshold_rad_s, hand) for segment in segments
    )
    return Detected(grid.time_s, grid.rate, grid.rate_hz, reaches)


def _segments(
    time_s: Floats, speed: Floats, parameters: FixedThresholdParameters
) -> list[tuple[float, float, bool]]:
    """Return onset, end and completeness of each stretch above the threshold; shorter rests are
    bridged.
    """
    above = (speed > parameters.threshold_rad_s).nonzero()[0]
    if not len(above):
        return []
    still_s = parameters.still_ms / 1000.0
    quiet = time_s[np.minimum(above + 1, len(time_s) - 1)]
    until = np.append(time_s[above[1:]], time_s[-1])
    ends = until - quiet >= still_s - 1e-9
    ends[:-1] &= np.diff(above) > 1
    last = ends.nonzero()[0]
    first = np.concatenate(([0], last + 1))
    segments = [
        (float(time_s[above[a]]), float(quiet[b]), True) for a, b in zip(first, last, strict=False)
    ]
    if first[-1] < len(above):
        segments.append((float(time_s[above[first[-1]]]), float(time_s[-1]), False))
    return segments


def _bounds(grid: Grid, segment: tuple[float, float, bool], threshold: float, hand: Hand) -> Bounds:
    """Return a stretch as a reach that turns where the rate about z changes sign; without that, all
    is the way out.
    """
    onset_s, end_s, ended = segment
    margin = 0.51 / grid.rate_hz
    inside = (grid.time_s >= onset_s - margin) & (grid.time_s <= end_s + margin)
    inside[-1] |= onset_s > grid.time_s[-1]  # a last sample may lie beyond the grid
    time, turning = grid.time_s[inside], grid.rate[inside, 2] * OUTWARDS[hand]
    flags = [] if ended else ["endless"]
    if grid.has_hole(onset_s, end_s):
        flags.append("gap")
    sign = 1.0
    arrival_s = departure_s = end_s
    if turning.min() < -threshold and turning.max() > threshold:
        if turning.argmin() < turning.argmax():
            sign = -1.0
            flags.append("reversed")
        out, back = sorted((int(turning.argmin()), int(turning.argmax())))
        way_out = (sign * turning[out:back] > threshold).nonzero()[0]
        way_back = (sign * turning[out : back + 1] < -threshold).nonzero()[0]
        arrival_s = float(time[out + way_out[way_out < way_back[0]][-1]])
        departure_s = float(time[out + way_back[0]])
    elif -turning.min() > turning.max():
        sign = -1.0
        flags.append("reversed")
    return Bounds(
        onset_s=onset_s,
        arrival_s=arrival_s,
        departure_s=departure_s,
        end_s=end_s,
        axis=(0.0, 0.0, sign * OUTWARDS[hand]),
        flags=tuple(flags),
    )
