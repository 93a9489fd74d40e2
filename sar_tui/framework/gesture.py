"""Gestures: a small vocabulary, as keyframes that a drawn robot and a real one move through alike."""

import math
from bisect import bisect_right

import msgspec

GESTURES = ("nod", "shake", "cheer", "wave", "point_left", "point_right", "lean_in", "rest")
"""The gestures every theme has."""
JOINTS = ("nod", "turn", "left_arm", "right_arm", "lean")
"""What a body may have: the head down (1) or up, turned to the participant's right (1) or left; the arms raised (1);
the body towards the participant (1). 0 is rest; a robot without a joint leaves it out."""
LONGEST_MS = 10_000


class Pose(msgspec.Struct, frozen=True):
    """Where each joint is, from -1 to 1; 0 is rest."""

    nod: float = 0.0
    turn: float = 0.0
    left_arm: float = 0.0
    right_arm: float = 0.0
    lean: float = 0.0


REST = Pose()


class Keyframe(Pose, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose to be in ``at_ms`` milliseconds after the gesture began."""

    at_ms: int

    @property
    def pose(self) -> Pose:
        """The pose alone."""
        return Pose(*(getattr(self, joint) for joint in JOINTS))


class Gesture(msgspec.Struct, frozen=True):
    """A way through keyframes. It begins where the body is, and ends at its last keyframe."""

    keyframes: tuple[Keyframe, ...]

    @property
    def duration_ms(self) -> int:
        """From its beginning to its last keyframe."""
        return self.keyframes[-1].at_ms

    @property
    def farthest(self) -> Pose:
        """The keyframe that is farthest from rest: what a single picture shows of it."""
        return max(self.keyframes, key=lambda frame: sum(abs(getattr(frame, joint)) for joint in JOINTS)).pose

    def pose_at(self, ms: float, start: Pose = REST) -> Pose:
        """Where the body is ``ms`` after the beginning, having begun in ``start``.

        Each way from keyframe to keyframe is eased at both ends by half a cosine, so that nothing jerks.
        """
        after = bisect_right(self.keyframes, ms, key=lambda frame: frame.at_ms)
        if after == len(self.keyframes):
            return self.keyframes[-1].pose
        goal = self.keyframes[after]
        origin: Pose = self.keyframes[after - 1] if after else start
        begins = self.keyframes[after - 1].at_ms if after else 0
        share = (1 - math.cos(math.pi * (ms - begins) / (goal.at_ms - begins))) / 2
        return Pose(*(getattr(origin, j) + share * (getattr(goal, j) - getattr(origin, j)) for j in JOINTS))

    def problems(self, name: str) -> list[str]:
        """What is wrong with it, a sentence each."""
        if not self.keyframes:
            return [f"The gesture {name} has no keyframes."]
        times = [frame.at_ms for frame in self.keyframes]
        found = []
        if times != sorted(set(times)) or times[0] < 0:
            found.append(f"The keyframes of {name} have to come one after the other, none before 0 ms.")
        if times[-1] > LONGEST_MS:
            found.append(f"The gesture {name} takes {times[-1]} ms; at most {LONGEST_MS} are allowed.")
        for frame in self.keyframes:
            found += [
                f"In {name} at {frame.at_ms} ms {joint} is {value:g}; it has to lie between -1 and 1."
                for joint in JOINTS
                if not -1 <= (value := getattr(frame, joint)) <= 1
            ]
        if any(getattr(self.keyframes[-1], joint) for joint in JOINTS):
            found.append(f"The gesture {name} has to end at rest: its last keyframe moves no joint.")
        return found
