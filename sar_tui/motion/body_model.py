"""A body of trunk, upper arm, forearm and hand: orientation and position of a sensor on it, from
the joints' angles.

The axes of the room are those of a person who sits upright: x to the right, y forward, z up. With
the right arm hanging down, its elbow bent to 90° and the palm down, the hand's axes are the same: y
along the fingers, z out of its back. A left arm is the mirror image of the right one.
"""

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.quaternions import multiply, rotate
from sar_tui.motion.reach import Hand
from sar_tui.motion.samples import Floats

Joint = Literal[
    "trunk_rotation",
    "trunk_flexion",
    "shoulder_flexion",
    "shoulder_abduction",
    "shoulder_rotation",
    "elbow_flexion",
    "supination",
    "wrist_extension",
    "radial_deviation",
]
Segment = Literal["hand", "sternum"]
Angles = Mapping[Joint, Floats]
"""The angle of each joint at each time, rad, shape (n,). Joints that are left out are at 0."""
JOINTS: dict[Joint, tuple[int, float]] = {
    "trunk_rotation": (2, 1.0),
    "trunk_flexion": (0, -1.0),
    "shoulder_flexion": (0, 1.0),
    "shoulder_abduction": (1, -1.0),
    "shoulder_rotation": (2, 1.0),
    "elbow_flexion": (0, 1.0),
    "supination": (1, 1.0),
    "wrist_extension": (0, 1.0),
    "radial_deviation": (2, 1.0),
}
"""Each joint's axis (0, 1, 2 for x, y, z of the segment above) and the sign of its turn for the
right arm: trunk rotation away from the arm's side, flexion forward, abduction away from the body,
rotation inward. From the trunk to the hand, the order in which the turns are composed. Supination
is counted from the palm down.
"""
SHOULDER_M = (0.18, 0.0, 0.45)
"""The right shoulder, as seen from the hips."""
STERNUM_M = (0.0, 0.10, 0.38)
UPPER_ARM_M = 0.30
FOREARM_M = 0.25
HAND_M = 0.06
"""From the wrist to the sensor. The lengths are about those of Winter (2009, Biomechanics and Motor
Control of Human Movement, table 4.1) for a person of 1.65 m.
"""
SURFACE_M = 0.02
"""From the bones to the sensor's chip."""
_HALF = math.sqrt(0.5)
_FOREARM_BENT = np.array((_HALF, -_HALF, 0.0, 0.0))
"""At an elbow angle of 0 the forearm hangs down."""
_CHEST = np.array((0.0, 0.0, _HALF, _HALF))
"""A sensor on the sternum has y up and z forward."""
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


class Site(NamedTuple):
    """A place on the body for a sensor.

    ``turned``: the sensor's orientation as seen from the segment, a quaternion; (1, 0, 0, 0) for z
    out of its back.
    """

    segment: Segment = "hand"
    arm: Hand = "right"
    turned: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """Orientation of a sensor at each time (a quaternion, shape (n, 4)) and its position in the
    room (m, (n, 3)).
    """

    orientation: Floats
    position: Floats


class _Chain:
    """The end of a chain of segments: its orientation and position, at each time."""

    def __init__(self, angles: Angles, side: float, count: int) -> None:
        self.orientation: Floats = np.zeros((count, 4))
        self.orientation[:, 0] = 1.0
        self.position: Floats = np.zeros((count, 3))
        self._angles = angles
        self._side = side

    def go(self, way: tuple[float, float, float]) -> None:
        """Go along the segment, m."""
        self.position = self.position + rotate(self.orientation, np.array(way))

    def set(self, turned: Floats) -> None:
        """Turn by a fixed rotation, a quaternion."""
        self.orientation = multiply(self.orientation, turned)

    def turn(self, *joints: Joint) -> None:
        """Turn by the angles of joints. A mirror image turns the other way about all axes but the
        one across it.
        """
        for joint in joints:
            if joint in self._angles:
                axis, sign = JOINTS[joint]
                half = self._angles[joint] * (sign * (1.0 if axis == 0 else self._side) / 2.0)
                turned = np.zeros((len(half), 4))
                turned[:, 0] = np.cos(half)
                turned[:, 1 + axis] = np.sin(half)
                self.orientation = multiply(self.orientation, turned)


def pose(angles: Angles, site: Site, count: int) -> Pose:
    """Return the pose of a sensor at ``count`` times."""
    side = 1.0 if site.arm == "right" else -1.0
    chain = _Chain(angles, side, count)
    chain.turn("trunk_rotation", "trunk_flexion")
    if site.segment == "sternum":
        chain.go(STERNUM_M)
        chain.set(_CHEST)
    else:
        chain.go((side * SHOULDER_M[0], *SHOULDER_M[1:]))
        chain.turn("shoulder_flexion", "shoulder_abduction", "shoulder_rotation")
        chain.go((0.0, 0.0, -UPPER_ARM_M))
        chain.turn("elbow_flexion")
        chain.set(_FOREARM_BENT)
        chain.turn("supination")
        chain.go((0.0, FOREARM_M, 0.0))
        chain.turn("wrist_extension", "radial_deviation")
        chain.go((0.0, HAND_M, 0.0))
    chain.set(np.array(site.turned))
    chain.go((0.0, 0.0, SURFACE_M))
    return Pose(chain.orientation, chain.position)


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
