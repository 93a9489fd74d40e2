"""The detector of the thesis has the results and the known faults of the thesis."""

import math

import numpy as np
import pytest

from sar_tui.motion.fixed_threshold import FixedThresholdParameters, find
from sar_tui.motion.reach import Bounds
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import (
    PROFILES,
    TABLE_4_1,
    Profile,
    ReachShape,
    simulate,
    table_4_1_recording,
)

REACH = ReachShape(out_s=0.6, back_s=0.5, peak_out=2.0, peak_back=-2.4)


def turning(*stretches: tuple[float, float]) -> Recording:
    """Return a recording of stretches (duration in s, rate about z in rad/s), at 100 Hz."""
    z = np.concatenate([np.full(round(seconds * 100), float(rate)) for seconds, rate in stretches])
    return Recording(np.arange(len(z)) / 100, np.column_stack((z * 0, z * 0, z)))


def times(reaches: tuple[Bounds, ...]) -> list[tuple[float, float]]:
    return [(round(reach.onset_s, 6), round(reach.end_s, 6)) for reach in reaches]


def test_a_reach_lasts_from_the_threshold_to_the_beginning_of_the_rest() -> None:
    found = find(turning((1, 0.1), (0.5, 0.11), (1, 0.1)))
    assert times(found.reaches) == [(1.0, 1.5)]
    assert found.reaches[0].flags == ()
    assert find(turning((2, 0.1))).reaches == ()


def test_a_rest_of_800_ms_or_as_set_ends_a_reach_and_a_shorter_one_does_not() -> None:
    for rest_s, expected in ((0.8, [(1.0, 2.0), (2.8, 3.8)]), (0.79, [(1.0, 3.79)])):
        found = find(turning((1, 0), (1, 1), (rest_s, 0), (1, -1), (1, 0)))
        assert times(found.reaches) == expected
    parameters = FixedThresholdParameters(threshold_rad_s=0.5, still_ms=200)
    found = find(turning((1, 0.4), (1, 1), (0.3, 0.4), (1, 1), (1, 0)), parameters)
    assert times(found.reaches) == [(1.0, 2.0), (2.3, 3.3)]


def test_a_reach_that_the_recording_cuts_off_is_endless() -> None:
    found = find(turning((1, 0), (1, 1), (0.5, 0)))
    assert times(found.reaches) == [(1.0, 2.49)]
    assert found.reaches[0].flags == ("endless",)
    assert times(find(turning((2, 1.0))).reaches) == [(0.0, 1.99)], "from the first sample on"


def test_it_turns_where_the_rate_changes_sign() -> None:
    (reach,) = find(turning((1, 0), (1, 1), (0.2, 0), (0.5, -2), (1, 0))).reaches
    assert reach.arrival_s == pytest.approx(1.99)
    assert reach.departure_s == pytest.approx(2.2)


def test_it_finds_the_eight_reaches_of_the_table_up_to_130_ms_short() -> None:
    found = find(table_4_1_recording().recording).reaches
    assert len(found) == 8
    for reach, row in zip(found, TABLE_4_1, strict=True):
        assert -0.13 < reach.end_s - reach.onset_s - row.reach_time_s < 0


@pytest.mark.parametrize(
    "profile",
    [PROFILES["biased"], PROFILES["tremor"], Profile(noise_rad_s=math.radians(5))],
    ids=["bias", "tremor", "noise"],
)
def test_bias_tremor_or_noise_make_it_endless(profile: Profile) -> None:
    assert find(simulate([REACH], profile).recording).reaches[-1].flags[0] == "endless"


def test_the_last_sample_may_lie_beyond_the_grid_and_one_that_is_no_number_is_left_out() -> None:
    recording = turning((1, 0), (1, 1), (1, 0))
    recording.rate[150] = np.nan
    assert times(find(recording).reaches) == [(1.0, 2.0)]
    time_s = np.append(np.arange(0, 3, 0.01), 3.006)
    rate = np.zeros((301, 3))
    rate[-1, 2] = 0.2
    (found,) = find(Recording(time_s, rate)).reaches
    assert (found.onset_s, found.flags) == (3.006, ("endless",))
