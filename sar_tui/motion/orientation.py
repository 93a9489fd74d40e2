"""The orientation detector: a reach turns the hand away from its orientation at rest, and back,
about whatever axes.
"""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Literal, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion import quaternions
from sar_tui.motion.arrays import lengths, order_statistic, turning_points
from sar_tui.motion.boundaries import checked, first_peak, onset, stretches
from sar_tui.motion.filters import usable_cutoff
from sar_tui.motion.reach import OUTWARDS, Bounds, Detected, Hand
from sar_tui.motion.rest import SLOW_HZ, Grid, Rest, even
from sar_tui.motion.samples import Floats, Recording

CALM_HZ = 5.0
"""Cutoff of the smoothing in which submovements are told apart."""
MARGIN_S = 1.0
"""Time around a stretch of movement in which a reach may begin and end."""
FAR = 0.8
"""Share of the excursion beyond which the hand counts as at its target."""
MOVING = 0.01
"""A way lasts while the hand turns at this share of the way's largest rate, or more."""
SUBMOVEMENT = 0.1
"""Least peak of a submovement that begins or ends a reach, as a share of the reach's peak."""
NOISE = 1.8
"""95th percentile of the norm of normal noise on three axes, as a multiple of its median (slow ends
change it less).
"""
TURN_S = 0.1
"""A shorter rest at the target is a turn."""
SIDED = math.cos(math.radians(45))
"""An excursion whose axis is nearer than this to z shows which way the hand turns."""
NEAR = 0.15
"""Share of the excursion within which the hand counts as not having left yet, or as back
already.
"""
TURNING = 0.3
"""A hand is back without any doubt if no more than this share of the largest angle is left there,
and no more than this share of the largest speed, as where it turns around.
"""
UNSEEN = 0.45
"""Share of the largest speed that is assumed in a short rest with which the samples begin, as most
of it may not be seen.
"""
TOO_LONG = 2.0
"""Multiple of the longest reach within which a hand must be back, or it was no reach."""
LINGER_S = 1.2
"""Longest time from a stop on the way back until the hand is nearer to its start, as a cup is put
down in between.
"""
JUST_BEFORE_S = 0.1
"""Time before the end of a rest at which its orientation is taken."""


Ends = Literal["still", "home"]


class Limits(NamedTuple):
    """Definitions: a hand at rest is slower than ``still`` (rad/s); where it turns around it is
    slower than a share ``slower`` of the peaks beside; for the others see `OrientationParameters`.
    """

    still: float
    slower: float
    least_rad: float
    return_share: float
    longest_s: float
    home_s: float


class Excursion(NamedTuple):
    """A turn away from the orientation at sample ``first`` and back at ``last``, farthest at
    ``top``.

    ``stop``: where the hand leaves again, or the end of the stretch. ``angle``: shape (stop -
    first,), rad, from the orientation at ``first``. ``axis``: that of the largest angle.
    ``confidence``: see `reach.Reach`.
    """

    first: int
    top: int
    last: int
    stop: int
    angle: Floats
    axis: tuple[float, float, float]
    confidence: float

    def later(self, samples: int) -> "Excursion":
        """Return it with its samples counted from further back."""
        first, top, last, stop = (sample + samples for sample in self[:4])
        return self._replace(first=first, top=top, last=last, stop=stop)


class OrientationParameters(msgspec.Struct, frozen=True, kw_only=True):
    """Definitions of movement and of a reach.

    Args:
        cutoff_hz: cutoff of the low-pass (second-order Butterworth).
        rest_s: duration of stillness that counts as rest; it gives the sensor's bias and noise.
        begin_rad_s: a movement exceeds this; the limit is higher if the hand is not quiet at rest.
        end_rad_s: a movement lasts while it is faster than this.
        least_rad: smallest angle between the orientations at rest and at the target.
        return_share: the hand is back when this share of the largest angle, or less, is left.
        ends: a reach ends when the hand is ``still`` again, or when it is ``home``: within ``NEAR``
            of the largest angle.
        shortest_s: shortest duration of a reach without the rest at the target.
        pause_s: a shorter pause does not end a movement.
        dwell_s: the longest rest at the target within a reach.
        longest_s: longest reach; a longer one is cut off.
        home_s: shortest rest with which the recording may begin that shows that it begins at home;
            0 if it is known to.
    """

    cutoff_hz: float = 8.0
    rest_s: float = 1.0
    begin_rad_s: float = 0.1
    end_rad_s: float = 0.07
    least_rad: float = 0.1
    return_share: float = 0.5
    ends: Ends = "still"
    shortest_s: float = 0.4
    pause_s: float = 0.4
    dwell_s: float = 5.0
    longest_s: float = 15.0
    home_s: float = 0.3


class _Motion(NamedTuple):
    """A recording without its bias: norms of its rate, smoothed strongly (slow), less (calm) and
    lightly (light).
    """

    grid: Grid
    rate: Floats
    slow: Floats
    calm: Floats
    light: Floats
    rest: Rest
    begin: float
    end: float
    floor: float


def find(
    recording: Recording,
    parameters: OrientationParameters | None = None,
    hand: Hand = "right",
    grid: Grid | None = None,
) -> Detected:
    """Find the reaches in a whole recording.

    The angular rate without the bias at rest is integrated to the hand's orientation. From each
    rest, the angle between the orientation there and now is followed: a reach is a rise of that
    angle and its fall to a small share, about whatever axes the hand turns. Onset, end and the rest
    at the target come from the norm of the rate.

    Flags, ``grid`` and errors are as in ``single_axis.find``.
    """
    parameters = parameters or OrientationParameters()
    grid = grid or even(recording)
    if len(grid.time_s) < 2:
        return Detected(grid.time_s, grid.rate, grid.rate_hz, (), by_norm=True)
    cutoff = usable_cutoff(parameters.cutoff_hz, grid.rate_hz)
    rest, rate, spectrum = grid.unbiased(parameters.rest_s)
    slow = lengths(spectrum.below(SLOW_HZ, rest.tremor_hz))
    light = lengths(spectrum.below(cutoff, rest.tremor_hz))
    calm = lengths(spectrum.below(min(CALM_HZ, cutoff), rest.tremor_hz))
    floor = order_statistic(slow[rest.still], 0.99)
    motion = _Motion(
        grid=grid,
        rate=rate,
        slow=slow,
        calm=calm,
        light=light,
        rest=rest,
        begin=max(parameters.begin_rad_s, 2.0 * floor),
        end=max(parameters.end_rad_s, 1.2 * floor),
        floor=NOISE * order_statistic(light[rest.still], 0.5),
    )
    reaches = tuple(
        reach
        for group in stretches(slow > motion.begin, parameters.dwell_s * grid.rate_hz)
        for reach in _reaches(motion, group, parameters, hand)
    )
    return Detected(
        grid.time_s, rate, grid.rate_hz, reaches, rest.tremor_hz, by_norm=True, spectrum=spectrum
    )


def _reaches(
    motion: _Motion, group: slice, parameters: OrientationParameters, hand: Hand
) -> Iterator[Bounds]:
    """Yield the reaches in one stretch of movement."""
    grid = motion.grid
    margin = round(MARGIN_S * grid.rate_hz)
    first, last = max(0, group.start - margin), min(len(motion.slow), group.stop + margin)
    orientation = quaternions.integrate(motion.rate[first:last], 1.0 / grid.rate_hz)
    earliest = first
    limits = Limits(
        still=motion.end,
        slower=motion.end / motion.begin,
        least_rad=parameters.least_rad,
        return_share=parameters.return_share,
        longest_s=parameters.longest_s,
        home_s=parameters.home_s,
    )
    for excursion in excursions(orientation, motion.slow[first:last], grid.rate_hz, limits):
        bounds = _bounds(motion, excursion.later(first), earliest, parameters, hand)
        if bounds is None:
            continue
        yield checked(
            bounds,
            grid,
            motion.rest,
            is_cut=bounds.onset_s <= grid.time_s[0] or bounds.end_s >= grid.time_s[-1],
            longest_s=parameters.longest_s,
            cutoff_hz=parameters.cutoff_hz,
        )
        earliest = int(np.searchsorted(grid.time_s, bounds.end_s))


def _bounds(
    motion: _Motion,
    excursion: Excursion,
    earliest: int,
    parameters: OrientationParameters,
    hand: Hand,
) -> Bounds | None:
    """Return the reach of an excursion, which begins at sample ``earliest`` or later; None for a
    twitch.
    """
    grid, slow, angle = motion.grid, motion.slow, excursion.angle
    first, top, last = excursion.first, excursion.top, excursion.last
    largest = float(angle[top - first])
    far = first + (angle[: last - first + 1] > FAR * largest).nonzero()[0]
    arrives, departs = _dwell(motion, int(far[0]), int(far[-1]))
    if arrives <= max(first, earliest) or departs >= last:
        return None
    left = first + int((angle[: top - first + 1] <= NEAR * largest).nonzero()[0][-1])
    near = max(NEAR * largest, float(angle[last - first]))
    came = top + int((angle[top - first :] <= near).nonzero()[0][0])
    moving = slow > max(SUBMOVEMENT * float(slow[first : last + 1].max()), motion.end)
    pause = round(parameters.pause_s * grid.rate_hz)
    begins = earliest + _begins(moving[earliest : max(earliest, left) + 1], pause)
    ends = excursion.stop - 1 - _begins(moving[came : excursion.stop][::-1], pause)
    if begins >= arrives or departs >= ends:
        return None
    onset_s, arrival_s = _edges(motion, earliest, begins, arrives, departs + 1)
    departure_s, end_s = _edges(motion, arrives, departs, ends, excursion.stop)
    if departs - arrives < TURN_S * grid.rate_hz:
        arrival_s = departure_s = float(
            grid.time_s[arrives + int(slow[arrives : departs + 1].argmin())]
        )
    departure_s = max(arrival_s, departure_s)
    if parameters.ends == "home":
        end_s = max(departure_s, _reaches_home(motion, angle, first, came, near))
    if (arrival_s - onset_s) + (end_s - departure_s) < parameters.shortest_s:
        return None
    is_reversed = abs(excursion.axis[2]) > SIDED and excursion.axis[2] * OUTWARDS[hand] < 0
    return Bounds(
        onset_s=onset_s,
        arrival_s=arrival_s,
        departure_s=departure_s,
        end_s=end_s,
        axis=excursion.axis,
        confidence=excursion.confidence,
        flags=("reversed",) if is_reversed else (),
    )


def _reaches_home(motion: _Motion, angle: Floats, first: int, came: int, near: float) -> float:
    """Return when the angle from sample ``first`` on falls to ``near``, just before sample
    ``came``.
    """
    time = motion.grid.time_s[came - 1 : came + 1]
    return float(np.interp(-near, -angle[came - 1 - first : came + 1 - first], time))


def _dwell(motion: _Motion, first: int, last: int) -> tuple[int, int]:
    """Return the first and last sample at rest between two; without a rest, where the hand is
    slowest.
    """
    slow = motion.slow[first : last + 1]
    still = (slow <= motion.end).nonzero()[0]
    if len(still):
        return first + int(still[0]), first + int(still[-1])
    slowest = first + int(slow.argmin())
    return slowest, slowest


def _begins(moving: npt.NDArray[np.bool_], pause: int) -> int:
    """Return the first sample of the movement that goes on at the last one, across pauses up to
    ``pause`` samples.
    """
    index = moving.nonzero()[0]
    if not len(index) or len(moving) - 1 - index[-1] > pause:
        return len(moving) - 1
    apart = (np.diff(index) > pause).nonzero()[0]
    return int(index[apart[-1] + 1] if len(apart) else index[0])


def _edges(motion: _Motion, earliest: int, first: int, last: int, stop: int) -> tuple[float, float]:
    """Return beginning and end, in s, of the movement between two samples; it may extend to the
    outer two.
    """
    time, light, calm = motion.grid.time_s, motion.light, motion.calm[first : last + 1]
    level = MOVING * float(calm.max())
    way_in = slice(earliest, first + first_peak(calm, SUBMOVEMENT) + 1)
    way_out = slice(last - first_peak(calm[::-1], SUBMOVEMENT), stop)
    return (
        max(onset(time[way_in], light[way_in], motion.floor, level), float(time[earliest])),
        min(
            onset(time[way_out][::-1], light[way_out][::-1], motion.floor, level),
            float(time[stop - 1]),
        ),
    )


def excursions(
    orientation: Floats, slow: Floats, rate_hz: float, limits: Limits
) -> Iterator[Excursion]:
    """Yield the turns away from an orientation and back that explain most of the movement, in order
    of time.

    The hand stops, or turns around, where its speed is low beside the movements before and after.
    From each such stop, a turn leads to the first stop at which little of the largest angle is
    left. Of all sets of turns that do not overlap, the one whose movement is largest is taken, each
    weighted by how far it comes back and how calm the hand is at both ends (dynamic programming
    over the stops). So a return is not taken for a way out: one reach less would fit.

    Args:
        orientation: quaternions, shape (n, 4), relative to any orientation.
        slow: norm of the angular rate, smoothed, shape (n,), rad/s.
        rate_hz: samples per second.
        limits: definitions of rest and of an excursion.
    """
    stops = _stops(slow, rate_hz, limits)
    if not stops:
        return
    begins, ends = np.array([stop[:2] for stop in stops]).T
    homes = np.maximum(begins, ends - round(JUST_BEFORE_S * rate_hz))
    path = np.cumsum(slow)
    farthest, linger = TOO_LONG * limits.longest_s * rate_hz, LINGER_S * rate_hz
    best: list[tuple[float, tuple[int, int] | None]] = [(0.0, None) for _ in stops]
    for index, home in enumerate(homes.tolist()):
        if index and best[index - 1][0] >= best[index][0]:
            best[index] = best[index - 1][0], None
        later = slice(index + 1, int(np.searchsorted(begins, home + farthest)))
        away = quaternions.angle(
            quaternions.multiply(
                quaternions.conjugate(orientation[home]), orientation[begins[later]]
            )
        )
        found = _return(away, begins[later], ends[later], linger, limits)
        if found is None:
            continue
        back, left = index + 1 + found[0], found[1]
        moved = float(path[begins[back]] - path[ends[index]])
        shares = (left, stops[index].speed, stops[back].speed)
        total = best[index][0] + moved * math.prod(
            min(1.0, (1.0 - share) / (1.0 - TURNING)) for share in shares
        )
        if total > best[back][0]:
            best[back] = total, (index, back)
    chosen = []
    at = len(stops) - 1
    while at >= 0:
        pair = best[at][1]
        if pair is not None:
            chosen.append(pair)
        at = at - 1 if pair is None else pair[0]
    for index, back in reversed(chosen):
        first, last, stop = int(homes[index]), int(begins[back]), int(ends[back]) + 1
        turned = quaternions.multiply(
            quaternions.conjugate(orientation[first]), orientation[first:stop]
        )
        angle = quaternions.angle(turned)
        top = int(angle[: last - first].argmax())
        x, y, z = (quaternions.to_rotation(turned[top]) / angle[top]).tolist()
        left = min(1.0, float(angle[last - first] / angle[top]))
        confidence = (1.0 - left) * (1.0 - stops[index].speed) * (1.0 - stops[back].speed)
        yield Excursion(first, first + top, last, stop, angle, (x, y, z), confidence)


class _Stop(NamedTuple):
    """A stretch in which the hand rests or turns around, from sample ``first`` to ``last``.

    ``speed``: lowest speed as a share of the larger peak beside; 0 at rest.
    """

    first: int
    last: int
    speed: float


def _stops(slow: Floats, rate_hz: float, limits: Limits) -> list[_Stop]:
    """Return the stretches in which the hand rests or turns around, in order of time.

    The speed there is a share ``limits.slower`` or less of the peaks before and after.
    """
    level = np.log(np.maximum(slow, limits.still))
    turns = turning_points(level, -math.log(limits.slower))
    if not turns:
        return []
    peaks = turns[1::2] if level[turns[0]] < level[turns[1]] else turns[::2]
    edges = [0, *peaks, len(slow) - 1]
    stops = []
    for first, last in pairwise(edges):
        part = slow[first : last + 1]
        sides = [slow[peak] for peak in (first, last) if peak in peaks]
        low = int(part.argmin())
        most = max(limits.still, float(part[low]), SUBMOVEMENT * float(min(sides)))
        above = (part > most).nonzero()[0]
        before, after = above[above < low], above[above > low]
        begin = first + int(before[-1]) + 1 if len(before) else first
        end = first + int(after[0]) - 1 if len(after) else last
        least = float(part[low])
        speed = 0.0 if least <= limits.still else least / float(max(sides))
        if not first and end < limits.home_s * rate_hz:
            speed = max(speed, UNSEEN)
        stops.append(_Stop(begin, end, speed))
    return stops


def _return(
    away: Floats,
    begins: npt.NDArray[np.intp],
    ends: npt.NDArray[np.intp],
    linger: float,
    limits: Limits,
) -> tuple[int, float] | None:
    """Return the index of the stop at which the hand is back, and the share of the largest angle
    that is left there; None if it does not come back.

    A stop of at most ``linger`` samples on the way back, after which the hand comes nearer, does
    not end it.
    """
    largest = np.maximum.accumulate(away)
    near = limits.return_share * largest
    back = ((largest >= limits.least_rad) & (away <= near)).nonzero()[0]
    if not len(back):
        return None
    at = int(back[0])
    most = float(largest[at])
    for index in range(at + 1, len(away)):
        if away[index] > limits.return_share * most or ends[at] - begins[at] > linger:
            break
        if away[index] <= away[at] - SUBMOVEMENT * most:
            at = index
    return at, float(away[at]) / most
