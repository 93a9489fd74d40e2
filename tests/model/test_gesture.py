"""Gestures start from the current pose, move smoothly through their keyframes and end at rest."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.gesture import JOINTS, LONGEST_MS, REST, Gesture, Keyframe, Pose

positions = st.floats(-1, 1)
poses = st.builds(Pose, **dict.fromkeys(JOINTS, positions))


@st.composite
def gestures(draw: st.DrawFn) -> Gesture:
    """Generate valid gestures."""
    times = sorted(draw(st.sets(st.integers(1, LONGEST_MS), min_size=1, max_size=8)))
    frames = [
        Keyframe(at_ms=ms, **{joint: draw(positions) for joint in JOINTS}) for ms in times[:-1]
    ]
    return Gesture((*frames, Keyframe(at_ms=times[-1])))


moments = st.floats(0, LONGEST_MS * 1.5)


@given(gestures(), poses)
def test_it_goes_from_where_the_body_is_through_every_keyframe_to_rest(
    gesture: Gesture, start: Pose
) -> None:
    assert gesture.pose_at(0, start) == start
    assert gesture.pose_at(gesture.duration_ms, start) == REST
    assert gesture.pose_at(gesture.duration_ms + 1000, start) == REST
    for frame in gesture.keyframes:
        assert gesture.pose_at(frame.at_ms, start) == frame.pose
    assert gesture.problems("wave") == []


@given(gestures(), poses, moments)
def test_between_two_keyframes_no_joint_is_beyond_either(
    gesture: Gesture, start: Pose, ms: float
) -> None:
    before = [start, *(frame.pose for frame in gesture.keyframes if frame.at_ms <= ms)][-1]
    after = next((frame.pose for frame in gesture.keyframes if frame.at_ms > ms), REST)
    pose = gesture.pose_at(ms, start)
    for joint in JOINTS:
        low, high = sorted((getattr(before, joint), getattr(after, joint)))
        assert low - 1e-9 <= getattr(pose, joint) <= high + 1e-9


@given(gestures(), poses, moments, st.floats(0, 5))
def test_it_never_jumps_or_exceeds_the_speed_of_its_easing(
    gesture: Gesture, start: Pose, ms: float, later: float
) -> None:
    places = [start, *(frame.pose for frame in gesture.keyframes)]
    times = [0, *(frame.at_ms for frame in gesture.keyframes)]
    now, then = gesture.pose_at(ms, start), gesture.pose_at(ms + later, start)
    for joint in JOINTS:
        way = [getattr(place, joint) for place in places]
        steps = zip(pairwise(way), pairwise(times), strict=True)
        fastest = max(abs(b - a) / (t - s) for (a, b), (s, t) in steps)
        moved = abs(getattr(then, joint) - getattr(now, joint))
        assert moved <= fastest * math.pi / 2 * later + 1e-9


def test_it_is_in_the_middle_at_half_time() -> None:
    gesture = Gesture((Keyframe(at_ms=400, nod=0.8), Keyframe(at_ms=800)))
    assert gesture.pose_at(200).nod == pytest.approx(0.4)
    assert gesture.pose_at(200, Pose(nod=-0.8)).nod == pytest.approx(0.0)
    assert gesture.pose_at(600, Pose(nod=-0.8)).nod == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("keyframes", "expected"),
    [
        ((), "no keyframes"),
        ((Keyframe(at_ms=100, nod=1), Keyframe(at_ms=100)), "must be in order of time"),
        ((Keyframe(at_ms=300, nod=1), Keyframe(at_ms=200)), "must be in order of time"),
        ((Keyframe(at_ms=-1, nod=1), Keyframe(at_ms=200)), "none before 0 ms"),
        ((Keyframe(at_ms=LONGEST_MS + 1),), f"at most {LONGEST_MS}"),
        ((Keyframe(at_ms=100, turn=1.5), Keyframe(at_ms=200)), "at 100 ms turn is 1.5"),
        ((Keyframe(at_ms=100, lean=math.nan), Keyframe(at_ms=200)), "lean is nan"),
        ((Keyframe(at_ms=100, nod=1), Keyframe(at_ms=200, nod=0.1)), "must end at rest"),
    ],
)
def test_a_fault_of_a_gesture_is_reported_once_with_its_name(
    keyframes: tuple[Keyframe, ...], expected: str
) -> None:
    [problem] = Gesture(keyframes).problems("wave")
    assert expected in problem
    assert "wave" in problem
