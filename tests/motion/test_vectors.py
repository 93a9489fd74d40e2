"""Arithmetic of the analysis gives the numbers of numpy's own, which take longer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion.arrays import changes, finite_only, lengths, mean_of, percentile
from sar_tui.motion.boundaries import stretches
from sar_tui.motion.measures import ACTION_HZ, tremor_amplitude, tremor_in_movement, tremor_index
from sar_tui.motion.samples import Floats, Recording
from tests.examples import examples


@pytest.fixture
def vectors() -> Floats:
    return np.random.default_rng(1).normal(size=(700, 3))


def test_lengths_and_means_are_those_of_numpy(vectors: Floats) -> None:
    assert np.array_equal(lengths(vectors), np.linalg.norm(vectors, axis=1))
    apart = vectors[:, None] - vectors[None, :9]
    assert np.array_equal(lengths(apart), np.linalg.norm(apart, axis=2))
    assert np.array_equal(mean_of(vectors), vectors.mean(axis=0))


def test_rows_with_a_number_that_is_not_finite_are_left_out(vectors: Floats) -> None:
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
