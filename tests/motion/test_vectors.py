"""Arithmetic of the analysis gives the numbers of numpy's and scipy's own, which take longer."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sar_tui.motion import quaternions
from sar_tui.motion.arrays import changes, finite_only, lengths, mean_of, percentile
from sar_tui.motion.boundaries import stretches
from sar_tui.motion.measures import ACTION_HZ, tremor_amplitude, tremor_in_movement, tremor_index
from sar_tui.motion.samples import Floats, Recording
from tests.examples import examples


@pytest.fixture
def vectors() -> Floats:
    return np.random.default_rng(1).normal(size=(700, 3))


def test_lengths_and_means_are_those_of_numpy_and_rows_that_are_not_finite_are_left_out(
    vectors: Floats,
) -> None:
    assert np.array_equal(lengths(vectors), np.linalg.norm(vectors, axis=1))
    apart = vectors[:, None] - vectors[None, :9]
    assert np.array_equal(lengths(apart), np.linalg.norm(apart, axis=2))
    assert np.array_equal(mean_of(vectors), vectors.mean(axis=0))
    time_s = np.arange(700.0)
    assert finite_only(time_s, vectors)[1] is vectors
    vectors[3, 1], vectors[9, 2] = np.nan, np.inf
    found, rows = finite_only(time_s, vectors)
    assert (len(rows), set(time_s) - set(found)) == (698, {3.0, 9.0})


@examples(100)
@given(
    st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=60),
    st.sampled_from((0, 5, 50, 95, 99, 100)),
)
def test_a_percentile_is_that_of_numpy(values: list[float], share: float) -> None:
    assert percentile(np.array(values), share) == np.percentile(values, share)


@examples(100)
@given(st.lists(st.floats(0.001, 1.0), min_size=1, max_size=60))
def test_the_rate_of_a_recording_is_that_of_the_median_step(steps: list[float]) -> None:
    time_s = np.cumsum([0.0, *steps])
    recording = Recording(time_s, np.zeros((len(time_s), 3)))
    assert recording.rate_hz == 1.0 / float(np.median(np.diff(time_s)))


@examples(100)
@given(st.lists(st.booleans(), max_size=40), st.integers(1, 5))
def test_changes_and_stretches_of_a_mask(values: list[bool], longest: int) -> None:
    mask = np.array(values, dtype=bool)
    found = changes(mask).reshape(-1, 2).tolist()
    inside = [index for first, last in found for index in range(first, last)]
    assert inside == np.flatnonzero(mask).tolist()
    for part in stretches(mask, longest):
        assert mask[part.start]
        assert mask[part.stop - 1]
        rests = changes(~mask[part]).reshape(-1, 2)
        assert (np.diff(rests) < longest).all()


@pytest.mark.parametrize("count", [100, 131, 337])
def test_one_transform_gives_both_measures_of_tremor(vectors: Floats, count: int) -> None:
    index, amplitude = tremor_in_movement(vectors[:count], 100.0)
    assert index == tremor_index(vectors[:count], 100.0)
    assert amplitude == pytest.approx(tremor_amplitude(vectors[:count], 100.0, ACTION_HZ))


# --- orientations


def of_scipy(orientation: Floats) -> Rotation:
    """Return an orientation as scipy's, whose quaternions have the scalar last."""
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
