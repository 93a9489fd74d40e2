"""Orientations as unit quaternions: arrays of shape (n, 4), the scalar first.

An orientation q takes a vector from the sensor's axes to those of the room: v_room = q v q*. The
angular rate of a gyroscope is in the sensor's axes, so turning on from q by a small rotation r,
seen from the sensor, gives q r.
"""

import numpy as np

from sar_tui.motion.arrays import lengths
from sar_tui.motion.samples import Floats

_SHORT = 2048
"""Up to this number of rotations, twice as many are composed in each step, which takes fewer steps
than one by one.
"""
_STRETCH = 8
"""Number of rotations that are composed one after the other; longer products are made of products
of stretches.
"""


def multiply(one: Floats, other: Floats) -> Floats:
    """Return the products of quaternions, shape (..., 4): rotation by ``other``, then by
    ``one``.
    """
    a, b, c, d = one[..., 0], one[..., 1], one[..., 2], one[..., 3]
    w, x, y, z = other[..., 0], other[..., 1], other[..., 2], other[..., 3]
    product: Floats = np.empty(np.broadcast_shapes(one.shape, other.shape))
    product[..., 0] = a * w - b * x - c * y - d * z
    product[..., 1] = a * x + b * w + c * z - d * y
    product[..., 2] = a * y - b * z + c * w + d * x
    product[..., 3] = a * z + b * y - c * x + d * w
    return product


def conjugate(orientation: Floats) -> Floats:
    """Return the reverse rotations, shape (..., 4)."""
    reverse: Floats = orientation * np.array((1.0, -1.0, -1.0, -1.0))
    return reverse


def rotate(orientation: Floats, vector: Floats) -> Floats:
    """Return vectors, shape (..., 3), turned by orientations, shape (..., 4): from the sensor's
    axes to the room's.
    """
    w, axis = orientation[..., :1], orientation[..., 1:]
    across = 2.0 * _cross(axis, vector)
    turned: Floats = vector + w * across + _cross(axis, across)
    return turned


def _cross(one: Floats, other: Floats) -> Floats:
    """Return cross products, shape (..., 3). The same numbers as ``numpy.cross``, sooner."""
    a, b, c = one[..., 0], one[..., 1], one[..., 2]
    x, y, z = other[..., 0], other[..., 1], other[..., 2]
    product: Floats = np.empty(np.broadcast_shapes(one.shape, other.shape))
    product[..., 0] = b * z - c * y
    product[..., 1] = c * x - a * z
    product[..., 2] = a * y - b * x
    return product


def from_rotation(rotation: Floats) -> Floats:
    """Return the quaternions, shape (..., 4), of rotation vectors, shape (..., 3): about their
    direction, by their length in rad.
    """
    half = lengths(rotation) / 2.0
    share = np.divide(np.sin(half), 2.0 * half, out=np.full(half.shape, 0.5), where=half > 0)
    orientation: Floats = np.empty((*half.shape, 4))
    orientation[..., 0] = np.cos(half)
    np.multiply(share[..., None], rotation, out=orientation[..., 1:])
    return orientation


def to_rotation(orientation: Floats) -> Floats:
    """Return the rotation vectors, shape (..., 3), of quaternions, the short way round: of at most
    π.
    """
    sign = np.where(orientation[..., :1] < 0, -1.0, 1.0)
    axis = sign * orientation[..., 1:]
    sine = lengths(axis)[..., None]
    angle = 2.0 * np.arctan2(sine, sign * orientation[..., :1])
    rotation: Floats = axis * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
    return rotation


def angle(orientation: Floats) -> Floats:
    """Return the angle of each rotation, shape (...), 0 to π."""
    sine = lengths(orientation[..., 1:])
    found: Floats = 2.0 * np.arctan2(sine, np.abs(orientation[..., 0]))
    return found


def integrate(rate: Floats, step_s: float) -> Floats:
    """Return the orientation at each sample, shape (n, 4), relative to that at the first.

    Between two samples the rate is taken to be constant at their mean (the mid-point rule, exact
    for a rotation about one axis whose rate changes linearly).

    Args:
        rate: angular rate without bias, shape (n, 3), rad/s, in the sensor's axes.
        step_s: time between two samples.
    """
    turned = np.empty((len(rate), 4))
    if not len(rate):
        return turned
    turned[0] = 1.0, 0.0, 0.0, 0.0
    steps = from_rotation((rate[1:] + rate[:-1]) * (step_s / 2.0))
    turned[1:] = _products(steps)
    return turned


def _products(steps: Floats) -> Floats:
    """Return the products of the first, the first two, ... of the steps: in the order of time, to
    the right.
    """
    count = len(steps)
    if count <= _SHORT:
        return _few_products(steps)
    stretches = -(-count // _STRETCH)
    padded = np.zeros((stretches * _STRETCH, 4))
    padded[:, 0] = 1.0
    padded[:count] = steps
    within = padded.reshape(stretches, _STRETCH, 4)
    for index in range(1, _STRETCH):
        within[:, index] = multiply(within[:, index - 1], within[:, index])
    before = _products(within[:-1, -1])
    within[1:] = multiply(before[:, None], within[1:])
    whole: Floats = within.reshape(-1, 4)[:count]
    whole /= np.linalg.norm(whole, axis=1, keepdims=True)
    return whole


def _few_products(steps: Floats) -> Floats:
    """Return the same, composing twice as many in each step.

    A quaternion w + xi + yj + zk is taken as two complex numbers, (w + xi) + (y + zi)j: a third of
    the time.
    """
    pairs = np.ascontiguousarray(steps).view(complex)
    one, other = pairs[:, 0].copy(), pairs[:, 1].copy()
    known = 1
    while known < len(steps):
        left, left_j, right, right_j = one[:-known], other[:-known], one[known:], other[known:]
        longer = left * right - left_j * right_j.conj()
        other[known:] = left * right_j + left_j * right.conj()
        one[known:] = longer
        known *= 2
    products = np.empty((len(steps), 2), dtype=complex)
    products[:, 0], products[:, 1] = one, other
    return products.view(float)
