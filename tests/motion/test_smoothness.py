"""Smoothness and tremor of a movement: known values, agreement with monalysa, and nothing to
measure.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion import synthesis
from sar_tui.motion.measures import ACTION_HZ, Band, tremor_amplitude, tremor_index
from sar_tui.motion.rest import TREMOR_HZ
from sar_tui.motion.samples import Floats
from sar_tui.motion.smoothness import ldlj, movement_units, sparc

RATE_HZ = 250.0


def minimum_jerk(duration_s: float, rate_hz: float) -> Floats:
    """Return the speed of Flash & Hogan (1985) over a unit distance, without its last sample (which
    is 0).
    """
    share = np.arange(0, duration_s, 1 / rate_hz) / duration_s
    return 30 * share**2 * (1 - share) ** 2 / duration_s


def random_profiles(count: int) -> list[Floats]:
    streams = np.random.default_rng(20)
    return [np.abs(np.cumsum(streams.normal(size=streams.integers(40, 600)))) for _ in range(count)]


def measured(value: float | None) -> float:
    assert value is not None
    return value


def test_minimum_jerk_and_gaussian_movements_have_their_known_smoothness() -> None:
    speed = minimum_jerk(1.0, 100)
    assert sparc(speed, 100) == pytest.approx(-1.4058293244, abs=1e-6)
    assert ldlj(speed, 100) == pytest.approx(-5.2241390675, abs=1e-6)
    speed = np.exp(-5 * np.arange(-1, 1, 0.01) ** 2)
    assert sparc(speed, 100) == pytest.approx(-1.41403, abs=5e-6)
    assert ldlj(speed, 100) == pytest.approx(-5.81636, abs=5e-6)


@pytest.mark.slow
def test_smoothness_agrees_with_monalysa() -> None:
    # imports slowly, in every process that collects tests
    from monalysa.quality import smoothness as monalysa

    for number, speed in enumerate(random_profiles(50)):
        rate_hz = 50.0 + 4 * number
        assert sparc(speed, rate_hz) == pytest.approx(monalysa.sparc(speed, rate_hz)[0], abs=1e-6)
        expected = monalysa.log_dimensionless_jerk(speed, 100.0)
        assert ldlj(speed, 100.0) == pytest.approx(expected, abs=1e-6)


def test_smoothness_depends_hardly_on_the_sampling_rate_and_neither_on_size_nor_on_speed() -> None:
    for rate_hz in (50.0, 125.0, 249.97, 250.0, 1000.0):
        speed = np.exp(-5 * np.arange(-1, 1, 1 / rate_hz) ** 2)
        assert sparc(speed, rate_hz) == pytest.approx(-1.414, abs=0.01)
        assert ldlj(speed, rate_hz) == pytest.approx(-5.816, abs=0.02)
    usual, slow = minimum_jerk(1.0, 100), minimum_jerk(2.0, 100)
    for measure in (sparc, ldlj):
        assert measure(300 * usual, 100) == pytest.approx(measure(usual, 100))
    assert ldlj(slow, 100) == pytest.approx(ldlj(usual, 100), abs=0.1)


def test_a_correction_makes_a_movement_less_smooth_and_adds_a_unit() -> None:
    smooth = minimum_jerk(1.0, 100)
    corrected = np.concatenate([smooth, 0.4 * minimum_jerk(0.4, 100)])
    assert measured(sparc(corrected, 100)) < measured(sparc(smooth, 100))
    assert measured(ldlj(corrected, 100)) < measured(ldlj(smooth, 100))
    assert (movement_units(smooth, 100), movement_units(corrected, 100)) == (1, 2)


def test_a_wobble_a_fall_and_two_peaks_within_150_ms_add_no_movement_unit() -> None:
    time_s = np.arange(0, 1, 0.01)
    wobbling = minimum_jerk(1.0, 100) + 0.05 * (1 + np.sin(2 * np.pi * 5 * time_s))
    assert movement_units(wobbling, 100) == 1
    assert movement_units(np.linspace(1, 0, 100), 100) == 0
    near = np.concatenate([minimum_jerk(0.1, 200), minimum_jerk(0.1, 200)])
    apart = np.concatenate([minimum_jerk(0.2, 200), minimum_jerk(0.2, 200)])
    assert (movement_units(near, 200), movement_units(apart, 200)) == (1, 2)


# --- tremor


def about_one_axis(rate: Floats) -> Floats:
    return np.column_stack([0.6 * rate, np.zeros_like(rate), 0.8 * rate])


def reach(way_s: float) -> Floats:
    """Return a smooth way out and back, of 2 rad/s at its fastest."""
    way = 2.0 * synthesis.minimum_jerk(np.arange(0, way_s, 1 / RATE_HZ) / way_s)
    return np.concatenate([way, -way])


def oscillation(hz: float, samples: int) -> Floats:
    wave: Floats = np.sin(2 * np.pi * hz * np.arange(samples) / RATE_HZ)
    return wave


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


def test_a_steady_rate_has_no_jerk_and_no_tremor() -> None:
    assert ldlj(np.ones(200), 250) is None
    assert tremor_index(np.ones((300, 3)), 250) is None
    assert tremor_amplitude(np.ones((300, 3)), 250, ACTION_HZ) == 0.0

    assert tremor_amplitude(np.ones((60, 3)), 20.0, ACTION_HZ) is None, "two samples a period"


# --- nothing to measure


@pytest.mark.parametrize(
    "speed",
    [np.empty(0), np.ones(4), np.zeros(200), np.full(300, np.nan), np.append(np.ones(300), np.inf)],
    ids=["empty", "short", "under a second", "nan", "infinite"],
)
def test_smoothness_and_tremor_are_none_if_they_cannot_be_measured(speed: Floats) -> None:
    assert sparc(speed, 250) is None
    assert ldlj(speed, 250) is None
    assert movement_units(speed, 250) == 0
    assert tremor_index(about_one_axis(speed), RATE_HZ) is None
    assert tremor_amplitude(about_one_axis(speed), RATE_HZ, TREMOR_HZ) is None


@given(st.lists(st.floats(0, 1e300), max_size=80), st.sampled_from([0.0, 10.0, 50.0, 100.0, 250.0]))
def test_every_measure_is_finite(values: list[float], rate_hz: float) -> None:
    speed = np.array(values)
    rate = about_one_axis(speed)
    tremor = [tremor_amplitude(rate, rate_hz, band) for band in (TREMOR_HZ, ACTION_HZ)]
    for value in (
        sparc(speed, rate_hz),
        ldlj(speed, rate_hz),
        tremor_index(rate, rate_hz),
        *tremor,
    ):
        assert value is None or math.isfinite(value)
    assert movement_units(speed, rate_hz) >= 0
