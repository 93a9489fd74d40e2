"""Excursions: turns of the hand away from its orientation at rest, and back."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sar_tui.motion import quaternions
from sar_tui.motion.changes import changes
from sar_tui.motion.samples import Floats

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
