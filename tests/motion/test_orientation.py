"""The orientation detector: reaches about several axes, out and back from the orientation at
rest.
"""

import numpy as np
import pytest

from sar_tui.motion.orientation import OrientationParameters, find
from sar_tui.motion.quaternions import from_rotation, multiply, rotate
from sar_tui.motion.reach import Bounds
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.synthesis import ReachShape, scenarios, simulate
from sar_tui.motion.trajectories import simulate_reaches
from tests.examples import fewer


def reaches_in(recording: Recording, **parameters: float) -> tuple[Bounds, ...]:
    return find(recording, OrientationParameters(**parameters)).reaches


def turning(angles: Floats, axes: Floats, rate_hz: float = 100.0) -> Recording:
    """Return the recording of rotations one after the other: their angles, shape (n, k), about axes
    of shape (k, 3).
    """
    rate, step_s = np.zeros((len(angles), 3)), 1.0 / rate_hz
    for k in range(angles.shape[1]):
        rate = rotate(from_rotation(-angles[:, k, None] * axes[k]), rate)
        rate = rate + np.gradient(angles[:, k], step_s)[:, None] * axes[k]
    return Recording(np.arange(len(angles)) * step_s, rate)


def stroke(time_s: Floats, begin_s: float, lasts_s: float) -> Floats:
    u = np.clip((time_s - begin_s) / lasts_s, 0.0, 1.0)
    course: Floats = u**3 * (10.0 + u * (6.0 * u - 15.0))
    return course


@pytest.mark.parametrize("kind", KINDS)
def test_a_reach_about_many_axes_is_found_once_and_timed(kind: str) -> None:
    errors = []
    for seed in range(fewer(40)):
        made = simulate_reaches(
            kind, seed, arm=("right", "left")[seed % 2], placement=seed // 2 % 4
        )
        ((onset_s, end_s),) = made.truth
        (found,) = reaches_in(made.recording)
        errors.append((found.onset_s - onset_s, found.end_s - found.onset_s - (end_s - onset_s)))
    onset, duration = np.median(errors, axis=0)
    assert abs(onset) < 0.04
    assert abs(duration) < 0.08


SLOW_BEGINNINGS = [("trunk-lean", 40, 0), ("trunk-lean", 189, 2)]
STOPS_ON_THE_WAY_BACK = [("drinking", seed, 0) for seed in (17, 62, 139)]


@pytest.mark.parametrize(("kind", "seed", "placement"), [*SLOW_BEGINNINGS, *STOPS_ON_THE_WAY_BACK])
def test_a_slow_beginning_and_a_stop_on_the_way_back_belong_to_the_reach(
    kind: str, seed: int, placement: int
) -> None:
    arm = "left" if kind == "trunk-lean" and seed % 2 else "right"
    made = simulate_reaches(kind, seed, arm=arm, placement=placement)
    (found,) = reaches_in(made.recording)
    within_s = 0.15 if kind == "drinking" else 0.2
    assert (found.onset_s, found.end_s) == pytest.approx(made.truth[0], abs=within_s)


@pytest.mark.parametrize("seed", [21, 60, 94])
def test_a_reach_after_a_noisy_rest_is_found(seed: int) -> None:
    (noisy,) = [scenario for scenario in scenarios() if scenario.name == "noise 5 deg/s"]
    made = noisy.make(seed)
    (found,) = reaches_in(made.recording)
    assert (found.onset_s, found.end_s) == pytest.approx(made.truth[0], abs=0.2)


@pytest.mark.parametrize("rest_s", [0.5, 1.0, 4.0])
def test_a_return_never_becomes_the_way_out_of_the_next_reach(rest_s: float) -> None:
    made = simulate_reaches("point-and-hold", 3, count=5, rest_s=rest_s)
    onsets_s = [one.onset_s for one in reaches_in(made.recording)]
    assert onsets_s == pytest.approx([onset_s for onset_s, _ in made.truth], abs=0.15)


def test_a_recording_that_begins_at_the_target_begins_with_a_return() -> None:
    made = simulate_reaches("lift-extend-touch", 5, count=3, rest_s=1.0)
    begins_s = (made.times[0].arrival_s + made.times[0].departure_s) / 2
    after = made.recording.time_s > begins_s
    rest = Recording(made.recording.time_s[after], made.recording.rate[after])
    onsets_s = [one.onset_s for one in reaches_in(rest)]
    assert onsets_s == pytest.approx([onset_s for onset_s, _ in made.truth[1:]], abs=0.1)


def test_the_onset_is_that_of_the_axis_that_moves_first() -> None:
    """The forearm is lifted for 0.3 s before it extends about another axis, four times as far."""
    time_s = np.arange(0.0, 6.0, 0.01)
    lift = 0.3 * (stroke(time_s, 2.0, 0.4) - stroke(time_s, 3.5, 0.4))
    extension = 1.2 * (stroke(time_s, 2.3, 0.7) - stroke(time_s, 3.2, 0.7))
    (found,) = reaches_in(turning(np.column_stack((lift, extension)), np.eye(3)[[0, 2]]))
    assert found.onset_s == pytest.approx(2.0, abs=0.03)
    assert found.end_s == pytest.approx(3.9, abs=0.03)


def test_neither_a_twitch_nor_a_movement_to_another_posture_is_a_reach() -> None:
    twitch = ReachShape(out_s=0.15, back_s=0.15, peak_out=3.0, peak_back=-3.0)
    assert reaches_in(simulate([twitch]).recording) == ()
    time_s = np.arange(0.0, 20.0, 0.01)
    shifted = 0.8 * stroke(time_s, 2.0, 0.8) + 0.5 * stroke(time_s, 9.0, 0.8)
    reach = 0.7 * (stroke(time_s, 14.0, 0.6) - stroke(time_s, 14.7, 0.6))
    found = reaches_in(turning(np.column_stack((shifted, reach)), np.eye(3)[[1, 2]]))
    assert [one.onset_s for one in found] == pytest.approx([14.0], abs=0.03)


def test_a_hand_is_back_when_little_of_the_turn_is_left_even_if_it_goes_on_later() -> None:
    time_s, axis = np.arange(0.0, 12.0, 0.01), np.array([[0.0, 1.0, 0.0]])
    for share, count in ((0.3, 1), (0.6, 0)):
        angle = 0.8 * (stroke(time_s, 2.0, 0.6) - (1 - share) * stroke(time_s, 2.8, 0.6))
        assert len(reaches_in(turning(angle[:, None], axis))) == count
    angle = stroke(time_s, 2.0, 0.6) - 0.7 * stroke(time_s, 3.0, 0.6)
    angle -= 0.3 * stroke(time_s, 7.0, 0.6)
    (found,) = reaches_in(turning(angle[:, None], axis))
    assert found.end_s == pytest.approx(3.6, abs=0.05)


@pytest.mark.parametrize("lasts_s", [0.5, 0.8, 1.5])
def test_a_reach_may_end_when_the_hand_is_home(lasts_s: float) -> None:
    """The last 15 % of a minimum-jerk way take a third of its time."""
    time_s = np.arange(0.0, 8.0, 0.01)
    course = 0.6 * (stroke(time_s, 2.0, 0.7) - stroke(time_s, 3.0, lasts_s))
    recording = turning(course[:, None], np.array([(0.0, 0.0, 1.0)]))
    (home,) = find(recording, OrientationParameters(ends="home")).reaches
    (still,) = find(recording, OrientationParameters(ends="still")).reaches
    left = 1.0 - stroke(np.linspace(0.0, 1.0, 10_001), 0.0, 1.0)
    arrives = float(np.interp(-0.15, -left, np.linspace(0.0, 1.0, 10_001)))
    assert home.end_s == pytest.approx(3.0 + arrives * lasts_s, abs=0.02)
    assert still.end_s > home.end_s + 0.2 * lasts_s
    assert home.onset_s == still.onset_s


def test_the_axis_is_that_of_the_whole_turn_seen_from_the_sensor_at_rest() -> None:
    time_s = np.arange(0.0, 6.0, 0.01)
    course = stroke(time_s, 2.0, 0.7) - stroke(time_s, 3.2, 0.7)
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    (found,) = reaches_in(turning(np.column_stack((0.4 * course, 0.9 * course)), axes))
    whole = multiply(from_rotation(0.4 * axes[0]), from_rotation(0.9 * axes[1]))
    assert found.axis == pytest.approx(tuple(whole[1:] / np.linalg.norm(whole[1:])), abs=0.01)


def test_a_reach_about_one_axis_is_timed_without_its_slowest_moments() -> None:
    shape = ReachShape(out_s=0.6, back_s=0.5, dwell_s=0.3, peak_out=1.5, peak_back=-1.8)
    (found,) = reaches_in(simulate([shape]).recording)
    # a minimum-jerk way reaches 1 % after 2.6 %
    assert found.onset_s == pytest.approx(2.0 + 0.0256 * 0.6, abs=0.01)
    assert found.end_s == pytest.approx(3.4 - 0.0256 * 0.5, abs=0.01)


@pytest.mark.parametrize(("kind", "seed"), [("point-and-hold", 17), ("trunk-lean", 10)])
def test_the_way_out_ends_before_the_way_back_begins(kind: str, seed: int) -> None:
    made = simulate_reaches(kind, seed, placement=seed % 4)
    (found,) = reaches_in(made.recording)
    assert min(found.arrival_s - found.onset_s, found.end_s - found.departure_s) > 0.2


def test_a_reach_longer_than_the_longest_is_cut_off() -> None:
    made = simulate_reaches("submovements", 1)
    (whole,) = reaches_in(made.recording)
    (found,) = reaches_in(made.recording, longest_s=(whole.end_s - whole.onset_s) * 0.8)
    assert "timed_out" in found.flags
    assert found.end_s - found.onset_s == pytest.approx((whole.end_s - whole.onset_s) * 0.8)
