"""The single-axis detector: it finds and times a reach of any hand with any sensor."""

import math
from itertools import pairwise
from statistics import median

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion.filters import Lowpass, smooth
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.reach import Bounds
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.segmenter import Segmenter, home_since
from sar_tui.motion.single_axis import SingleAxisParameters, find
from sar_tui.motion.synthesis import (
    PROFILES,
    TABLE_4_1,
    Profile,
    ReachShape,
    Scenario,
    SimulatedHand,
    Simulation,
    scenarios,
    simulate,
    table_4_1_recording,
)
from tests.examples import examples, fewer

SEEDS = range(fewer(40))
SECOND = 1_000_000_000
NOISY = Profile(noise_rad_s=0.01)
REACH = ReachShape(out_s=0.6, back_s=0.5, peak_out=2.0, peak_back=-2.4)
PAUSED = ReachShape(out_s=0.6, back_s=0.5, dwell_s=1.2, peak_out=2.0, peak_back=-2.4)


def duration(reach: Bounds) -> float:
    return reach.end_s - reach.onset_s


def part(recording: Recording, from_s: float = 0.0, to_s: float = math.inf) -> Recording:
    used = (recording.time_s >= from_s) & (recording.time_s < to_s)
    return Recording(recording.time_s[used], recording.rate[used])


def the_reach(made: Simulation) -> Bounds:
    (reach,) = find(made.recording).reaches
    return reach


# --- realistic recordings


@pytest.mark.parametrize("scenario", scenarios(), ids=lambda scenario: scenario.name)
def test_one_reach_is_found_as_one_and_timed_without_bias(scenario: Scenario) -> None:
    errors = []
    for seed in SEEDS:
        made = scenario.make(seed)
        onset, end = made.truth[0]
        reach = the_reach(made)
        assert not {"timed_out", "cut", "reversed"} & set(reach.flags)
        errors.append(duration(reach) - (end - onset))
    assert abs(median(errors)) < 0.05


def test_the_eight_reaches_of_the_table_are_timed_within_40_ms() -> None:
    found = find(table_4_1_recording().recording).reaches
    assert len(found) == 8
    for reach, row in zip(found, TABLE_4_1, strict=True):
        assert duration(reach) == pytest.approx(row.reach_time_s, abs=0.04)


@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 100.0, 1000.0])
def test_a_reach_is_timed_at_any_rate(rate_hz: float) -> None:
    reach = the_reach(simulate([REACH], NOISY, rate_hz=rate_hz))
    assert duration(reach) == pytest.approx(1.1, abs=0.06)
    assert ("low_rate" in reach.flags) == (rate_hz < 32)


def test_too_few_samples_a_second_are_refused_with_a_reason() -> None:
    with pytest.raises(ValueError, match=r"gives 4 samples a second; .* at least 20"):
        find(simulate([REACH], rate_hz=4).recording)
    with pytest.raises(ValueError, match="at least 20"):
        Segmenter(0.0)


# --- other movements


OTHER_MOVEMENTS = {
    "a flick of the wrist": ReachShape(out_s=0.08, back_s=0.08, peak_out=2.0, peak_back=-2.0),
    "out and never back": ReachShape(out_s=0.8, back_s=0.5, peak_out=2.0, peak_back=-1e-9),
    "hardly any turning": ReachShape(out_s=0.6, back_s=0.5, peak_out=0.05, peak_back=-0.06),
    "a rest of 4 s between": ReachShape(out_s=0.6, back_s=0.5, dwell_s=4.0),
}


def test_neither_other_movements_nor_a_hand_at_rest_are_reaches() -> None:
    for name, shape in OTHER_MOVEMENTS.items():
        assert find(simulate([shape], NOISY).recording).reaches == (), name
    for name, profile in PROFILES.items():
        assert find(simulate([], profile, rest_s=20).recording).reaches == (), name


# --- phases and sides


def test_the_hand_arrives_rests_and_departs() -> None:
    reach = the_reach(simulate([PAUSED], NOISY))
    assert reach.arrival_s == pytest.approx(2.6, abs=0.02)
    assert reach.departure_s == pytest.approx(3.8, abs=0.02)


@pytest.mark.parametrize(
    ("axis", "hand", "flags"),
    [
        ((0.0, 0.0, 1.0), "right", ()),
        ((0.0, 0.0, -1.0), "right", ("reversed",)),
        ((0.0, 0.0, -1.0), "left", ()),
        ((0.0, 0.0, 1.0), "left", ("reversed",)),
        ((1.0, 0.0, -0.1), "right", ()),
        ((-0.6, 0.8, 0.0), "left", ()),
    ],
)
def test_the_outward_phase_is_positive_about_the_axis_for_either_side(
    axis: tuple[float, float, float], hand: str, flags: tuple[str, ...]
) -> None:
    made = simulate([REACH], Profile(noise_rad_s=0.005, axis=axis))
    (reach,) = find(made.recording, hand="left" if hand == "left" else "right").reaches
    assert reach.axis == pytest.approx(np.array(axis) / np.linalg.norm(axis), abs=0.01)
    assert reach.flags == flags


# --- imperfect recordings


def test_a_reach_without_a_still_second_before_it_is_found_and_flagged() -> None:
    made = simulate([REACH], PROFILES["biased"])
    for rest_s in (0.0, 0.3, 0.7):
        (reach,) = find(part(made.recording, from_s=2 - rest_s)).reaches
        assert "no_rest" in reach.flags
        assert duration(reach) == pytest.approx(1.1, abs=0.02)
    five = find(simulate([REACH] * 5, PROFILES["biased"], rest_s=0.2).recording).reaches
    assert [duration(reach) for reach in five] == [pytest.approx(1.1, abs=0.05)] * 5
    assert all("no_rest" in reach.flags for reach in five)


@pytest.mark.parametrize("to_s", [2.95, 3.05])
def test_a_reach_that_the_recording_cuts_off_ends_with_it(to_s: float) -> None:
    (reach,) = find(part(simulate([REACH], NOISY).recording, to_s=to_s)).reaches
    assert "cut" in reach.flags
    assert reach.end_s == pytest.approx(to_s, abs=0.005)


def test_a_reach_longer_than_the_longest_is_ended() -> None:
    recording = simulate([PAUSED], NOISY).recording
    (reach,) = find(recording, SingleAxisParameters(longest_s=2.0)).reaches
    assert "timed_out" in reach.flags
    assert duration(reach) == pytest.approx(2.0)
    assert reach.departure_s <= reach.end_s


def test_a_gap_in_the_reach_is_flagged_and_neither_one_at_rest_nor_samples_that_are_no_number() -> (
    None
):
    recording = simulate([REACH], NOISY).recording
    for from_s, flags in ((2.3, ("gap",)), (1.0, ())):
        used = (recording.time_s < from_s) | (recording.time_s >= from_s + 0.12)
        (reach,) = find(Recording(recording.time_s[used], recording.rate[used])).reaches
        assert reach.flags == flags
    recording.rate[::7, 1] = np.nan
    (reach,) = find(recording).reaches
    assert duration(reach) == pytest.approx(1.1, abs=0.02)


# --- filters


def test_a_low_pass_keeps_a_bias_and_halves_the_power_at_its_cutoff() -> None:
    lowpass = Lowpass(8.0, 250.0)
    assert lowpass.filter([(0.3, 0.0, -0.1)] * 50) == [pytest.approx((0.3, 0.0, -0.1))] * 50
    wave = np.sin(2 * np.pi * 8 * np.arange(2000) / 250)
    lowpass = Lowpass(8.0, 250.0)
    passed = np.array(lowpass.filter([(0.0, value, 2 * value) for value in wave.tolist()]))
    expected = [0.0, math.sqrt(0.5), math.sqrt(2.0)]
    assert passed[1000:].max(axis=0) == pytest.approx(expected, abs=0.01)


def test_filters_add_no_delay_and_a_notch_removes_a_tremor() -> None:
    time = np.arange(2000)[:, None] / 250
    bump = np.exp(-0.5 * ((time - 4) / 0.15) ** 2)
    assert smooth(bump, 250, 8.0) == pytest.approx(bump, abs=0.002)
    tremor = np.sin(2 * np.pi * 5 * time)
    assert np.abs(smooth(bump + tremor, 250, 8.0, 5.0) - bump)[200:-200].max() < 0.02


# --- live


def states(recording: Recording, cuts: list[int]) -> list[tuple[bool, float, float | None, bool]]:
    """Return a segmenter's state at the end of each block."""
    segmenter, reported = Segmenter(250.0), []
    edges = [0, *cuts, len(recording.time_s)]
    for first, last in pairwise(edges):
        segmenter.push(recording.time_s[first:last], recording.rate[first:last])
        state = segmenter.moving, segmenter.still_for_s, segmenter.began_s, segmenter.returned
        reported.append(state)
    return reported


LIVE = simulate([REACH], PROFILES["patient"]).recording
BY_SAMPLE = states(LIVE, list(range(1, len(LIVE.time_s))))


@given(cuts=st.lists(st.integers(1, len(LIVE.time_s)), max_size=10).map(sorted))
@examples(25)
def test_live_states_do_not_depend_on_the_blocks_that_samples_come_in(cuts: list[int]) -> None:
    expected = [BY_SAMPLE[cut - 1] for cut in [*cuts, len(LIVE.time_s)]]
    assert states(LIVE, cuts) == expected


def watched(made: Simulation) -> tuple[list[float], Segmenter]:
    """Return the times (s) at which a segmenter finds the hand back and still for 0.8 s, asked
    every 20 ms.
    """
    segmenter, over = Segmenter(250.0), []
    for first in range(0, len(made.recording.time_s), 5):
        block = slice(first, first + 5)
        segmenter.push(made.recording.time_s[block], made.recording.rate[block])
        if segmenter.has_reached(made.truth[0][0] - 0.3) and segmenter.still_for_s >= 0.8:
            over.append(float(made.recording.time_s[block][-1]))
    return over, segmenter


@pytest.mark.parametrize(
    "scenario",
    [scenario for scenario in scenarios() if scenario.name != "all combined"],
    ids=lambda scenario: scenario.name,
)
def test_the_end_of_a_reach_is_detected_in_time(scenario: Scenario) -> None:
    for seed in range(4):
        made = scenario.make(seed)
        over, segmenter = watched(made)
        assert made.truth[0][1] + 0.2 < over[0] < made.truth[0][1] + 1.4
        assert segmenter.began_s == pytest.approx(made.truth[0][0], abs=0.4)
        assert not segmenter.moving


def test_a_pause_at_the_target_is_not_the_end_and_an_earlier_reach_does_not_count() -> None:
    assert watched(simulate([PAUSED], NOISY))[0][0] > 4.3 + 0.7
    _, segmenter = watched(simulate([REACH], NOISY))
    assert [segmenter.has_reached(since_s) for since_s in (1.8, 2.9, 3.5)] == [True, False, False]


def test_the_rest_before_a_trial_begins_after_the_last_movement_if_there_was_one() -> None:
    hand = SimulatedHand(PROFILES["steady"], 250.0)
    hand.move(2 * SECOND, REACH)
    samples, parameters = hand.samples(0, 5 * SECOND), OrientationParameters()
    came_ns = home_since(samples, 4 * SECOND, parameters)
    assert came_ns == pytest.approx(3.2 * SECOND, abs=0.1 * SECOND)
    assert home_since(samples[:450], SECOND, parameters) is None, "it has not moved before"
    assert home_since(samples[:700], round(2.7 * SECOND), parameters) is None, "it does not rest"


def test_a_bias_that_jumps_is_learnt_after_the_time_out() -> None:
    time: Floats = np.arange(250 * 12) / 250
    rate = np.zeros((len(time), 3))
    rate[time > 3] = 0.4
    segmenter = Segmenter(250.0, SingleAxisParameters(longest_s=4.0))
    segmenter.push(time[time <= 5], rate[time <= 5])
    assert segmenter.moving
    segmenter.push(time[time > 5], rate[time > 5])
    assert not segmenter.moving
    assert segmenter.still_for_s > 3
