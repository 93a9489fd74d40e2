"""Measures of a reach and of the trunk, against the truth of simulated trajectories; phases;
tremor.
"""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.measures import smoothness
from benchmarks.true_measures import (
    Z,
    at_true_times,
    bounds_of,
    measured_between,
    true_measures,
    true_trunk_excursion_deg,
)
from sar_tui.motion.detection import detect
from sar_tui.motion.imperfections import PERFECT, StrappedSensor
from sar_tui.motion.reach import Bounds, Reach
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import PROFILES, TABLE_4_1, Profile, ReachShape, TableRow, simulate
from sar_tui.motion.trajectories import PLACEMENTS, SimulatedReaches, simulate_reaches
from sar_tui.perception.reach import trunk_excursion_deg
from tests.examples import examples, first

ONE_AXIS = ReachShape(out_s=1.0, back_s=1.0, dwell_s=0.3, peak_out=1.5, peak_back=-1.5)
LARGEST_ERRORS = {"excursion_deg": 0.5, "straightness": 0.06, "return_error_deg": 0.5}
LARGEST_ERRORS |= {"inclination_rest_deg": 1.2, "inclination_target_deg": 1.2}


def measured(recording: Recording, bounds: Bounds | None = None, *, by_norm: bool = True) -> Reach:
    return measured_between(recording, bounds or bounds_of(ONE_AXIS), by_norm=by_norm)


@pytest.mark.parametrize("kind", first(3, list(KINDS)))
@pytest.mark.parametrize("seed", [1, 2])
def test_angles_of_any_reach_are_those_of_its_trajectory(kind: str, seed: int) -> None:
    arm = "left" if seed == 2 else "right"
    simulated = simulate_reaches(kind, seed, placement=seed, arm=arm, rate_hz=100.0)
    reach, truth = at_true_times(simulated), true_measures(simulated, simulated)
    for name, within in LARGEST_ERRORS.items():
        assert getattr(reach, name) == pytest.approx(truth[name], abs=within)


@pytest.mark.parametrize("kind", first(2, [kind for kind in KINDS if kind != "point-and-hold"]))
def test_smoothness_of_the_norm_does_not_depend_on_noise_or_on_the_sensor_s_place(
    kind: str,
) -> None:
    ideal = at_true_times(simulate_reaches(kind, 3, rate_hz=100.0, imperfections=PERFECT))
    worn = StrappedSensor(noise_rad_s=math.radians(0.3), bias_rad_s=(0.03, -0.03, 0.02))
    other = at_true_times(simulate_reaches(kind, 3, rate_hz=100.0, placement=2, imperfections=worn))
    for way in ("sparc_out", "sparc_back"):
        assert getattr(other, way) == pytest.approx(getattr(ideal, way), abs=0.05)
    assert other.peak_extension_rad_s == pytest.approx(ideal.peak_extension_rad_s, rel=0.03)
    assert other.peak_return_rad_s == pytest.approx(ideal.peak_return_rad_s, rel=0.03)


def test_about_one_axis_the_norm_measures_what_the_axis_does() -> None:
    recording = simulate([ONE_AXIS]).recording
    by_norm, by_axis = measured(recording), measured(recording, by_norm=False)
    peaks = ("peak_extension_rad_s", "peak_return_rad_s", "time_to_peak_s")
    for name in (*peaks, "sparc_out", "sparc_back"):
        assert getattr(by_norm, name) == pytest.approx(getattr(by_axis, name), rel=1e-3)
    assert by_norm.movement_units_out == by_norm.movement_units_back == 1


def test_a_turn_about_one_axis_is_straight_and_without_a_way_back_has_no_error_of_return() -> None:
    reach = measured(simulate([ONE_AXIS], PROFILES["biased"]).recording)
    assert reach.straightness == pytest.approx(1.0, abs=1e-3)
    assert reach.excursion_deg == pytest.approx(math.degrees(1.5 * 8 / 15), abs=0.2)
    assert reach.return_error_deg == pytest.approx(0.0, abs=0.2)
    one_way = msgspec.structs.replace(bounds_of(ONE_AXIS), departure_s=3.0, end_s=3.0)
    reach = measured(simulate([ONE_AXIS]).recording, one_way)
    assert (reach.return_error_deg, reach.sparc_back, reach.ldlj_back) == (None, None, None)
    assert reach.excursion_deg == pytest.approx(math.degrees(0.8), abs=0.3)
    assert reach.peak_return_rad_s == pytest.approx(0.0, abs=1e-6)
    assert (reach.turn_s, reach.movement_units_back) == (reach.end_s, 0)


def test_inclination_needs_an_accelerometer_and_a_rest_before_the_reach() -> None:
    recording = simulate([ONE_AXIS]).recording
    assert measured(recording).inclination_rest_deg == pytest.approx(0.0, abs=0.3)
    without = msgspec.structs.replace(recording, acceleration=None)
    restless = measured(recording, bounds_of(ONE_AXIS, onset_s=2.6))
    for reach in (measured(without), restless):
        assert (reach.inclination_rest_deg, reach.inclination_target_deg) == (None, None)
        assert reach.excursion_deg is not None


# --- phases


@given(times=st.lists(st.floats(-0.5, 6.5), min_size=4, max_size=4), by_norm=st.booleans())
@examples(60)
def test_phases_never_overlap_and_a_peak_lies_in_its_way_out(
    times: list[float], by_norm: bool
) -> None:
    onset_s, arrival_s, departure_s, end_s = times
    bounds = Bounds(
        onset_s=onset_s, arrival_s=arrival_s, departure_s=departure_s, end_s=end_s, axis=Z
    )
    recording = simulate([ONE_AXIS], PROFILES["steady"], rate_hz=50).recording
    reach = measured(recording, bounds, by_norm=by_norm)
    arrival_s, departure_s = reach.onset_s + reach.out_s, reach.end_s - reach.back_s
    assert reach.onset_s <= arrival_s <= reach.turn_s + 1e-9
    assert reach.turn_s <= departure_s + 1e-9 <= reach.end_s + 2e-9
    assert 0 <= reach.time_to_peak_s <= reach.out_s
    assert reach.out_s + reach.dwell_s + reach.back_s == pytest.approx(reach.reach_time_s)


@pytest.mark.parametrize("detector", ["orientation", "single-axis"])
@pytest.mark.parametrize("row", TABLE_4_1[::3], ids=lambda row: row.type)
def test_a_reach_without_a_rest_at_its_target_turns_where_it_turns(
    row: TableRow, detector: str
) -> None:
    (reach,) = detect(simulate([row.shape], PROFILES["steady"]).recording, detector)
    assert reach.dwell_s == 0.0
    assert reach.out_s == pytest.approx(row.shape.out_s, abs=0.03)
    assert reach.turn_s == pytest.approx(2.0 + row.shape.out_s, abs=0.02)


def test_the_peak_is_sought_on_the_way_out_and_a_way_too_short_has_no_smoothness() -> None:
    early = msgspec.structs.replace(bounds_of(ONE_AXIS), arrival_s=2.3)
    reach = measured(simulate([ONE_AXIS]).recording, early, by_norm=False)
    assert reach.time_to_peak_s / reach.out_s == pytest.approx(1.0, abs=0.02)
    short = ReachShape(out_s=0.12, back_s=0.5, peak_out=8.0, peak_back=-2.0)
    reach = measured(simulate([short]).recording, bounds_of(short), by_norm=False)
    assert (reach.sparc_out, reach.ldlj_out) == (None, None)
    assert reach.sparc_back is not None


# --- tremor


@pytest.mark.parametrize(("hz", "rad_s"), [(4.5, 0.2), (5.0, 1.0), (9.0, 0.2)])
def test_tremor_at_rest_is_measured_and_removed_from_movement_units_and_path(
    hz: float, rad_s: float
) -> None:
    profile = Profile(tremor_hz=hz, tremor_rad_s=rad_s)
    reach = measured(simulate([ONE_AXIS], profile, seed=2).recording)
    assert reach.tremor_rest_hz == pytest.approx(hz, abs=0.3)
    across = 0.5
    assert reach.tremor_rest_rad_s == pytest.approx(rad_s * math.hypot(1.0, across), rel=0.05)
    assert reach.movement_units_out == reach.movement_units_back == 1
    assert reach.straightness == pytest.approx(1.0, abs=0.05)
    assert reach.inclination_rest_deg == pytest.approx(0.0, abs=1.0)


def test_tremor_in_movement_alone_is_measured_and_not_removed() -> None:
    shaking = StrappedSensor(action_tremor_hz=8.0, action_tremor_rad_s=0.4)
    simulated = (
        simulate_reaches("trunk-lean", 3, imperfections=sensor) for sensor in (PERFECT, shaking)
    )
    steady, shaky = (at_true_times(one) for one in simulated)
    assert (shaky.tremor_rest_hz, steady.tremor_rest_hz) == (None, None)
    assert shaky.tremor_rest_rad_s == pytest.approx(0.0, abs=0.01)
    assert steady.tremor_action_rad_s == pytest.approx(0.0, abs=0.01)
    assert shaky.tremor_action_rad_s == pytest.approx(0.42, abs=0.08)
    assert shaky.movement_units_out > steady.movement_units_out


# --- smoothness and the sensor


@pytest.mark.slow
def test_sparc_depends_on_neither_rate_nor_noise_and_ldlj_on_both() -> None:
    expected = {
        0.0: pytest.approx([-5.13, -5.21, -5.25, -5.27], abs=0.03),
        1.0: pytest.approx([-6.7, -6.8, -6.2, -5.6], abs=0.3),
    }
    for noise_deg_s, ldlj in expected.items():
        found = [
            smoothness(rate_hz, noise_deg_s, recordings=5)
            for rate_hz in (50.0, 100.0, 250.0, 1000.0)
        ]
        assert [sparc for sparc, _ in found] == pytest.approx([-1.405] * 4, abs=0.01)
        assert [each for _, each in found] == ldlj


# --- excursion of the trunk


def lean(seed: int, placement: int = 0) -> tuple[SimulatedReaches, Recording]:
    made = simulate_reaches("trunk-lean", seed, placement=placement, sternum=True)
    assert made.sternum is not None
    return made, made.sternum


@pytest.mark.parametrize("placement", range(len(PLACEMENTS)))
def test_a_lean_is_measured_within_two_degrees_wherever_the_sensor_sits(placement: int) -> None:
    for seed in range(5):
        made, sternum = lean(seed, placement)
        excursion = trunk_excursion_deg(sternum, *made.truth[0])
        assert excursion == pytest.approx(true_trunk_excursion_deg(made), abs=2.0)


def test_a_sensor_lost_within_the_reach_or_never_at_rest_gives_no_excursion() -> None:
    made, sternum = lean(4)
    onset, end = made.truth[0]
    time = sternum.time_s
    middle = (onset + end) / 2.0
    hole = (time < middle) | (time > middle + 0.3)
    restless = abs(time - middle) < end - middle + 0.2
    for kept in (time < middle, time > middle, hole, time < 0.0, restless):
        rest = Recording(time_s=time[kept], rate=sternum.rate[kept])
        assert trunk_excursion_deg(rest, onset, end) is None
