"""Strokes: the turns of single joints that movements are made of, as angles at any time."""

import math
from typing import Literal

import msgspec
import numpy as np

from sar_tui.motion.body_model import Joint
from sar_tui.motion.samples import Floats

TAIL = 0.02
"""A lognormal stroke begins and ends where its rate is this share of its peak."""
STILL = (-0.1, 3.0)
"""Outside of these shares of its time, a lognormal stroke turns by less than a millionth of its
angle.
"""
WIDTH = 0.35
"""Standard deviation of the logarithm of time in a lognormal stroke. Its rate is skewed, as
people's.
"""

_BELOW = WIDTH * math.sqrt(-2.0 * math.log(TAIL))
_FIRST, _LAST = (math.exp(-(WIDTH**2) + side * _BELOW) for side in (-1.0, 1.0))
"""Times at which the rate of a lognormal stroke of median 1 is TAIL of its peak: log rate is a
parabola in log time.
"""

_erf = np.frompyfunc(math.erf, 1, 1)


class Stroke(msgspec.Struct, frozen=True):
    """A turn of one joint from an angle to another.

    Args:
        joint: the joint that turns.
        angle: by how much, rad; see ``body_model.JOINTS`` for the direction.
        begin_s: onset.
        duration_s: time from onset to end. A minimum-jerk stroke is still outside of them (Flash &
            Hogan 1985). A lognormal one never quite begins or ends (Plamondon 1995): between them
            its rate is above TAIL of its peak.
        form: its course in time.
    """

    joint: Joint
    angle: float
    begin_s: float
    duration_s: float
    form: Literal["minimum-jerk", "lognormal"] = "minimum-jerk"

    @property
    def end_s(self) -> float:
        """When it is over, s."""
        return self.begin_s + self.duration_s

    def at(self, time_s: Floats) -> Floats:
        """Return by how much it has turned the joint at each time, rad, shape (n,)."""
        share = (time_s - self.begin_s) / self.duration_s
        return self.angle * (
            _minimum_jerk(share) if self.form == "minimum-jerk" else _lognormal(share)
        )


def _minimum_jerk(share: Floats) -> Floats:
    """Return the share of the way at a share of the time: 10u³ − 15u⁴ + 6u⁵, still before 0 and
    after 1.
    """
    u = np.clip(share, 0.0, 1.0)
    way: Floats = u**3 * (10.0 + u * (6.0 * u - 15.0))
    return way


def _lognormal(share: Floats) -> Floats:
    """Return the share of the way of a lognormal stroke, whose rate is 2 % of its peak at the times
    0 and 1.
    """
    way = np.where(share < 0.5, 0.0, 1.0)
    moving = (share > STILL[0]) & (share < STILL[1])
    elapsed = _FIRST + (_LAST - _FIRST) * share[moving]
    way[moving] = 0.5 + 0.5 * _erf(np.log(elapsed) / (WIDTH * math.sqrt(2.0))).astype(float)
    return way
