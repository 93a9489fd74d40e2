"""Plans of reaches: what all of a person's reaches have in common, and how they differ."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.body_model import Joint
from sar_tui.motion.strokes import Stroke

Turns = Mapping[Joint, float]
"""By how much joints turn, rad."""
Strokes = tuple[Stroke, ...]
MISSED = math.radians(1.5)
"""Standard deviation of each joint's angle when the hand is back, from where it began."""
VARIED = 0.06
"""Standard deviation of the durations and angles of a person's reaches, as a share of them."""


class ReachPlan(NamedTuple):
    """A person's reach: the posture at rest, rad, and the strokes out and back, in s from the
    onset.
    """

    posture: dict[Joint, float]
    out: Strokes
    back: Strokes


class Draw:
    """Random sizes of movements."""

    def __init__(self, generator: np.random.Generator) -> None:
        self.generator = generator

    def degrees(self, least: float, most: float) -> float:
        """Return an angle between two in degrees, in rad."""
        return math.radians(self.generator.uniform(least, most))

    def between(self, least: float, most: float) -> float:
        """Return a number between two."""
        return float(self.generator.uniform(least, most))

    def side(self, angle: float) -> float:
        """Return an angle to either side."""
        return angle if self.generator.random() < 0.5 else -angle

    def table(self) -> dict[Joint, float]:
        """Return the posture of a hand on a table: forearm level within 8°, palm about down."""
        shoulder = self.degrees(8, 25)
        return {
            "shoulder_flexion": shoulder,
            "shoulder_abduction": self.degrees(5, 20),
            "shoulder_rotation": self.degrees(10, 35),
            "elbow_flexion": math.pi / 2.0 - shoulder + self.degrees(-8, 8),
            "supination": self.degrees(0, 25),
            "wrist_extension": self.degrees(0, 15),
        }

    def together(self, at: float, duration: float, turns: Turns) -> Strokes:
        """Return a stroke of each joint. One begins at ``at``, one ends after ``duration``, all
        overlap.
        """
        lead = int(self.generator.integers(len(turns)))
        strokes = []
        for number, (joint, angle) in enumerate(turns.items()):
            begin = 0.0 if number == lead else float(self.generator.uniform(0.0, 0.2))
            end = (
                1.0
                if number == len(turns) - 1 - lead or len(turns) == 1
                else float(self.generator.uniform(0.8, 1.0))
            )
            strokes.append(Stroke(joint, angle, at + begin * duration, (end - begin) * duration))
        return tuple(strokes)

    def reverse(self, strokes: Strokes, at: float, duration: float) -> Strokes:
        """Return one stroke of each joint that takes strokes back."""
        return self.together(
            at, duration, {joint: -angle for joint, angle in _totals(strokes).items()}
        )


def _totals(strokes: Sequence[Stroke]) -> dict[Joint, float]:
    """Return by how much strokes turn each joint in all."""
    totals: dict[Joint, float] = {}
    for stroke in strokes:
        totals[stroke.joint] = totals.get(stroke.joint, 0.0) + stroke.angle
    return totals


def end_of(strokes: Sequence[Stroke]) -> float:
    """Return when the last stroke ends."""
    return max(stroke.end_s for stroke in strokes)


def repeated(
    person: ReachPlan, generator: np.random.Generator, onset_s: float, left: Turns
) -> tuple[Strokes, Strokes, dict[Joint, float]]:
    """Return a person's next reach: its strokes out and back, and by how much the joints are then
    off their posture.

    Args:
        person: the reach that is varied.
        generator: of the differences.
        onset_s: its onset.
        left: by how much the joints are off the posture before it, rad.
    """
    pace = float(np.exp(VARIED * generator.standard_normal()))

    def varied(stroke: Stroke) -> Stroke:
        return msgspec.structs.replace(
            stroke,
            angle=stroke.angle * (1.0 + VARIED * float(generator.standard_normal())),
            begin_s=onset_s + pace * stroke.begin_s,
            duration_s=pace * stroke.duration_s,
        )

    out = tuple(varied(stroke) for stroke in person.out)
    back = [varied(stroke) for stroke in person.back]
    off: dict[Joint, float] = {}
    for joint, total in _totals((*out, *back)).items():
        off[joint] = float(
            np.clip(MISSED * generator.standard_normal(), -2.0 * MISSED, 2.0 * MISSED)
        )
        own = [index for index, stroke in enumerate(back) if stroke.joint == joint]
        largest = max(own, key=lambda index: abs(back[index].angle))
        missing = off[joint] - left.get(joint, 0.0) - total
        back[largest] = msgspec.structs.replace(back[largest], angle=back[largest].angle + missing)
    return out, tuple(back), off
