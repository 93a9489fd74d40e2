"""Motion of servos through a gesture, limited in speed."""

from sar_tui.model.gesture import JOINTS, Gesture, Pose

STEP_MS = 20
"""Interval between two targets that are sent to a servo."""
_LONGEST_STEP_MS = 2 * STEP_MS


class Motion:
    """The path through a gesture, step by step, with a speed limit.

    Where a gesture is faster than the limit, its joints move at the limit, and it ends later by the
    time they need to reach their last position.

    Args:
        gesture: the keyframes.
        start: where the joints are.
        speed: the share of its range (0 to 1) that a joint may move in a second.
    """

    def __init__(self, gesture: Gesture, start: Pose, speed: float) -> None:
        self.pose = start
        self._gesture = gesture
        self._start = start
        self._speed = speed
        self._ms = 0.0

    @property
    def joints(self) -> frozenset[str]:
        """The joints that the gesture moves or must bring back to rest."""
        poses = (self._start, *self._gesture.keyframes)
        return frozenset(joint for joint in JOINTS if any(getattr(pose, joint) for pose in poses))

    @property
    def over(self) -> bool:
        """True if the last keyframe is reached."""
        return (
            self._ms >= self._gesture.duration_ms and self.pose == self._gesture.keyframes[-1].pose
        )

    def step(self, ms: float) -> Pose:
        """Return the target of the joints ``ms`` after the start.

        If the computer paused, they move no further than in two ordinary steps, instead of jumping.
        """
        most = self._speed * min(ms - self._ms, _LONGEST_STEP_MS) / 1000
        self._ms = ms
        goal = self._gesture.pose_at(ms, self._start)
        self.pose = Pose(
            *(_nearer(getattr(self.pose, joint), getattr(goal, joint), most) for joint in JOINTS)
        )
        return self.pose


def _nearer(now: float, goal: float, most: float) -> float:
    """Return ``goal``, or the nearest value that ``most`` allows."""
    return goal if abs(goal - now) <= most else now + most if goal > now else now - most
