"""Boundaries of movements, for every detector: stretches of movement, onset and end to a few
milliseconds, and warnings of the reaches between them.
"""

import math
from collections.abc import Iterator

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.filters import LOW_RATE
from sar_tui.motion.reach import Bounds
from sar_tui.motion.rest import Grid, Rest
from sar_tui.motion.samples import Floats

LOW, HIGH = 0.08, 0.35
"""Part of the rise that the line is fitted to, as shares of the peak speed."""
HIGHEST_LOW = 0.2
"""Largest lower bound of that part: it rises with the noise."""
PROMINENT, FALL = 0.2, 0.6
"""A submovement's peak is at least the first share of the phase's peak; it ends where the speed
falls below the second share of its own.
"""
POINTS = 24
"""Number of points that the line is fitted to."""
_EVENLY = np.linspace(0.0, 1.0, POINTS)
SLOW, SETTLED, TAIL = 0.1, 0.05, 0.02
"""Shares of the peak speed: a movement is over below the last; or below the second, if it takes longer
from there to the last than from the first to the second, as the hand settles.
"""


def first_peak(speed: Floats, prominent: float = PROMINENT) -> int:
    """Return the peak of a phase's first submovement: before a fall to 60 %, and at least a share
    of the phase's.
    """
    highest = np.maximum.accumulate(speed)
    fallen = ((speed < FALL * highest) & (highest >= prominent * highest[-1])).nonzero()[0]
    return int(speed[: fallen[0] if len(fallen) else len(speed)].argmax())


def onset(time_s: Floats, speed: Floats, floor: float = 0.0, level: float = 0.0) -> float:
    """Return the onset of a movement that is fastest at the end of ``speed``. For an end, reverse
    both arrays.

    After Botzer & Karniel (2009), Front Neurosci 3:61: the square root of the speed grows linearly
    from the onset, so a line through it, here between 8 and 35 % of the peak, leads back to the
    onset. A minimum-jerk speed is peak · (4u(1 − u))² of the share u of its time, so u = (1 − √(1 −
    √(speed / peak))) / 2 is linear throughout; the line is fitted to that, which avoids the root's
    own error of 2 % of the lobe at either end.

    A movement may trail off more slowly: it lasts as long as its speed stays above 2 % of the peak
    (after Alt Murphy, Willén & Sunnerhagen 2011, Neurorehabil Neural Repair 25:71-80) and above
    three times the noise. But a hand that stops falls from 5 to 2 % in less time than from 10 to 5
    %, as minimum-jerk speed does; what lasts longer is the small movement in which it settles, and
    does not count. A movement that is fast from the first sample began there.

    Args:
        time_s: shape (n,), rising or falling.
        speed: shape (n,), at least 0, its largest value last.
        floor: noise at rest; the fit begins above it.
        level: the movement counts from this speed on, instead of from 0.
    """
    if len(speed) < 3 or speed[-1] <= 0:
        return float(time_s[0])
    relative = speed / speed[-1]
    low = min(max(floor / float(speed[-1]), LOW), HIGHEST_LOW)
    below = (relative < low).nonzero()[0]
    if not len(below) and relative[0] > HIGHEST_LOW:
        return float(time_s[0])
    first = int(below[-1]) if len(below) else 0
    rise = np.maximum.accumulate(relative[first:]) + 1e-9 * np.arange(len(relative) - first)
    lowest = max(low, float(rise[0]))
    least = math.sqrt(lowest)
    root = least + (math.sqrt(lowest + HIGH - LOW) - least) * _EVENLY
    when = np.interp(root * root, rise, time_s[first:])
    share = (1.0 - np.sqrt(np.maximum(1.0 - root, 0.0))) / 2.0
    middle = float(share.sum()) / POINTS
    centred = share - middle
    slope = float(centred @ when / (centred @ centred))
    peak = float(speed[-1])
    begins = (1.0 - math.sqrt(1.0 - math.sqrt(min(level / peak, 1.0)))) / 2.0
    start = float(when.sum()) / POINTS - slope * (middle - begins)
    trail = float(time_s[_trail(relative, 3.0 * floor / peak)])
    return min(start, trail) if slope > 0 else max(start, trail)


def _trail(relative: Floats, noise: float) -> int:
    """Return where a movement begins that trails off slowly; its peak, 1, is the last."""
    last = len(relative) - 1
    slow, settled, over = (
        last - int(below[-1]) if len(below := (relative < share).nonzero()[0]) else last
        for share in (max(SLOW, noise), max(SETTLED, noise), max(TAIL, noise))
    )
    return last - min(over, settled + (settled - slow))


def edges(
    time_s: Floats, speed: Floats, calm: Floats, first: int, last: int, margin: int, floor: float
) -> tuple[float, float]:
    """Return the beginning and end of a phase around samples ``first`` to ``last``.

    Args:
        time_s: shape (n,), evenly spaced.
        speed: shape (n,), the phase's direction positive, smoothed lightly.
        calm: the same, smoothed more: for finding the first and the last submovement.
        first, last: a first guess, in samples.
        margin: how far outside of it the phase may begin and end, in samples.
        floor: noise of the speed at rest.
    """
    rising = first + first_peak(calm[first:last])
    falling = last - 1 - first_peak(calm[first:last][::-1])
    way_in = slice(max(0, first - margin), rising + 1)
    way_out = slice(falling, min(len(speed), last + margin))
    ahead = np.maximum(speed, 0.0)
    return (
        onset(time_s[way_in], ahead[way_in], floor),
        onset(time_s[way_out][::-1], ahead[way_out][::-1], floor),
    )


def stretches(moving: npt.NDArray[np.bool_], longest_rest: float) -> Iterator[slice]:
    """Yield stretches of movement that are not divided by a rest longer than ``longest_rest``
    samples.
    """
    index = moving.nonzero()[0]
    if not len(index):
        return
    rests = (index[1:] - index[:-1] > longest_rest).nonzero()[0]
    starts, stops = (0, *(rests + 1).tolist()), (*(rests + 1).tolist(), len(index))
    for start, stop in zip(starts, stops, strict=True):
        yield slice(int(index[start]), int(index[stop - 1]) + 1)


def checked(
    bounds: Bounds, grid: Grid, rest: Rest, *, is_cut: bool, longest_s: float, cutoff_hz: float
) -> Bounds:
    """Return a reach with the flags ``no_rest``, ``cut``, ``timed_out``, ``gap`` and ``low_rate``
    that apply to it.

    Args:
        bounds: the reach as found.
        grid, rest: of its recording.
        is_cut: True if the recording begins or ends in it.
        longest_s: a longer reach is cut off there.
        cutoff_hz: the low-pass that the detector wants.
    """
    end_s = max(bounds.onset_s, bounds.end_s)
    flags = list(bounds.flags)
    if not rest.whole or not (rest.still & (grid.time_s < bounds.onset_s)).any():
        flags.append("no_rest")
    if is_cut:
        flags.append("cut")
    if end_s - bounds.onset_s > longest_s:
        flags.append("timed_out")
        end_s = bounds.onset_s + longest_s
    if grid.has_hole(bounds.onset_s, end_s):
        flags.append("gap")
    if grid.rate_hz < LOW_RATE * cutoff_hz:
        flags.append("low_rate")
    return msgspec.structs.replace(
        bounds,
        end_s=end_s,
        arrival_s=min(max(bounds.arrival_s, bounds.onset_s), end_s),
        departure_s=min(max(bounds.departure_s, bounds.onset_s), end_s),
        flags=tuple(flags),
    )
