"""Simulated reaches about many axes: samples, orientation, position and true times belong to one
movement.
"""

import math

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sar_tui.motion.body_model import Site
from sar_tui.motion.imperfections import PERFECT, StrappedSensor
from sar_tui.motion.samples import Floats
from sar_tui.motion.trajectories import (
    KINDS,
    PLACEMENTS,
    Movement,
    SimulatedReaches,
    measure,
    placed,
    simulate_reaches,
)
from tests.examples import first

FINE_HZ = 1000.0
SEED = 4
every_kind = pytest.mark.parametrize("kind", KINDS)


def perfect(kind: str, seed: int = SEED, **given: object) -> SimulatedReaches:
    return simulate_reaches(kind, seed, imperfections=PERFECT, **{"rate_hz": FINE_HZ, **given})  # type: ignore[arg-type]


def truth_of(made: SimulatedReaches, time_s: Floats) -> tuple[Rotation, Floats]:
    """Return orientation and position, the orientation as scipy's."""
    orientation, position = made.movement.pose(made.site, time_s)
    return Rotation.from_quat(orientation, scalar_first=True), position


@pytest.mark.slow
@pytest.mark.parametrize("kind", first(4, KINDS))
def test_an_outsider_integrates_the_rate_to_the_orientation(kind: str) -> None:
    made = perfect(kind)
    rate = made.recording.rate
    turned = Rotation.identity()
    orientations = [turned]
    for step in Rotation.from_rotvec((rate[1:] + rate[:-1]) / 2.0 / FINE_HZ):
        turned = turned * step
        orientations.append(turned)
    true, _ = truth_of(made, made.recording.time_s)
    error = (Rotation.concatenate(orientations).inv() * (true[0].inv() * true)).magnitude()
    assert np.degrees(error.max()) < 0.02


@every_kind
def test_the_accelerometer_measures_the_curve_of_the_position_against_gravity(kind: str) -> None:
    made = perfect(kind, placement=3, arm="left")
    acceleration = made.recording.acceleration
    assert acceleration is not None
    orientation, position = truth_of(made, made.recording.time_s)
    in_the_room = orientation.apply(acceleration) - (0.0, 0.0, 9.81)
    velocity = np.cumsum(in_the_room, axis=0) / FINE_HZ
    displacement = np.cumsum(velocity, axis=0) / FINE_HZ
    assert np.abs(displacement - (position - position[0])).max() < 0.003
    assert np.abs(position - position[0]).max() > 0.03


@every_kind
@pytest.mark.parametrize("placement", range(len(PLACEMENTS)))
def test_at_rest_the_rate_is_nil_and_gravity_is_upwards(kind: str, placement: int) -> None:
    made = perfect(kind, placement=placement, rate_hz=50.0)
    still = made.recording.time_s < made.times[0].onset_s - 0.3
    acceleration = made.recording.acceleration
    assert acceleration is not None
    assert np.abs(made.recording.rate[still]).max() < 1e-6
    assert np.linalg.norm(acceleration[still], axis=1) == pytest.approx(9.81, abs=1e-5)
    orientation, _ = truth_of(made, made.recording.time_s[still])
    assert orientation.apply(acceleration[still])[:, 2] == pytest.approx(9.81, abs=1e-5)


@every_kind
def test_the_left_arm_mirrors_the_right_one(kind: str) -> None:
    right, left = perfect(kind, rate_hz=100.0), perfect(kind, rate_hz=100.0, arm="left")
    assert np.allclose(left.recording.rate, right.recording.rate * (1.0, -1.0, -1.0), atol=1e-9)
    felt, mirrored = left.recording.acceleration, right.recording.acceleration
    assert felt is not None
    assert mirrored is not None
    assert np.allclose(felt, mirrored * (-1.0, 1.0, 1.0), atol=1e-5)
    assert left.truth == right.truth


def test_each_placement_turns_what_the_sensor_measures_and_not_the_movement() -> None:
    usual = perfect("cross-arm")
    for placement in range(1, len(PLACEMENTS)):
        other = perfect("cross-arm", placement=placement)
        turned = Rotation.from_quat(placed(placement, SEED), scalar_first=True)
        assert np.allclose(turned.apply(other.recording.rate), usual.recording.rate, atol=1e-9)
        assert other.truth == usual.truth
        assert np.abs(other.recording.rate - usual.recording.rate).max() > 0.1


@every_kind
@pytest.mark.parametrize("seed", first(3, range(20)))
def test_the_true_times_are_those_at_which_the_rate_is_two_per_cent_of_its_peak_on_each_way(
    kind: str, seed: int
) -> None:
    made = perfect(kind, seed)
    (times,) = made.times
    assert made.truth == ((times.onset_s, times.end_s),)
    assert times.onset_s < times.arrival_s <= times.departure_s < times.end_s
    time_s, speed = made.recording.time_s, np.linalg.norm(made.recording.rate, axis=1)
    turn_s = (times.arrival_s + times.departure_s) / 2.0
    ways = (time_s < turn_s, time_s >= turn_s)
    edges = ((times.onset_s, times.arrival_s), (times.departure_s, times.end_s))
    for way, bounds in zip(ways, edges, strict=True):
        fast = time_s[way][speed[way] >= 0.02 * speed[way].max()]
        assert (fast[0], fast[-1]) == pytest.approx(bounds, abs=0.005)


@every_kind
@pytest.mark.parametrize("seed", first(3, range(50)))
def test_a_reach_turns_the_hand_away_and_back_within_the_times_and_speeds_of_people(
    kind: str, seed: int
) -> None:
    made = perfect(kind, seed, rate_hz=100.0)
    (times,) = made.times
    time_s, peak = made.recording.time_s, np.linalg.norm(made.recording.rate, axis=1).max()
    orientation, _ = truth_of(made, time_s)
    degrees = np.degrees((orientation[0].inv() * orientation).magnitude())
    assert 0.2 < peak < 7.5
    assert 0.8 < times.end_s - times.onset_s < 9.0
    assert degrees.max() > 10.0
    assert degrees[-1] < 10.0
    at_target = (time_s > times.arrival_s) & (time_s < times.departure_s + 0.02)
    assert degrees[at_target].max() > 0.5 * degrees.max()
    if kind == "submovements":
        assert times.end_s - times.onset_s > 2.0
    if kind == "point-and-hold":
        assert 0.9 < times.departure_s - times.arrival_s < 4.0
    if kind == "two-hand-push":
        assert peak < 1.7


def test_a_person_repeats_a_reach_with_differences_and_each_seed_is_a_person() -> None:
    made = simulate_reaches("from-the-side", SEED, count=4, imperfections=PERFECT)
    durations = [end - onset for onset, end in made.truth]
    assert len(made.truth) == 4
    assert 0.01 < np.std(durations) / np.mean(durations) < 0.2
    for (_, end), (onset, _) in zip(made.truth, made.truth[1:], strict=False):
        assert onset - end == pytest.approx(2.0, abs=0.3)

    one, other = (simulate_reaches("drinking", seed) for seed in (1, 2))
    same = simulate_reaches("drinking", 1, accelerometer=False)
    assert one.recording.rate.tobytes() == same.recording.rate.tobytes()
    assert one.truth == same.truth
    assert one.truth != other.truth
    assert same.recording.acceleration is None


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 250.0])
def test_samples_come_at_the_rate_in_order_though_their_times_jitter(rate_hz: float) -> None:
    sensor = msgspec.structs.replace(PERFECT, jitter_s=0.5)
    made = simulate_reaches("cross-arm", 1, rate_hz=rate_hz, imperfections=sensor)
    time_s = made.recording.time_s
    assert (np.diff(time_s) > 0).all()
    assert np.diff(time_s).std() > 0.2 / rate_hz
    assert len(time_s) / (time_s[-1] - time_s[0]) == pytest.approx(rate_hz, rel=0.01)


def test_a_sensor_adds_bias_drift_and_noise_and_holds_its_range() -> None:
    bias = (0.1, -0.2, 0.3)
    sensor = StrappedSensor(
        noise_rad_s=0.02, bias_rad_s=bias, drift_rad_s_per_s=0.01, range_rad_s=1.0, lost=0.1
    )
    recording = simulate_reaches("forearm-rotation", 1, rest_s=10.0, imperfections=sensor).recording
    still = recording.time_s < 9.0
    assert recording.rate[still].mean(axis=0) == pytest.approx([0.145, -0.155, 0.345], abs=0.005)
    spread = math.hypot(0.02, 0.026)
    assert recording.rate[still].std(axis=0) == pytest.approx([spread] * 3, rel=0.1)
    assert np.abs(recording.rate).max() == 1.0
    assert (np.abs(recording.rate) == 1.0).any(axis=1).sum() > 5
    assert np.isin(recording.time_s.round(9), (np.arange(9000) / 100).round(9)).all()
    assert still.sum() == pytest.approx(810, abs=40)


def test_a_tremor_of_action_comes_with_the_reach_only_and_one_of_rest_stays() -> None:
    shaking = StrappedSensor(action_tremor_rad_s=0.3, action_tremor_hz=8.0)
    made = simulate_reaches("point-and-hold", 1, imperfections=shaking)
    (times,) = made.times
    time_s, rate = made.recording.time_s, made.recording.rate
    assert made.truth == perfect("point-and-hold", 1).truth
    assert np.abs(rate[time_s < times.onset_s - 0.1]).max() < 1e-6
    held = rate[(time_s > times.arrival_s + 0.1) & (time_s < times.departure_s - 0.1)]
    assert np.linalg.norm(held, axis=1).max() == pytest.approx(0.3, rel=0.2)
    resting = simulate_reaches("point-and-hold", 1, imperfections=StrappedSensor(tremor_rad_s=0.2))
    before = resting.recording.rate[time_s < times.onset_s - 0.1]
    assert np.linalg.norm(before, axis=1).max() == pytest.approx(0.2, rel=0.2)
    spectrum = np.abs(np.fft.rfft(before[:, 1] - before[:, 1].mean()))
    assert np.fft.rfftfreq(len(before), 0.01)[spectrum.argmax()] == pytest.approx(5.0, abs=0.6)


def test_a_sensor_on_the_sternum_sees_the_lean_and_little_else() -> None:
    lean = simulate_reaches("trunk-lean", SEED, imperfections=PERFECT, sternum=True)
    push = simulate_reaches("two-hand-push", SEED, imperfections=PERFECT, sternum=True)
    assert lean.sternum is not None
    assert push.sternum is not None
    assert np.linalg.norm(lean.sternum.rate, axis=1).max() > 0.2
    assert not push.sternum.rate.any()
    assert lean.sternum.acceleration is not None
    assert lean.sternum.acceleration[0] == pytest.approx([0.0, 9.81, 0.0], abs=1e-5)


def test_a_still_body_is_posed_like_a_person_at_a_table() -> None:
    still = Movement({"elbow_flexion": math.pi / 2.0}, ())
    for arm, side in (("right", 1.0), ("left", -1.0)):
        ((x, y, z),) = still.pose(Site(arm=arm), np.zeros(1)).position  # type: ignore[arg-type]
        assert (x, y, z) == pytest.approx((side * 0.18, 0.31, 0.17))
    output = measure(still, Site(), np.zeros(1))
    assert output.acceleration[0] == pytest.approx([0.0, 0.0, 9.81])


def test_unknown_kinds_and_placements_are_refused() -> None:
    with pytest.raises(ValueError, match="no kind of reach named 'jump'"):
        simulate_reaches("jump", 1)
    with pytest.raises(ValueError, match="4 placements"):
        simulate_reaches("drinking", 1, placement=4)
