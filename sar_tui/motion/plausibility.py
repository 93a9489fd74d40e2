"""Judgement whether an excursion of the hand is a reach of a person, or daily life: for recordings
of any content.

A session's window holds a reach because the person was asked for one. A recording of hours holds
walking, typing and scratching as well, which turn the hand out and back, too. A reach among them

- is large enough, and returns to where it began: nearer if the hand shakes on its way, as it does
  when it rubs or types there;
- has one dominant excursion: the hand does not come back halfway to leave again, nor wander far on
  its way;
- rests before and after, or at the target and at one end: in walking, rubbing or trembling each
  swing adjoins the next.

The last sorts out rhythms without a look at their period. So reaches in a row are kept, however
even their pace, if the hand rests for 0.4 s between them.
"""

import math

import numpy as np

from sar_tui.motion.arrays import lengths
from sar_tui.motion.filters import Spectrum, usable_cutoff
from sar_tui.motion.quaternions import angle, conjugate, integrate, multiply
from sar_tui.motion.reach import Bounds, Detected
from sar_tui.motion.samples import Floats

LEAST_RAD = math.radians(12)
"""Smallest excursion. Gestures of fingers and wrist are smaller, a reach of the arm is larger."""
LEFT_SHARE, LEFT_RAD = 0.5, math.radians(25)
"""The hand is back if no more is left than this share of the excursion, and than this angle."""
SHAKEN_POWER = 0.5
"""Power of the path's multiple by which both limits are divided if the hand shakes on its way."""
BACK_S = 2.0
"""It may come back so long after the end that was found: it has set down a glass first."""
DENT_SHARE = 0.5
"""Share of the excursion by which the hand may come back, or leave again, in between."""
PATH_SHARE, PATH_RAD = 3.0, 4.0 * math.pi
"""All its movements together turn the hand by at most this times the way out and back, and by a
whole turn each way; walking somewhere and back, or a bout of a rhythm, by more.
"""
CALM_SHARE = 0.15
"""Share of the reach's largest speed that the hand has at most where it rests."""
CALM_S = 0.4
"""Shortest rest before and after a reach, and at its target."""
BESIDE_S = 0.5
"""Such a rest is sought within this time before and after it."""
INSIDE_S, INSIDE_SHARE = 0.05, 0.05
"""It may reach into the reach by this time; and at its start, whose onset may have been found too
early, as long as the hand has left by less than this share of the excursion.
"""
CUTOFF_HZ, SLOW_HZ = 8.0, 2.5
"""A rest has no movement below the first; a reach's speed is that of its movement below the
second.
"""
UNKNOWN = "cut"
"""Flag of a reach that the recording does not hold as a whole. It is kept: what is missing cannot
be judged.
"""


def plausible(found: Detected, least_rad: float = LEAST_RAD) -> Detected:
    """Return what was found without the excursions that are no reach, by the module's rules.

    ``least_rad``: the smallest excursion of a reach.
    """
    if not found.reaches:
        return found
    spectrum = found.spectrum or Spectrum(found.rate, found.rate_hz)
    fast = lengths(spectrum.below(usable_cutoff(CUTOFF_HZ, found.rate_hz), found.tremor_hz))
    slow = lengths(spectrum.below(SLOW_HZ, found.tremor_hz))
    orientation = integrate(found.rate, 1.0 / found.rate_hz)
    return found._replace(
        reaches=tuple(
            bounds
            for bounds in found.reaches
            if UNKNOWN in bounds.flags
            or _is_plausible(bounds, found, least_rad, orientation, fast, slow)
        )
    )


def _is_plausible(
    bounds: Bounds,
    found: Detected,
    least_rad: float,
    orientation: Floats,
    fast: Floats,
    slow: Floats,
) -> bool:
    first, last = np.searchsorted(found.time_s, (bounds.onset_s, bounds.end_s)).tolist()
    last = max(first, min(last, len(orientation) - 1))
    until = last + 1 + round(BACK_S * found.rate_hz)
    turned = angle(multiply(conjugate(orientation[first]), orientation[first:until]))
    inside = last - first + 1
    if not _is_excursion(turned[:inside], least_rad):
        return False
    speed = slow[first : last + 1]
    path = float(speed.sum()) / found.rate_hz
    shaken = float(fast[first : last + 1].sum()) / found.rate_hz / path
    return (
        path <= min(PATH_SHARE * 2.0 * float(turned[:inside].max()), PATH_RAD)
        and _is_back(turned, inside, shaken)
        and _is_calm(
            fast,
            first,
            turned[:inside],
            bounds.departure_s - bounds.arrival_s,
            CALM_SHARE * float(speed.max()),
            found.rate_hz,
        )
    )


def _is_excursion(turned: Floats, least_rad: float) -> bool:
    """Return True if an angle rises far enough and falls, without a large dent.

    Args:
        turned: angle from the orientation at the onset, rad, from there to the end.
        least_rad: how far, rad.
    """
    top = int(turned.argmax())
    rise, fall = turned[: top + 1], turned[top:]
    dent = max(
        float((np.maximum.accumulate(rise) - rise).max()),
        float((fall - np.minimum.accumulate(fall)).max()),
    )
    return float(turned[top]) >= least_rad and dent <= DENT_SHARE * float(turned[top])


def _is_back(turned: Floats, inside: int, shaken: float) -> bool:
    """Return True if the angle of a reach of ``inside`` samples is small at its end, or soon after
    it.

    ``shaken``: its path below ``CUTOFF_HZ`` as a multiple of that below ``SLOW_HZ``. The larger it
    is, the nearer the hand must come. It need not be smooth: a tremor in action has the same
    frequencies as rubbing.
    """
    left = min(LEFT_RAD, LEFT_SHARE * float(turned[:inside].max()))
    nearest = float(turned[inside - 1 :].min())
    return nearest * float(max(1.0, shaken) ** SHAKEN_POWER) <= left


def _is_calm(
    fast: Floats, first: int, turned: Floats, dwell_s: float, limit: float, rate_hz: float
) -> bool:
    """Return True if the hand rests at two of three: before a reach, at the target, and after.

    A recording that begins or ends there need not show the rest.

    Args:
        fast: speed of the hand, rad/s, in the whole recording.
        first: the reach's first sample.
        turned: angle from the orientation there, rad, for each of its samples.
        dwell_s: rest at the target.
        limit: speed at rest, rad/s.
        rate_hz: samples per second.
    """
    last = first + len(turned) - 1
    beside, into = round(BESIDE_S * rate_hz), round(INSIDE_S * rate_hz)
    left = int((turned > INSIDE_SHARE * float(turned.max())).argmax())
    before = fast[max(0, first - beside) : first + max(into, left)]
    after = fast[max(0, last - into) : last + beside]
    at_rest = [_slowest(speed, round(CALM_S * rate_hz)) <= limit for speed in (before, after)]
    return all(at_rest) or (any(at_rest) and dwell_s >= CALM_S)


def _slowest(speed: Floats, samples: int) -> float:
    """Return the lowest mean of so many samples in a row; 0 if there are fewer."""
    if len(speed) < samples:
        return 0.0
    sums = np.concatenate(([0.0], np.cumsum(speed)))
    return float((sums[samples:] - sums[:-samples]).min()) / samples
