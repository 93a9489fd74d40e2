"""A gesture as a servo may follow it: never faster than allowed."""

from sar_tui.framework.gesture import JOINTS, Gesture, Pose

STEP_MS = 20
"""Between two targets that are sent to a servo."""
_LONGEST_STEP_MS = 2 * STEP_MS


class Motion:
    """The way through a gesture, step by step, with a limit to speed.

    Where a gesture asks for more speed than there may be, its joints follow as fast as they may, and it ends as much
    later as they need to come to rest.

    Args:
        gesture: the keyframes.
        start: where the joints are.
        speed: how much of its range (0 to 1) a joint may move in a second.
    """

    def __init__(self, gesture: Gesture, start: Pose, speed: float) -> None:
        self.pose = start
        self._gesture = gesture
        self._start = start
        self._speed = speed
        self._ms = 0.0

    @property
    def joints(self) -> frozenset[str]:
        """Which joints the gesture moves, or has to bring back to rest."""
        poses = (self._start, *self._gesture.keyframes)
        return frozenset(joint for joint in JOINTS if any(getattr(pose, joint) for pose in poses))

    @property
    def over(self) -> bool:
        """Whether the last keyframe is reached."""
        return self._ms >= self._gesture.duration_ms and self.pose == self._gesture.keyframes[-1].pose

    def step(self, ms: float) -> Pose:
        """Where the joints are to be ``ms`` after the beginning.

        After a pause (the computer had other things to do) they go on no further than in an ordinary step or two:
        what has been missed is not made up for by a leap.
        """
        most = self._speed * min(ms - self._ms, _LONGEST_STEP_MS) / 1000
        self._ms = ms
        goal = self._gesture.pose_at(ms, self._start)
        self.pose = Pose(*(_nearer(getattr(self.pose, joint), getattr(goal, joint), most) for joint in JOINTS))
        return self.pose


def _nearer(now: float, goal: float, most: float) -> float:
    """``goal``, or as near to it as ``most`` allows."""
    return goal if abs(goal - now) <= most else now + most if goal > now else now - most
