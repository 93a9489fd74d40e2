"""Gestures as keyframes, for drawn and real robots."""

import math
from bisect import bisect_right

import msgspec

GESTURES = ("nod", "shake", "cheer", "wave", "point_left", "point_right", "lean_in", "rest")
"""Gestures of every theme."""
JOINTS = ("nod", "turn", "left_arm", "right_arm", "lean")
"""Joints of a body: the head down (1) or up, turned to the participant's right (1) or left; the
arms raised (1); the body towards the participant (1). 0 is rest; a robot without a joint leaves it
out.
"""
LONGEST_MS = 10_000
"""Longest gesture."""


class Pose(msgspec.Struct, frozen=True):
    """Position of each joint, from -1 to 1; 0 is rest."""

    nod: float = 0.0
    turn: float = 0.0
    left_arm: float = 0.0
    right_arm: float = 0.0
    lean: float = 0.0


REST = Pose()


class Keyframe(Pose, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose, and its time in ms from the start of the gesture."""

    at_ms: int

    @property
    def pose(self) -> Pose:
        """The pose alone."""
        return Pose(*(getattr(self, joint) for joint in JOINTS))


class Gesture(msgspec.Struct, frozen=True):
    """A movement through keyframes, from the present pose to the last keyframe."""

    keyframes: tuple[Keyframe, ...]

    @property
    def duration_ms(self) -> int:
        """Time from the start to the last keyframe."""
        return self.keyframes[-1].at_ms

    @property
    def farthest(self) -> Pose:
        """The keyframe farthest from rest, for a still picture."""
        return max(
            self.keyframes, key=lambda frame: sum(abs(getattr(frame, joint)) for joint in JOINTS)
        ).pose

    def pose_at(self, ms: float, start: Pose = REST) -> Pose:
        """Return the pose ``ms`` after the start of the gesture in ``start``.

        The movement between keyframes is eased by half a cosine.
        """
        after = bisect_right(self.keyframes, ms, key=lambda frame: frame.at_ms)
        if after == len(self.keyframes):
            return self.keyframes[-1].pose
        goal = self.keyframes[after]
        origin: Pose = self.keyframes[after - 1] if after else start
        begins = self.keyframes[after - 1].at_ms if after else 0
        share = (1 - math.cos(math.pi * (ms - begins) / (goal.at_ms - begins))) / 2
        return Pose(
            *(getattr(origin, j) + share * (getattr(goal, j) - getattr(origin, j)) for j in JOINTS)
        )

    def problems(self, name: str) -> list[str]:
        """Return what is wrong with the gesture, one sentence each."""
        if not self.keyframes:
            return [f"The gesture {name} has no keyframes."]
        times = [frame.at_ms for frame in self.keyframes]
        found = []
        if times != sorted(set(times)) or times[0] < 0:
            found.append(f"The keyframes of {name} must be in order of time, none before 0 ms.")
        if times[-1] > LONGEST_MS:
            found.append(
                f"The gesture {name} takes {times[-1]} ms; at most {LONGEST_MS} are allowed."
            )
        for frame in self.keyframes:
            found += [
                f"In {name} at {frame.at_ms} ms {joint} is {value:g}; it must be between -1 and 1."
                for joint in JOINTS
                if not -1 <= (value := getattr(frame, joint)) <= 1
            ]
        if any(getattr(self.keyframes[-1], joint) for joint in JOINTS):
            found.append(f"The gesture {name} must end at rest: its last keyframe moves no joint.")
        return found
