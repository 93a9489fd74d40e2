"""Ten kinds of reach, as people make them: which joints turn, by how much and when, drawn anew for
each person.

Angles are within those of daily life: Safaee-Rad et al. (1990, Arch Phys Med Rehabil 71:505-509)
for feeding and drinking, Gates et al. (2016, Am J Occup Ther 70:7001350010) for the trunk and eight
activities. Drinking has the times of the healthy people of de los Reyes-Guzmán et al. (2010, J
Neuroeng Rehabil 7:41, table 2), slow reaches the submovements and stops that Rohrer et al. (2002, J
Neurosci 22:8297-8304) found after stroke.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.body_model import Joint, Stroke

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


def _lift_extend_touch(draw: Draw) -> ReachPlan:
    """Lift the hand, extend the arm, lower it on the target; lift it off and come back."""
    lift_s, extend_s, touch_s = (
        draw.between(0.3, 0.5),
        draw.between(0.6, 1.1),
        draw.between(0.2, 0.35),
    )
    lifted, flexion = draw.degrees(8, 20), draw.degrees(18, 38)
    lift = (
        Stroke("elbow_flexion", lifted, 0.0, lift_s),
        Stroke("shoulder_flexion", draw.degrees(2, 8), 0.1 * lift_s, 0.9 * lift_s),
    )
    at = lift_s * draw.between(0.35, 0.8)
    extend = draw.together(
        at,
        extend_s,
        {
            "shoulder_flexion": flexion,
            "elbow_flexion": -flexion - lifted * draw.between(0.0, 0.6),
            "shoulder_rotation": draw.side(draw.degrees(18, 38)),
            "supination": draw.degrees(-10, 20),
            "trunk_flexion": draw.degrees(0, 6),
        },
    )
    at = end_of(extend) - draw.between(0.08, 0.2)
    touch = draw.together(
        at,
        touch_s,
        {"shoulder_flexion": -draw.degrees(2, 5), "wrist_extension": -draw.degrees(4, 10)},
    )
    out = (*lift, *extend, *touch)
    at = end_of(out) + draw.between(0.1, 0.7)
    off_s = draw.between(0.2, 0.35)
    off = Stroke("wrist_extension", draw.degrees(5, 12), at, off_s)
    back = draw.reverse((*out, off), at + off_s * draw.between(0.3, 0.8), draw.between(0.7, 1.2))
    return ReachPlan(draw.table(), out, (off, *back))


def _from_the_side(draw: Draw) -> ReachPlan:
    """Bring the hand from beside the thigh on a table: the upper arm is abducted first."""
    posture: dict[Joint, float] = {
        "shoulder_flexion": draw.degrees(-5, 10),
        "shoulder_abduction": draw.degrees(8, 18),
        "shoulder_rotation": draw.degrees(-5, 20),
        "elbow_flexion": draw.degrees(55, 75),
        "supination": draw.degrees(5, 45),
        "wrist_extension": draw.degrees(0, 15),
    }
    lead_s, duration_s = draw.between(0.1, 0.3), draw.between(0.7, 1.2)
    abduction = Stroke("shoulder_abduction", draw.degrees(25, 45), 0.0, draw.between(0.6, 1.0))
    rest = draw.together(
        lead_s,
        duration_s,
        {
            "shoulder_flexion": draw.degrees(15, 35),
            "elbow_flexion": draw.degrees(-15, 25),
            "shoulder_rotation": draw.degrees(-25, 10),
            "supination": -draw.degrees(0, 30),
        },
    )
    out = (abduction, *rest)
    at = end_of(out) + draw.between(0.1, 0.8)
    return ReachPlan(posture, out, draw.reverse(out, at, draw.between(0.8, 1.4)))


def _cross_arm(draw: Draw) -> ReachPlan:
    """Swipe across the body, and back almost at once."""
    out = draw.together(
        0.0,
        draw.between(0.5, 0.9),
        {
            "shoulder_rotation": draw.degrees(40, 65),
            "shoulder_flexion": draw.degrees(5, 20),
            "elbow_flexion": draw.degrees(-15, 8),
            "trunk_rotation": draw.degrees(0, 15),
            "supination": -draw.degrees(0, 15),
        },
    )
    back = draw.reverse(out, end_of(out) + draw.between(0.0, 0.15), draw.between(0.55, 1.0))
    return ReachPlan({**draw.table(), "shoulder_rotation": draw.degrees(-20, 15)}, out, back)


def _drinking(draw: Draw) -> ReachPlan:
    """Reach for a glass, stop, drink; put it back, stop, return. The target is the mouth: the hand
    turns most there.
    """
    reach = draw.together(
        0.0,
        draw.between(0.7, 1.1),
        {
            "shoulder_flexion": draw.degrees(18, 32),
            "elbow_flexion": -draw.degrees(18, 35),
            "supination": draw.degrees(40, 65),
            "shoulder_rotation": draw.degrees(-12, 12),
        },
    )
    mouth = draw.together(
        end_of(reach) + draw.between(0.15, 0.45),
        draw.between(0.8, 1.3),
        {
            "elbow_flexion": draw.degrees(60, 80),
            "shoulder_flexion": draw.degrees(5, 18),
            "shoulder_abduction": draw.degrees(8, 20),
            "supination": draw.degrees(0, 20),
            "wrist_extension": draw.degrees(-8, 8),
        },
    )
    down = draw.reverse(mouth, end_of(mouth) + draw.between(0.6, 1.6), draw.between(1.1, 1.6))
    home = draw.reverse(reach, end_of(down) + draw.between(0.15, 0.45), draw.between(0.9, 1.4))
    return ReachPlan(draw.table(), (*reach, *mouth), (*down, *home))


def _two_hand_push(draw: Draw) -> ReachPlan:
    """Push a thing away with both hands: the elbow extends as the shoulder flexes, the forearm
    stays about level.
    """
    flexion = draw.degrees(25, 45)
    out = draw.together(
        0.0,
        draw.between(1.0, 1.6),
        {
            "shoulder_flexion": flexion,
            "elbow_flexion": -flexion - draw.degrees(-6, 6),
            "shoulder_rotation": draw.degrees(2, 10),
            "supination": -draw.degrees(6, 14),
        },
    )
    back = draw.reverse(out, end_of(out) + draw.between(0.1, 0.6), draw.between(1.0, 1.6))
    return ReachPlan({**draw.table(), "supination": draw.degrees(20, 45)}, out, back)


def _forearm_rotation(draw: Draw) -> ReachPlan:
    """Reach while the palm turns up, as for a thing that is handed over."""
    reach = draw.together(
        0.0,
        draw.between(0.7, 1.1),
        {
            "shoulder_flexion": draw.degrees(15, 30),
            "elbow_flexion": -draw.degrees(15, 35),
            "shoulder_rotation": draw.side(draw.degrees(3, 12)),
        },
    )
    turn = Stroke(
        "supination", draw.degrees(60, 100), draw.between(0.05, 0.4), draw.between(0.5, 0.9)
    )
    out = (*reach, turn)
    back = draw.reverse(out, end_of(out) + draw.between(0.1, 0.8), draw.between(0.8, 1.3))
    return ReachPlan(draw.table(), out, back)


def _trunk_lean(draw: Draw) -> ReachPlan:
    """Reach by leaning forward, with little of the arm."""
    lean = Stroke("trunk_flexion", draw.degrees(15, 30), 0.0, draw.between(1.0, 1.6))
    flexion = draw.degrees(5, 14)
    arm = draw.together(
        draw.between(0.1, 0.4),
        draw.between(0.8, 1.2),
        {
            "shoulder_flexion": flexion,
            "elbow_flexion": -flexion * draw.between(0.7, 1.2),
            "trunk_rotation": draw.degrees(0, 12),
        },
    )
    out = (lean, *arm)
    back = draw.reverse(out, end_of(out) + draw.between(0.1, 0.8), draw.between(1.1, 1.8))
    return ReachPlan(draw.table(), out, back)


def _button_press(draw: Draw) -> ReachPlan:
    """Reach for a button, press it by a quick turn of the wrist, let go and come back."""
    flexion = draw.degrees(18, 32)
    reach = draw.together(
        0.0,
        draw.between(0.6, 1.0),
        {
            "shoulder_flexion": flexion,
            "elbow_flexion": -flexion - draw.degrees(5, 18),
            "shoulder_rotation": draw.side(draw.degrees(6, 20)),
        },
    )
    angle, press_s = draw.degrees(10, 24), draw.between(0.18, 0.3)
    press = Stroke("wrist_extension", -angle, end_of(reach) - draw.between(-0.15, 0.1), press_s)
    out = (*reach, press)
    letting_go = Stroke(
        "wrist_extension", angle, end_of(out) + draw.between(0.03, 0.2), draw.between(0.18, 0.35)
    )
    back = draw.reverse(reach, letting_go.end_s - draw.between(-0.15, 0.1), draw.between(0.7, 1.1))
    return ReachPlan(
        {**draw.table(), "wrist_extension": draw.degrees(5, 20)}, out, (letting_go, *back)
    )


def _submovements(draw: Draw) -> ReachPlan:
    """Reach after a stroke: slowly, in submovements of changing joints, with stops."""
    turns: dict[Joint, float] = {
        "shoulder_flexion": draw.degrees(15, 35),
        "elbow_flexion": -draw.degrees(25, 50),
        "shoulder_rotation": draw.side(draw.degrees(8, 25)),
        "shoulder_abduction": draw.degrees(0, 20),
        "trunk_flexion": draw.degrees(0, 15),
    }

    def way(turns: Turns, at: float) -> Strokes:
        strokes: list[Stroke] = []
        count = int(draw.generator.integers(2, 5))
        for shares in draw.generator.dirichlet(np.full(count, 2.0), len(turns)).T.tolist():
            duration = draw.between(0.5, 1.0)
            strokes += [
                Stroke(joint, angle * share, at, duration, "lognormal")
                for (joint, angle), share in zip(turns.items(), shares, strict=True)
            ]
            at += duration * draw.between(0.5, 1.0) + (
                draw.between(0.1, 0.4) if draw.generator.random() < 0.3 else 0.0
            )
        return tuple(strokes)

    out = way(turns, 0.0)
    back = way(
        {joint: -angle for joint, angle in turns.items()}, end_of(out) + draw.between(0.1, 0.8)
    )
    return ReachPlan(draw.table(), out, back)


def _point_and_hold(draw: Draw) -> ReachPlan:
    """Raise the arm, point at a thing for 1 to 3 s, and lower it."""
    lift_s = draw.between(0.3, 0.5)
    lift = Stroke("elbow_flexion", draw.degrees(5, 15), 0.0, lift_s)
    point = draw.together(
        lift_s * draw.between(0.2, 0.7),
        draw.between(0.7, 1.2),
        {
            "shoulder_flexion": draw.degrees(42, 65),
            "elbow_flexion": -draw.degrees(15, 35),
            "shoulder_rotation": draw.side(draw.degrees(5, 20)),
            "supination": draw.degrees(-5, 30),
        },
    )
    out = (lift, *point)
    back = draw.reverse(out, end_of(out) + draw.between(1.0, 3.0), draw.between(0.8, 1.4))
    return ReachPlan(draw.table(), out, back)


_KINDS: dict[str, Callable[[Draw], ReachPlan]] = {
    "lift-extend-touch": _lift_extend_touch,
    "from-the-side": _from_the_side,
    "cross-arm": _cross_arm,
    "drinking": _drinking,
    "two-hand-push": _two_hand_push,
    "forearm-rotation": _forearm_rotation,
    "trunk-lean": _trunk_lean,
    "button-press": _button_press,
    "submovements": _submovements,
    "point-and-hold": _point_and_hold,
}
KINDS = tuple(_KINDS)
"""Names of the kinds of reach."""


def plan(kind: str, generator: np.random.Generator) -> ReachPlan:
    """Return a person's reach of a kind in ``KINDS``."""
    return _KINDS[kind](Draw(generator))
