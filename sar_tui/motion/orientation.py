"""The orientation detector: a reach turns the hand away from its orientation at rest, and back,
about whatever axes.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion import quaternions
from sar_tui.motion.arrays import changes, lengths, order_statistic
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
SUBMOVEMENT = 0.05
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
"""Share of the largest speed below which a hand near its start turns around, and does not just
pass.
"""
TOO_LONG = 2.0
"""Multiple of the longest reach within which a hand must be back, or it was no reach."""
LINGER_S = 1.2
"""Longest time from a stop on the way back until the hand is nearer to its start, as a cup is put
down in between.
"""
HOME_S = 0.3
"""Shortest rest from which a reach starts, if it is not the one that ended the reach before."""
JUST_BEFORE_S = 0.1
"""Time before the end of a rest at which its orientation is taken."""


class Limits(NamedTuple):
    """Definitions: a hand at rest is slower than ``still`` (rad/s); ``home_s`` is the shortest
    first rest from which a reach starts; for the others see `OrientationParameters`.
    """

    still: float
    least_rad: float
    return_share: float
    longest_s: float
    home_s: float


class Excursion(NamedTuple):
    """A turn away from the orientation at sample ``first`` and back at ``last``, farthest at
    ``top``.

    ``stop``: where the hand leaves again, or the end of the stretch. ``angle``: shape (stop -
    first,), rad, from the orientation at ``first``. ``axis``: that of the largest angle.
    """

    first: int
    top: int
    last: int
    stop: int
    angle: Floats
    axis: tuple[float, float, float]

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
        shortest_s: shortest duration of a reach without the rest at the target.
        pause_s: a shorter pause does not end a movement.
        dwell_s: the longest rest at the target within a reach.
        longest_s: longest reach; a longer one is cut off.
        home_s: shortest rest from which the first reach starts, where the recording is known to
            begin there; unset, it needs as long a rest as each other.
    """

    cutoff_hz: float = 8.0
    rest_s: float = 1.0
    begin_rad_s: float = 0.1
    end_rad_s: float = 0.05
    least_rad: float = 0.1
    return_share: float = 0.4
    shortest_s: float = 0.4
    pause_s: float = 0.4
    dwell_s: float = 5.0
    longest_s: float = 15.0
    home_s: float | msgspec.UnsetType = msgspec.UNSET


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
        least_rad=parameters.least_rad,
        return_share=parameters.return_share,
        longest_s=parameters.longest_s,
        home_s=HOME_S if parameters.home_s is msgspec.UNSET else parameters.home_s,
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
    if (arrival_s - onset_s) + (end_s - departure_s) < parameters.shortest_s:
        return None
    is_reversed = abs(excursion.axis[2]) > SIDED and excursion.axis[2] * OUTWARDS[hand] < 0
    return Bounds(
        onset_s=onset_s,
        arrival_s=arrival_s,
        departure_s=departure_s,
        end_s=end_s,
        axis=excursion.axis,
        flags=("reversed",) if is_reversed else (),
    )


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
    """Yield the turns away from an orientation at rest and back, in order of time.

    A stretch that begins in movement may begin on a way back, so its first home is found from its
    end, backwards.

    Args:
        orientation: quaternions, shape (n, 4), relative to any orientation.
        slow: norm of the angular rate, smoothed, shape (n,), rad/s.
        rate_hz: samples per second.
        limits: definitions of rest and of an excursion.
    """
    homes = _homes(slow <= limits.still, rate_hz, limits.home_s)
    if slow[0] > limits.still >= slow[-1]:
        backwards = list(_chains(orientation[::-1], slow[::-1], [0], rate_hz, limits))
        first = len(slow) - 1 - (backwards[-1].last if backwards else 0)
        homes = [first, *(home for home in homes if home > first)]
    yield from _chains(orientation, slow, homes, rate_hz, limits)


def _chains(
    orientation: Floats, slow: Floats, homes: list[int], rate_hz: float, limits: Limits
) -> Iterator[Excursion]:
    """Yield the turns away from a home and back, and from there again.

    A rest from which the hand does not come back was not the start of a reach: the next one is
    tried.
    """
    at, farthest = 0, round(TOO_LONG * limits.longest_s * rate_hz)
    for home in homes:
        start = home
        while start >= at:
            ahead = slice(start, start + farthest)
            found = _excursion_from(orientation[ahead], slow[ahead], LINGER_S * rate_hz, limits)
            if found is None:
                break
            yield found.later(start)
            at = start = start + found.last


def _homes(resting: npt.NDArray[np.bool_], rate_hz: float, first_s: float) -> list[int]:
    """Return the samples at which a reach may start: just before the end of each rest that is no
    mere turn.

    A rest with which the samples begin may be shorter than others: ``first_s``.
    """
    edges = changes(resting)
    rests = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    shortest, before = HOME_S * rate_hz, round(JUST_BEFORE_S * rate_hz)
    return [
        max(first, last - 1 - before)
        for first, last in rests
        if last - first >= (first_s * rate_hz if first <= shortest else shortest)
    ] or [0]


def _excursion_from(
    orientation: Floats, slow: Floats, linger: float, limits: Limits
) -> Excursion | None:
    """Return the first turn away from the orientation at the first sample and back; None without a
    way back.

    A stop on the way back, of which less than ``linger`` samples pass before the hand is nearer,
    does not end it.
    """
    turned = quaternions.multiply(quaternions.conjugate(orientation[0]), orientation)
    angle = quaternions.angle(turned)
    highest = np.maximum.accumulate(angle)
    back = ((highest >= limits.least_rad) & (angle <= limits.return_share * highest)).nonzero()[0]
    at = 0
    while (index := int(np.searchsorted(back, at))) < len(back):
        came = int(back[index])
        largest = float(highest[came])
        leaves = _leaves(angle, came, limits.return_share * largest)
        if _is_back(
            angle[came:leaves], slow[came:leaves], limits.still, largest, float(slow[:leaves].max())
        ):
            rests = (slow[came:leaves] <= limits.still).nonzero()[0]
            last = came + (
                _settles(angle[came:leaves], rests, NEAR * largest, linger)
                if len(rests)
                else int(angle[came:leaves].argmin())
            )
            stop = min(leaves, _leaves(angle, last, NEAR * largest)) if len(rests) else last + 1
            top = int(angle[:came].argmax())
            x, y, z = (quaternions.to_rotation(turned[top]) / angle[top]).tolist()
            return Excursion(0, top, last, stop, angle[:stop], (x, y, z))
        at = leaves
    return None


def _settles(angle: Floats, rests: npt.NDArray[np.intp], by: float, linger: float) -> int:
    """Return the first of some samples at rest from which the angle does not soon fall further."""
    at = int(rests[0])
    while True:
        nearer = (angle[at:] <= angle[at] - by).nonzero()[0]
        if not len(nearer) or nearer[0] > linger:
            return at
        later = rests[rests >= at + nearer[0]]
        if not len(later):
            return at
        at = int(later[0])


def _leaves(angle: Floats, since: int, by: float) -> int:
    """Return where an angle has risen by so much above its lowest since a sample; the number of
    samples if nowhere.
    """
    lowest = np.minimum.accumulate(angle[since:])
    leaves = (angle[since:] > lowest + by).nonzero()[0]
    return since + int(leaves[0]) if len(leaves) else len(angle)


def _is_back(angle: Floats, slow: Floats, still: float, largest: float, fastest: float) -> bool:
    """Return True if the hand stops near its start, or turns around there, instead of passing on
    its way.
    """
    speed = float(slow.min())
    return speed <= still or (float(angle.min()) <= NEAR * largest and speed <= TURNING * fastest)
