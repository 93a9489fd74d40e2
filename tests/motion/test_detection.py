"""Detection and measurement of reaches, by each detector."""

import math
from typing import Literal

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion.detection import DETECTORS, apart, detect
from sar_tui.motion.fixed_threshold import FixedThresholdParameters
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.reach import Bounds, Reach
from sar_tui.motion.samples import Recording
from sar_tui.motion.single_axis import SingleAxisParameters
from sar_tui.motion.synthesis import (
    PROFILES,
    TABLE_4_1,
    Profile,
    ReachShape,
    simulate,
    table_4_1_recording,
)
from tests.examples import examples

NAMES = ["orientation", "single-axis", "fixed-threshold"]
REACH = ReachShape(out_s=0.6, back_s=0.5, dwell_s=0.3, peak_out=2.0, peak_back=-2.4)


def the_reach(
    shape: ReachShape, profile: Profile = PROFILES["clean"], detector: str = "orientation"
) -> Reach:
    (reach,) = detect(simulate([shape], profile).recording, detector)
    return reach


@pytest.mark.parametrize("detector", NAMES)
def test_the_eight_reaches_of_the_table_have_its_amplitudes(detector: str) -> None:
    reaches = detect(table_4_1_recording().recording, detector)
    assert len(reaches) == 8
    for reach, row in zip(reaches, TABLE_4_1, strict=True):
        assert reach.peak_extension_rad_s == pytest.approx(row.peak_extension_rad_s, rel=0.03)
        assert reach.peak_return_rad_s == pytest.approx(row.peak_return_rad_s, rel=0.03)
        assert reach.movement_units_out == reach.movement_units_back == 1


@pytest.mark.parametrize("detector", ["orientation", "single-axis"])
def test_every_time_of_a_reach_is_measured(detector: str) -> None:
    reach = the_reach(REACH, detector=detector)
    assert reach.onset_s == pytest.approx(2.0, abs=0.02)
    assert reach.end_s == pytest.approx(3.4, abs=0.02)
    assert reach.reach_time_s == reach.end_s - reach.onset_s
    assert reach.out_s == pytest.approx(0.6, abs=0.04)
    assert reach.dwell_s == pytest.approx(0.3, abs=0.04)
    assert reach.back_s == pytest.approx(0.5, abs=0.04)
    assert reach.turn_s == pytest.approx(2.75, abs=0.01)
    assert reach.time_to_peak_s == pytest.approx(0.3, abs=0.02)


def test_smoothness_is_measured_per_phase() -> None:
    smooth = the_reach(REACH)
    halting = the_reach(ReachShape(out_s=2, back_s=2, submovements=6, seed=2))
    for reach in (smooth, halting):
        assert None not in (reach.sparc_out, reach.sparc_back, reach.ldlj_out, reach.ldlj_back)
    assert smooth.sparc_out == pytest.approx(-1.4, abs=0.03)
    assert smooth.sparc_back == pytest.approx(-1.4, abs=0.03)
    assert halting.sparc_out is not None
    assert halting.sparc_out < -1.5
    assert halting.movement_units_out > 1
    assert halting.movement_units_back > 1


@pytest.mark.parametrize("hand", ["right", "left"])
def test_extension_is_positive_and_return_negative_for_either_hand(
    hand: Literal["right", "left"],
) -> None:
    made = simulate([REACH], Profile(axis=(0.0, 0.0, -1.0)))
    for detector in NAMES:
        (reach,) = detect(made.recording, detector, hand=hand)
        assert reach.peak_extension_rad_s == pytest.approx(2.0, rel=0.03)
        assert reach.peak_return_rad_s == pytest.approx(-2.4, rel=0.03)
        assert ("reversed" in reach.flags) == (hand == "right")

    tilted = the_reach(REACH, PROFILES["tilted"])
    assert tilted.peak_extension_rad_s == pytest.approx(2.0, rel=0.03)
    assert tilted.peak_return_rad_s == pytest.approx(-2.4, rel=0.03)


def test_faults_of_the_recording_are_flagged_on_its_reaches() -> None:
    assert "saturated" in the_reach(REACH, Profile(saturation_rad_s=2.2)).flags
    elsewhere = msgspec.structs.replace(simulate([REACH]).recording, flags=("gap",))
    assert detect(elsewhere)[0].flags == ()


@pytest.mark.parametrize("detector", NAMES)
def test_an_empty_or_very_short_recording_has_no_reach(detector: str) -> None:
    for count in (0, 1, 2, 5):
        assert detect(Recording(np.arange(count) / 250, np.zeros((count, 3))), detector) == ()
    assert detect(Recording(np.arange(500) / 250, np.full((500, 3), math.nan)), detector) == ()


@pytest.mark.parametrize("detector", NAMES)
@given(
    seed=st.integers(0, 10_000), count=st.integers(2, 900), size=st.sampled_from([0.02, 0.3, 4.0])
)
@examples(60)
def test_every_measure_of_a_random_walk_is_finite_and_in_range(
    detector: str, seed: int, count: int, size: float
) -> None:
    generator = np.random.default_rng(seed)
    rate = size * np.cumsum(generator.standard_normal((count, 3)), axis=0) / 10
    time = np.arange(count) / 250
    kept = generator.random(count) > 0.05
    rate[generator.random(count) > 0.98] = np.nan
    if kept.sum() < 2:
        return
    for reach in detect(Recording(time[kept], rate[kept]), detector):
        assert 0 <= reach.onset_s <= reach.turn_s <= reach.end_s <= time[-1] + 1e-9
        assert min(reach.out_s, reach.dwell_s, reach.back_s) >= -1e-9
        assert reach.peak_return_rad_s <= 0 <= reach.peak_extension_rad_s
        measured = msgspec.structs.asdict(reach)
        assert all(math.isfinite(value) for value in measured.values() if isinstance(value, float))


def test_each_detector_has_a_version_and_its_own_parameters() -> None:
    assert {name: detector.parameters for name, detector in DETECTORS.items()} == {
        "orientation": OrientationParameters,
        "single-axis": SingleAxisParameters,
        "fixed-threshold": FixedThresholdParameters,
    }
    assert all(detector.version for detector in DETECTORS.values())
    recording = simulate([REACH]).recording
    assert detect(recording, "fixed-threshold", FixedThresholdParameters(threshold_rad_s=3.0)) == ()
    assert detect(recording, "single-axis", SingleAxisParameters(least_rad=2.0)) == ()
    with pytest.raises(ValueError, match="takes SingleAxisParameters, not FixedThreshold"):
        detect(recording, "single-axis", FixedThresholdParameters())

    with pytest.raises(ValueError, match="no detector named 'best'; there are: orientation, sin"):
        detect(recording, "best")


@pytest.mark.parametrize(
    ("found", "since_s", "kept"),
    [
        ([(3.0, 4.0), (1.0, 2.0)], 0.0, [(1.0, 2.0), (3.0, 4.0)]),
        ([(1.0, 2.0), (1.96, 3.0)], 0.0, [(1.0, 2.0), (2.0, 3.0)]),
        ([(1.0, 2.0), (1.0, 2.0), (1.2, 3.0), (3.5, 4.0)], 0.0, [(1.0, 2.0), (3.5, 4.0)]),
        ([(1.0, 2.0), (1.95, 2.04)], 0.0, [(1.0, 2.0)]),
        ([(1.0, 2.0), (2.5, 3.0)], 1.5, [(2.5, 3.0)]),
        ([(1.0, 2.0)], 1.05, [(1.05, 2.0)]),
    ],
    ids=[
        "with a rest between",
        "estimated boundaries meet",
        "the same movement again",
        "hardly anything is left",
        "found before",
        "a little found before",
    ],
)
def test_no_part_of_a_recording_belongs_to_two_reaches(
    found: list[tuple[float, float]], since_s: float, kept: list[tuple[float, float]]
) -> None:
    reaches = []
    for onset_s, end_s in found:
        turn_s = (onset_s + end_s) / 2
        times = {"onset_s": onset_s, "arrival_s": turn_s, "departure_s": turn_s, "end_s": end_s}
        reaches.append(Bounds(**times, axis=(0.0, 0.0, 1.0)))
    assert [(reach.onset_s, reach.end_s) for reach in apart(reaches, since_s)] == kept
