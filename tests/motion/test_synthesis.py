"""The simulated hand: its samples are those of a real sensor on such a hand."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sar_tui.motion.synthesis import (
    PROFILES,
    TABLE_4_1,
    Profile,
    ReachShape,
    SimulatedHand,
    simulate,
    table_4_1_recording,
    waveform,
)
from tests.examples import examples

SECOND = 1_000_000_000
REACH = ReachShape(out_s=0.5, back_s=0.5, dwell_s=0.2, peak_out=2.0, peak_back=-2.0)
HALFWAY = ReachShape(out_s=0.5, back_s=0.5, peak_out=2.0, peak_back=-1.0)
"""A reach that leaves the hand turned."""


def a_hand(
    profile: str = "patient", seed: int = 3, rate_hz: float = 250.0, shape: ReachShape = REACH
) -> SimulatedHand:
    hand = SimulatedHand(PROFILES[profile], rate_hz, seed)
    hand.move(2 * SECOND, shape)
    return hand


@given(
    cuts=st.lists(st.integers(0, 6 * SECOND), max_size=8),
    rate_hz=st.sampled_from([60.0, 250.0, 1000.0]),
)
@example(cuts=[100_000_000, 5_500_000_000], rate_hz=250.0)
@examples(30)
def test_samples_do_not_depend_on_how_they_are_requested(cuts: list[int], rate_hz: float) -> None:
    whole = a_hand(rate_hz=rate_hz, shape=HALFWAY).samples(0, 6 * SECOND)
    hand, edges = a_hand(rate_hz=rate_hz, shape=HALFWAY), [0, *sorted(cuts), 6 * SECOND]
    parts = [hand.samples(begin, end) for begin, end in itertools.pairwise(edges)]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_samples_lie_on_the_grid_of_the_first_call() -> None:
    hand = SimulatedHand(PROFILES["clean"], 250.0)
    assert len(hand.samples(7, 7)) == 0
    samples = hand.samples(7, SECOND)
    assert samples["at"][:3].tolist() == [7, 4_000_007, 8_000_007]
    assert samples["host"].tolist() == samples["at"].tolist()
    assert samples["device_ms"][:3].tolist() == pytest.approx([0, 4, 8])
    assert hand.samples(SECOND, 2 * SECOND)["at"][0] == 1_000_000_007


def test_a_noiseless_hand_moves_exactly_during_its_reaches() -> None:
    made = simulate([REACH])
    (onset, end), time, turning = made.truth[0], made.recording.time_s, made.recording.rate[:, 2]
    assert turning.max() == pytest.approx(2.0, rel=1e-3)
    assert turning.min() == pytest.approx(-2.0, rel=1e-3)
    assert not turning[(time < onset) | (time > end)].any()
    assert not made.recording.rate[:, :2].any()


@pytest.mark.parametrize("submovements", [2, 3, 5, 7])
def test_submovements_are_at_two_per_cent_where_the_reach_begins_and_ends(
    submovements: int,
) -> None:
    shape = ReachShape(
        out_s=1.5, back_s=2, dwell_s=1, peak_out=1, peak_back=-1, submovements=submovements, seed=4
    )
    form = waveform(shape)
    assert form.rate.max() == pytest.approx(1, abs=0.03)
    assert form.rate.min() == pytest.approx(-1, abs=0.03)
    at_edges = np.interp([0.0, shape.duration_s], form.time_s, np.abs(form.rate))
    assert at_edges == pytest.approx([0.02, 0.02], abs=0.006)


def test_a_twitch_comes_before_the_reach_and_lasts_80_ms() -> None:
    form = waveform(ReachShape(out_s=0.5, back_s=0.5, twitch=True, seed=8))
    before = form.time_s[(form.time_s < -0.001) & (np.abs(form.rate) > 0)]
    assert -1.25 < before[0] < before[-1] < -0.8
    assert before[-1] - before[0] == pytest.approx(0.08, abs=0.005)


def test_a_reach_without_time_axis_or_with_one_submovement_is_refused() -> None:
    with pytest.raises(ValueError, match="axis"):
        SimulatedHand(Profile(axis=(0.0, 0.0, 0.0)))
    hand = SimulatedHand(PROFILES["clean"])
    with pytest.raises(ValueError, match="takes time"):
        hand.move(0, ReachShape(out_s=0.0, back_s=1.0))
    with pytest.raises(ValueError, match="two phases"):
        hand.move(0, ReachShape(out_s=1.0, back_s=1.0, submovements=1))


def test_a_hand_at_rest_measures_gravity_which_turns_with_it() -> None:
    profile = Profile(axis=(1.0, 0.0, 0.0))
    turn = ReachShape(out_s=0.5, back_s=0.5, peak_out=2.0, peak_back=-1e-9)
    acceleration = simulate([turn], profile).recording.acceleration
    assert acceleration is not None
    assert acceleration[:400].mean(axis=0) == pytest.approx([0, 0, 9.81], abs=0.01)
    angle = 2.0 * 0.5 * 8 / 15
    turned = [0, 9.81 * math.sin(angle), 9.81 * math.cos(angle)]
    assert acceleration[-400:].mean(axis=0) == pytest.approx(turned, abs=0.02)


def test_a_sensor_shows_its_noise_and_bias_at_rest() -> None:
    profile = Profile(noise_rad_s=0.05, bias_rad_s=(0.1, -0.2, 0.3))
    rate = SimulatedHand(profile).samples(0, 20 * SECOND)["rate"]
    assert rate.mean(axis=0) == pytest.approx([0.1, -0.2, 0.3], abs=0.005)
    assert rate.std(axis=0) == pytest.approx([0.05] * 3, rel=0.05)

    drifting = SimulatedHand(Profile(drift_rad_s_per_s=0.01)).samples(0, 10 * SECOND)["rate"]
    assert drifting[-1] == pytest.approx([0.1] * 3, abs=0.001)


def test_a_tremor_has_its_frequency_and_amplitude() -> None:
    hand = SimulatedHand(Profile(tremor_hz=5, tremor_rad_s=0.15))
    rate = hand.samples(0, 8 * SECOND)["rate"][:, 2]
    spectrum = np.abs(np.fft.rfft(rate))
    assert np.fft.rfftfreq(len(rate), 1 / 250)[spectrum.argmax()] == pytest.approx(5, abs=0.3)
    assert rate.max() == pytest.approx(0.15, rel=0.01)


def test_a_lossy_sensor_loses_its_share_and_samples_beyond_the_range_are_dropped() -> None:
    samples = SimulatedHand(PROFILES["lossy"]).samples(0, 10 * SECOND)
    assert len(samples) == pytest.approx(2250, abs=60)
    profile = Profile(saturation_rad_s=1.5)
    recording = simulate([REACH], profile).recording
    assert np.abs(recording.rate).max() <= 1.5
    assert recording.flags == ("saturated",)
    assert not simulate([REACH]).recording.flags


def test_the_reaches_of_the_table_have_its_times_and_amplitudes() -> None:
    made = table_4_1_recording()
    time, turning = made.recording.time_s, made.recording.rate[:, 2]
    for row, (onset, end) in zip(TABLE_4_1, made.truth, strict=True):
        reach = turning[(time >= onset) & (time <= end)]
        assert end - onset == pytest.approx(row.reach_time_s)
        assert reach.max() == pytest.approx(row.peak_extension_rad_s, rel=2e-3)
        assert reach.min() == pytest.approx(row.peak_return_rad_s, rel=2e-3)
        assert abs(reach.mean()) < 0.01
