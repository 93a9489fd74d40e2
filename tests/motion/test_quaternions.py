"""Orientations, compared with those of scipy, whose quaternions have the scalar last."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sar_tui.motion import quaternions
from sar_tui.motion.samples import Floats


@pytest.fixture
def vectors() -> Floats:
    """Return 500 random vectors."""
    return np.random.default_rng(1).normal(size=(500, 3))


def of_scipy(orientation: Floats) -> Rotation:
    return Rotation.from_quat(np.roll(orientation, -1, axis=-1))


def test_rotation_vectors_become_orientations_and_back(vectors: Floats) -> None:
    orientation = quaternions.from_rotation(vectors)
    expected = Rotation.from_rotvec(vectors)
    assert (of_scipy(orientation).inv() * expected).magnitude().max() < 1e-12
    assert np.allclose(quaternions.to_rotation(orientation), expected.as_rotvec())
    assert np.allclose(quaternions.angle(orientation), expected.magnitude())
    assert quaternions.from_rotation(np.zeros((1, 3))).tolist() == [[1.0, 0.0, 0.0, 0.0]]


def test_products_and_turned_vectors_are_those_of_scipy(vectors: Floats) -> None:
    one, other = quaternions.from_rotation(vectors), quaternions.from_rotation(vectors[::-1])
    product = quaternions.multiply(one, other)
    assert np.allclose(of_scipy(product).as_matrix(), (of_scipy(one) * of_scipy(other)).as_matrix())
    assert np.allclose(quaternions.rotate(one, vectors[::-1]), of_scipy(one).apply(vectors[::-1]))
    assert np.allclose(quaternions.multiply(one, quaternions.conjugate(one)), (1.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("count", [0, 1, 2, 33, 500])
def test_an_integrated_rate_composes_small_rotations_in_the_sensor_axes(
    vectors: Floats, count: int
) -> None:
    rate = vectors[:count]
    expected = [Rotation.identity()]
    for before, after in pairwise(rate):
        expected.append(expected[-1] * Rotation.from_rotvec((before + after) * 0.005))
    orientation = quaternions.integrate(rate, 0.01)
    assert orientation.shape == (count, 4)
    for found, true in zip(orientation, expected, strict=False):
        assert (of_scipy(found).inv() * true).magnitude() < 1e-9


def test_a_rotation_about_one_axis_turns_by_the_integral_of_its_rate() -> None:
    time = np.arange(0, 2, 0.01)
    rate = np.outer(np.sin(time), (0.0, 0.6, 0.8))
    turned = quaternions.angle(quaternions.integrate(rate, 0.01))
    assert np.allclose(turned, 1 - np.cos(time), atol=1e-4)
