"""Tremor: its share of a movement, its amplitude at rest and in movement, and nothing to
measure.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion.measures import ACTION_HZ, Band, tremor_amplitude, tremor_index
from sar_tui.motion.rest import TREMOR_HZ
from sar_tui.motion.samples import Floats
from sar_tui.motion.synthesis import minimum_jerk

RATE_HZ = 250.0


def about_one_axis(rate: Floats) -> Floats:
    return np.column_stack([0.6 * rate, np.zeros_like(rate), 0.8 * rate])


def reach(way_s: float) -> Floats:
    """Return a smooth way out and back, of 2 rad/s at its fastest."""
    way = 2.0 * minimum_jerk(np.arange(0, way_s, 1 / RATE_HZ) / way_s)
    return np.concatenate([way, -way])


def oscillation(hz: float, samples: int) -> Floats:
    wave: Floats = np.sin(2 * np.pi * hz * np.arange(samples) / RATE_HZ)
    return wave


def measured(value: float | None) -> float:
    assert value is not None
    return value


def test_the_stronger_the_tremor_the_larger_its_share() -> None:
    moving = reach(1.2)
    tremor = oscillation(5, len(moving))
    shares = [
        measured(tremor_index(about_one_axis(moving + size * tremor), 250))
        for size in (0.0, 0.1, 0.5, 50.0)
    ]
    assert shares == sorted(shares)
    assert shares[0] < 0.01
    assert shares[-1] > 0.99


def test_the_bias_of_a_gyroscope_is_not_movement() -> None:
    moving = about_one_axis(reach(1.2))
    biased = moving + np.array([0.1, -0.2, 0.3])
    assert tremor_index(biased, 250) == pytest.approx(tremor_index(moving, 250))
    before, after = (tremor_amplitude(each, 250, TREMOR_HZ) for each in (moving, biased))
    assert after == pytest.approx(before)


@pytest.mark.parametrize(
    ("hz", "band"), [(4.0, TREMOR_HZ), (11.0, TREMOR_HZ), (8.0, ACTION_HZ), (11.0, ACTION_HZ)]
)
def test_the_amplitude_is_that_of_the_oscillation_in_its_band(hz: float, band: Band) -> None:
    shaking = about_one_axis(0.15 * oscillation(hz, 500))
    assert tremor_amplitude(shaking, RATE_HZ, band) == pytest.approx(0.15, rel=0.01)
    slow = about_one_axis(0.15 * oscillation(1.5, 500))
    assert measured(tremor_amplitude(slow, RATE_HZ, band)) < 0.01


@pytest.mark.parametrize("way_s", [0.6, 0.8, 1.2])
def test_action_tremor_is_told_from_a_slow_enough_reach(way_s: float) -> None:
    moving = reach(way_s)
    assert measured(tremor_amplitude(about_one_axis(moving), RATE_HZ, ACTION_HZ)) < 0.025
    shaking = about_one_axis(moving + 0.15 * oscillation(8, len(moving)))
    assert tremor_amplitude(shaking, RATE_HZ, ACTION_HZ) == pytest.approx(0.15, abs=0.01)


@pytest.mark.parametrize(
    "rate", [np.array([]), np.ones(200), np.full(300, np.nan), np.append(np.ones(300), np.inf)],
    ids=["empty", "under a second", "nan", "infinite"],
)  # fmt: skip
def test_tremor_is_none_if_it_cannot_be_measured(rate: Floats) -> None:
    assert tremor_index(about_one_axis(rate), RATE_HZ) is None
    assert tremor_amplitude(about_one_axis(rate), RATE_HZ, TREMOR_HZ) is None


def test_a_steady_rate_has_no_tremor() -> None:
    assert tremor_index(np.ones((300, 3)), 250) is None
    assert tremor_amplitude(np.ones((300, 3)), 250, ACTION_HZ) == 0.0

    assert tremor_amplitude(np.ones((60, 3)), 20.0, ACTION_HZ) is None, "two samples a period"


@given(st.lists(st.floats(0, 1e300), max_size=80), st.sampled_from([0.0, 10.0, 50.0, 100.0, 250.0]))
def test_every_measure_of_tremor_is_finite(values: list[float], rate_hz: float) -> None:
    rate = about_one_axis(np.array(values))
    for value in (tremor_index(rate, rate_hz), tremor_amplitude(rate, rate_hz, TREMOR_HZ)):
        assert value is None or math.isfinite(value)
