"""Motion through a gesture: within the speed limit, and at rest in the end."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.gesture import JOINTS, REST, Gesture, Keyframe, Pose
from sar_tui.outputs.servo.servo import STEP_MS, Motion
from tests.model.test_gesture import gestures, poses


@given(gestures(), poses, st.floats(0.3, 72), st.lists(st.integers(1, 400), max_size=30))
def test_it_is_never_faster_than_it_may_be_stays_in_range_and_comes_to_rest(
    gesture: Gesture, start: Pose, speed: float, pauses: list[int]
) -> None:
    motion = Motion(gesture, start, speed)
    ms, last = 0, start
    pauses = [*pauses]
    latest = gesture.duration_ms + sum(pauses) + 2 * 1000 / speed + 2 * STEP_MS
    while not motion.over:
        pause = pauses.pop() if pauses else STEP_MS
        ms += pause
        pose = motion.step(ms)
        for joint in JOINTS:
            most = speed * min(pause, 2 * STEP_MS) / 1000
            assert abs(getattr(pose, joint) - getattr(last, joint)) <= most + 1e-9
            assert -1 <= getattr(pose, joint) <= 1
        last = pose
        assert ms <= latest
    assert motion.pose == REST


def test_a_gesture_that_is_slow_enough_is_followed_exactly() -> None:
    gesture = Gesture((Keyframe(at_ms=1000, nod=1), Keyframe(at_ms=2000)))
    motion = Motion(gesture, REST, speed=4)
    for ms in range(STEP_MS, 2001, STEP_MS):
        assert motion.step(ms) == gesture.pose_at(ms)
    assert motion.over


def test_the_joints_it_moves_are_those_of_its_keyframes_and_those_that_are_not_at_rest() -> None:
    gesture = Gesture((Keyframe(at_ms=100, nod=1), Keyframe(at_ms=200)))
    assert Motion(gesture, REST, 4).joints == {"nod"}
    assert Motion(gesture, Pose(left_arm=0.2), 4).joints == {"nod", "left_arm"}


def test_a_gesture_that_begins_with_a_pause_is_not_over_before_it_moved() -> None:
    motion = Motion(
        Gesture((Keyframe(at_ms=200), Keyframe(at_ms=500, nod=1), Keyframe(at_ms=900))), REST, 4
    )
    assert not any((motion.step(ms), motion.over)[1] for ms in range(STEP_MS, 900, STEP_MS))
    motion.step(900)
    assert motion.over
