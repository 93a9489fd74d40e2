"""Movements from rest to rest without a way back."""

import numpy as np
import pytest

from sar_tui.motion.detection import detect_long, detect_one_way
from sar_tui.motion.samples import Recording
from tests.examples import first
from tests.motion.test_faults import samples_of

RATE_HZ = 100.0
OBLIQUE, ACROSS = (0.6, 0.0, 0.8), (0.0, 1.0, 0.0)


def moved(
    *ways: tuple[float, float, float, tuple[float, float, float]], seed: int = 0
) -> Recording:
    """Return a recording of movements (when, duration in s, angle in rad, axis), with noise, bias,
    and rests.
    """
    time_s = np.arange(round((ways[-1][0] + ways[-1][1] + 2.0) * RATE_HZ)) / RATE_HZ
    rate = np.random.default_rng(seed).normal((0.02, -0.01, 0.03), 0.01, (len(time_s), 3))
    for begin_s, lasts_s, angle, axis in ways:
        share = np.clip((time_s - begin_s) / lasts_s, 0.0, 1.0)
        rate += np.outer(angle / lasts_s * 30.0 * (share * (1.0 - share)) ** 2, axis)
    return Recording(time_s, rate)


@pytest.mark.parametrize("seed", first(3, range(20)))
def test_a_movement_is_found_from_rest_to_rest(seed: int) -> None:
    generator = np.random.default_rng([seed, 1])
    begin_s, lasts_s, angle = generator.uniform((2.0, 0.6, 0.4), (3.0, 1.5, 1.5)).tolist()
    (found,) = detect_one_way(moved((begin_s, lasts_s, angle, OBLIQUE), seed=seed))
    assert found.onset_s == pytest.approx(begin_s, abs=0.08)
    assert found.end_s == pytest.approx(begin_s + lasts_s, abs=0.08)
    assert found.out_s == found.reach_time_s
    assert (found.back_s, found.dwell_s, found.sparc_back) == (0.0, 0.0, None)
    assert found.excursion_deg == pytest.approx(np.degrees(angle), abs=2.0)
    assert found.sparc_out == pytest.approx(-1.41, abs=0.05)
    assert found.flags == ()


def test_a_movement_that_comes_back_without_a_rest_and_a_twitch_are_left_out() -> None:
    assert detect_one_way(moved((2.0, 0.8, 0.8, OBLIQUE), (2.8, 0.8, -0.8, OBLIQUE))) == ()
    assert detect_one_way(moved((2.0, 0.5, 0.05, OBLIQUE))) == ()
    assert detect_one_way(Recording(np.empty(0), np.empty((0, 3)))) == ()


def test_each_movement_in_a_recording_of_any_length_is_found_once_about_whatever_axes() -> None:
    found = detect_one_way(
        moved((2.0, 0.8, 0.8, OBLIQUE), (2.5, 0.8, 0.6, ACROSS), (5.0, 1.0, -0.9, OBLIQUE))
    )
    assert [reach.onset_s for reach in found] == pytest.approx([2.0, 5.0], abs=0.08)
    assert found[0].end_s == pytest.approx(3.3, abs=0.08)
    ways = [(2.0 + 6.0 * number, 0.9, (-1) ** number * 0.8, OBLIQUE) for number in range(80)]
    every = detect_long([samples_of(moved(*ways))], window=100, one_way=True).reaches
    assert [reach.onset_s for reach in every] == pytest.approx([way[0] for way in ways], abs=0.08)
