"""Measures of a reach from the sensor's orientation: how far it turned, how directly, and how it
was inclined.
"""

import math
from typing import NamedTuple

import numpy as np

from sar_tui.motion.quaternions import angle, conjugate, integrate, rotate
from sar_tui.motion.samples import Floats
from sar_tui.motion.vectors import lengths

_FINGERS = 1
"""The sensor's axis along fingers and forearm: y."""


class Turned(NamedTuple):
    """Angles in degrees; straightness 0 to 1. None: not measured, or not defined."""

    excursion_deg: float
    straightness: float | None
    return_error_deg: float | None
    inclination_rest_deg: float | None
    inclination_target_deg: float | None


def turned(
    rate: Floats, rate_hz: float, arrival: int, target: int, departure: int, up: Floats | None
) -> Turned:
    """Return the measures of a reach.

    The angular rate is integrated from the onset on. Gravity is not followed during the reach,
    where the accelerometer feels the hand's own acceleration: over the few seconds of a reach, the
    gyroscope alone errs less.

    Args:
        rate: angular rate without bias from onset to end, shape (n, 3), rad/s, with n of at least
            1.
        rate_hz: samples per second.
        arrival, target, departure: index of the sample at which the hand arrives, is at the target,
            and leaves it. Without a way back, the hand leaves with the last sample.
        up: the direction of up at the onset in the sensor's axes, of any length, shape (3,); None
            if not known.
    """
    orientation = integrate(rate, 1.0 / rate_hz)
    angles = np.degrees(angle(orientation))
    speed = np.degrees(lengths(rate[: arrival + 1]))
    path = float((speed[1:] + speed[:-1]).sum()) / (2.0 * rate_hz)
    return Turned(
        excursion_deg=float(angles[: departure + 1].max()),
        straightness=min(1.0, float(angles[arrival]) / path) if path > 0 else None,
        return_error_deg=float(angles[-1]) if departure < len(rate) - 1 else None,
        inclination_rest_deg=None if up is None else _inclination(up),
        inclination_target_deg=None
        if up is None
        else _inclination(rotate(conjugate(orientation[target]), up)),
    )


def _inclination(up: Floats) -> float:
    """Return the angle of the fingers' axis above the horizontal, in degrees."""
    return math.degrees(math.asin(float(up[_FINGERS]) / float(np.linalg.norm(up))))
