"""Simulated reaches that turn the hand about many axes: the sensor's samples, with the true times
of each reach.

A movement is the angle of every joint at any time. The sensor's orientation and position follow
from the chain of segments, its angular rate and acceleration from these by differentiation, and the
true times from the strokes.
"""

import math
from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.body_model import STILL, Joint, Pose, Segment, Site, Stroke, pose
from sar_tui.motion.imperfections import Measured, StrappedSensor, ordinary, spoil
from sar_tui.motion.quaternions import (
    angle,
    conjugate,
    from_rotation,
    multiply,
    rotate,
    to_rotation,
)
from sar_tui.motion.reach import Hand
from sar_tui.motion.reach_kinds import KINDS, ReachPlan, end_of, plan, repeated
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.synthesis import BLOCK, Profile, ReachShape, SimulatedHand

GRAVITY_M_S2 = 9.81
MOVING = 0.02
"""The hand moves while it turns at this share of a way's largest rate; see ``ReachTimes``."""
TIMED_S = 0.004
"""Step in which the true times are sought. They are interpolated: their error is below 1 ms."""
STEP_S = 0.0005
"""Half the step of differentiation. Its error is below 0.001 rad/s and 0.001 m/s² in the fastest
reach.
"""
MARGIN_S = 0.3
"""A lognormal stroke is sought this long before its begin and after its end."""
SHAKES_IN_S = 0.2
"""Time in which an action tremor rises after an onset, and falls before an end."""
PLACEMENTS = ("back of the hand", "side", "palm", "askew")
"""Places of the sensor on the hand: as in the thesis' Figure 4.7; turned by 90° and 180° about the
forearm; tilted by up to 35° about any axis. All are drawn for the sternum likewise.
"""
TILT = math.radians(35)


class Tremor(NamedTuple):
    """An oscillation of a joint. Its frequency wanders a little, as in reality.

    ``spans``: onset and end of the movements it comes with; None if it is always there.
    """

    joint: Joint
    rate_rad_s: float
    hz: float
    phase: float
    spans: tuple[tuple[float, float], ...] | None = None

    def at(self, time_s: Floats) -> Floats:
        """Return its angle at each time, rad, shape (n,)."""
        angle = self.rate_rad_s / (2.0 * math.pi * self.hz)
        course: Floats = angle * np.sin(
            2.0 * math.pi * self.hz * time_s + 0.5 * np.sin(2.0 * time_s) + self.phase
        )
        if self.spans is None:
            return course
        inside = [
            np.minimum(time_s - onset, end - time_s) / SHAKES_IN_S for onset, end in self.spans
        ]
        u = np.clip(np.max(inside, axis=0, initial=0.0), 0.0, 1.0)
        course *= u**3 * (10.0 + u * (6.0 * u - 15.0))
        return course


class ReachTimes(NamedTuple):
    """The true times of a reach, s, from the rate at which the hand turns, about any axis, without
    its tremor.

    On the way to the target the hand turns by 2 % or more of its largest rate there from
    ``onset_s`` to ``arrival_s``, on the way back by 2 % or more of its largest rate there from
    ``departure_s`` to ``end_s``: so Alt Murphy, Willén & Sunnerhagen (2011, Neurorehabil Neural
    Repair 25:71-80) bound the movements of patients. Stops may be in between.
    """

    onset_s: float
    arrival_s: float
    departure_s: float
    end_s: float


class _Reach(NamedTuple):
    """The strokes to a target and back."""

    out: tuple[Stroke, ...]
    back: tuple[Stroke, ...]


class Movement(msgspec.Struct, frozen=True):
    """The angles of all joints at any time: a posture, strokes and tremors."""

    posture: dict[Joint, float]
    strokes: tuple[Stroke, ...]
    tremors: tuple[Tremor, ...] = ()

    def angles(self, time_s: Floats) -> dict[Joint, Floats]:
        """Return the angle of each joint at each time, rad, shape (n,)."""
        angles = {joint: np.full(len(time_s), angle) for joint, angle in self.posture.items()}
        parts: tuple[Stroke | Tremor, ...] = (*self.strokes, *self.tremors)
        for part in parts:
            turned = part.at(time_s)
            angles[part.joint] = angles[part.joint] + turned if part.joint in angles else turned
        return angles

    def pose(self, site: Site, time_s: Floats) -> Pose:
        """Return orientation and position of a sensor at each time."""
        return pose(self.angles(time_s), site, len(time_s))


class SimulatedReaches(NamedTuple):
    """A recording of simulated reaches, with the truth.

    ``recording``: of the sensor on the hand. ``truth``: onset and end of each reach, s. ``times``:
    the same with arrival and departure. ``movement`` and ``site``: of what the recording was made;
    their ``pose`` is the true orientation. ``sternum``: recording of a second sensor, on the
    sternum; None if not requested.
    """

    recording: Recording
    truth: tuple[tuple[float, float], ...]
    times: tuple[ReachTimes, ...]
    movement: Movement
    site: Site
    sternum: Recording | None = None


def simulate_reaches(
    kind: str,
    seed: int,
    *,
    arm: Hand = "right",
    placement: int = 0,
    accelerometer: bool = True,
    rate_hz: float = 100.0,
    count: int = 1,
    rest_s: float = 2.0,
    imperfections: StrappedSensor | None = None,
    sternum: bool = False,
) -> SimulatedReaches:
    """Return reaches of one person one after the other, with ``rest_s`` of rest before, between and
    after them.

    Args:
        kind: a name in ``KINDS``.
        seed: of the person, and of all that differs from reach to reach. The movement depends on
            it, the kind, the count and the rest alone, so that the same movement can be seen by any
            sensor at any place.
        arm: with the sensor. The left arm makes the mirrored movement.
        placement: index in ``PLACEMENTS``.
        accelerometer: False for a sensor that has none.
        rate_hz: samples per second.
        count: number of reaches.
        rest_s: duration of each rest.
        imperfections: of sensor and hand; those of an ordinary one by this seed if None, which
            shakes if it points and holds. ``PERFECT`` has none.
        sternum: True for a second sensor, on the sternum.

    Raises ValueError for an unknown kind or placement.
    """
    if kind not in KINDS:
        raise ValueError(
            f"There is no kind of reach named {kind!r}; there are: {', '.join(KINDS)}."
        )
    if not 0 <= placement < len(PLACEMENTS):
        raise ValueError(f"There are {len(PLACEMENTS)} placements, from 0: {placement} is none.")
    number = KINDS.index(kind)
    if imperfections is None:
        imperfections = ordinary(
            np.random.default_rng([seed, number, 1]), shaking=kind == "point-and-hold"
        )
    generator = np.random.default_rng([seed, number, 0])
    person = plan(kind, generator)
    reaches = _session(person, generator, count, rest_s)
    still = Movement(
        person.posture, tuple(stroke for reach in reaches for stroke in (*reach.out, *reach.back))
    )
    times = tuple(_times(still, reach) for reach in reaches)
    movement = msgspec.structs.replace(still, tremors=_tremors(imperfections, times, generator))
    until_s = max((stroke.end_s for stroke in movement.strokes), default=0.0) + rest_s
    turned = placed(placement, seed)

    def record(segment: Segment) -> tuple[Site, Recording]:
        site = Site(segment, arm, turned)
        noise = np.random.default_rng([seed, number, 2 if segment == "hand" else 3])
        return site, _recorded(
            movement, site, until_s, rate_hz, imperfections, noise, accelerometer
        )

    site, recording = record("hand")
    truth = tuple((time.onset_s, time.end_s) for time in times)
    return SimulatedReaches(
        recording, truth, times, movement, site, record("sternum")[1] if sternum else None
    )


def placed(placement: int, seed: int = 0) -> tuple[float, float, float, float]:
    """Return a sensor's orientation on its segment for an index in ``PLACEMENTS``, a quaternion."""
    if placement < 3:
        turned = from_rotation(np.array((0.0, placement * math.pi / 2.0, 0.0)))
    else:
        generator = np.random.default_rng([seed, 5])
        axis = generator.standard_normal(3)
        turned = from_rotation(axis / np.linalg.norm(axis) * TILT * generator.uniform(0.5, 1.0))
    w, x, y, z = turned.tolist()
    return w, x, y, z


def measure(movement: Movement, site: Site, time_s: Floats) -> Measured:
    """Return the output of a perfect sensor on a moving body.

    The angular rate is the change of its orientation q, 2 q* q′, and the acceleration that of its
    position p, as seen from its axes: q* (p″ + g) q. At rest an accelerometer reports g, 9.81 m/s²
    upwards.
    """
    count = len(time_s)
    orientation, position = movement.pose(
        site, np.concatenate((time_s - STEP_S, time_s, time_s + STEP_S))
    )
    before, now, after = (orientation[i * count : (i + 1) * count] for i in range(3))
    rate = to_rotation(multiply(conjugate(before), after)) / (2.0 * STEP_S)
    curve = (
        position[:count] - 2.0 * position[count : 2 * count] + position[2 * count :]
    ) / STEP_S**2
    return Measured(
        time_s, rate, rotate(conjugate(now), curve + np.array((0.0, 0.0, GRAVITY_M_S2)))
    )


def _session(
    person: ReachPlan, generator: np.random.Generator, count: int, rest_s: float
) -> list[_Reach]:
    """Return the strokes of all reaches of a person, with a rest before each."""
    reaches: list[_Reach] = []
    left: dict[Joint, float] = {}
    begin_s = rest_s
    for _ in range(count):
        out, back, left = repeated(person, generator, begin_s, left)
        reaches.append(_Reach(out, back))
        begin_s = max(stroke.end_s for stroke in back) + rest_s
    return reaches


def _times(movement: Movement, reach: _Reach) -> ReachTimes:
    """Return the true times of a reach in a movement without tremor."""
    arrival_s, departure_s = (
        max(stroke.end_s for stroke in reach.out),
        min(stroke.begin_s for stroke in reach.back),
    )
    begin_s, end_s = (
        min(stroke.begin_s for stroke in reach.out),
        max(stroke.end_s for stroke in reach.back),
    )
    turn_s = (arrival_s + departure_s) / 2.0
    onset, arrival = _moving(movement, begin_s - MARGIN_S, turn_s)
    departure, end = _moving(movement, turn_s, end_s + MARGIN_S)
    return ReachTimes(onset, arrival, departure, end)


def _moving(movement: Movement, from_s: float, to_s: float) -> tuple[float, float]:
    """Return from when to when the hand turns at ``MOVING`` or more of its largest rate between two
    times.
    """
    time_s = np.arange(from_s, to_s + TIMED_S, TIMED_S)
    orientation = movement.pose(Site(), time_s).orientation
    speed = angle(multiply(conjugate(orientation[:-1]), orientation[1:]))
    level = MOVING * speed.max()
    above = np.flatnonzero(speed >= level)
    middle_s = time_s[:-1] + TIMED_S / 2.0
    first, last = int(above[0]), int(above[-1])
    onset = (
        np.interp(level, speed[first - 1 : first + 1], middle_s[first - 1 : first + 1])
        if first
        else from_s
    )
    stop = (
        np.interp(level, speed[[last + 1, last]], middle_s[[last + 1, last]])
        if last + 1 < len(speed)
        else to_s
    )
    return float(onset), float(stop)


def _tremors(
    hand: StrappedSensor, times: Sequence[ReachTimes], generator: np.random.Generator
) -> tuple[Tremor, ...]:
    """Return the tremors of a hand: mostly of the forearm, half as much of the wrist, a quarter of
    a period later.
    """
    phases = generator.uniform(0.0, 2.0 * math.pi, 2).tolist()
    spans = tuple((time.onset_s, time.end_s) for time in times)
    kinds = (
        (hand.tremor_rad_s, hand.tremor_hz, phases[0], None),
        (hand.action_tremor_rad_s, hand.action_tremor_hz, phases[1], spans),
    )
    return tuple(
        tremor
        for size, hz, phase, when in kinds
        if size
        for tremor in (
            Tremor("supination", size, hz, phase, when),
            Tremor("wrist_extension", size / 2.0, hz, phase + math.pi / 2.0, when),
        )
    )


def _recorded(
    movement: Movement,
    site: Site,
    until_s: float,
    rate_hz: float,
    sensor: StrappedSensor,
    generator: np.random.Generator,
    accelerometer: bool,
) -> Recording:
    time_s = np.arange(math.ceil(until_s * rate_hz)) / rate_hz
    output = spoil(measure(movement, site, time_s), sensor, rate_hz, generator)
    return Recording(
        time_s=output.time_s,
        rate=output.rate,
        acceleration=output.acceleration if accelerometer else None,
    )


class _Move(NamedTuple):
    """A reach: its onset, ns, its strokes, in s from there, and by how much the joints are off the
    posture after it.
    """

    onset_ns: int
    strokes: tuple[Stroke, ...]
    left: dict[Joint, float]


class SimulatedArm(SimulatedHand):
    """A hand whose reaches are those of a person, of one kind; each has the duration of the
    requested shape.

    A reach that is shorter than the person's own is also smaller, by the square root of the time.

    Args:
        kind: a name in ``reach_kinds.KINDS``.
        profile: imperfections of sensor and hand. Its axis is that of the tremor.
        rate_hz: samples per second.
        seed: the seed of the person, of what differs from reach to reach, and of noise.
    """

    def __init__(self, kind: str, profile: Profile, rate_hz: float = 250.0, seed: int = 0) -> None:
        super().__init__(profile, rate_hz, seed)
        self.kind = kind
        self._person = plan(kind, np.random.default_rng([seed, 2]))
        self._made: list[_Move] = []

    def move(self, at_ns: int, shape: ReachShape) -> None:
        """Make a reach with its onset at ``at_ns``, of the shape's duration. Reaches that overlap
        add up.
        """
        size = min(1.0, math.sqrt(shape.duration_s / end_of(self._person.back)))
        left = self._made[-1].left if self._made else {}
        generator = np.random.default_rng([self._seed, 3, len(self._made)])
        out, back, missed = repeated(
            self._person, generator, 0.0, {joint: off / size for joint, off in left.items()}
        )
        pace = shape.duration_s / end_of(back)
        strokes = tuple(
            Stroke(
                stroke.joint,
                size * stroke.angle,
                pace * stroke.begin_s,
                pace * stroke.duration_s,
                stroke.form,
            )
            for stroke in (*out, *back)
        )
        self._made.append(
            _Move(at_ns, strokes, {joint: size * off for joint, off in missed.items()})
        )
        still_s = max(stroke.begin_s + STILL[1] * stroke.duration_s for stroke in strokes) + STEP_S
        over_ns = at_ns + math.ceil(still_s * 1e9)
        self._over_ns.append(max(over_ns, self._over_ns[-1]) if self._over_ns else over_ns)

    def _motion(self, at: npt.NDArray[np.int64], tremor: Floats) -> tuple[Floats, Floats]:
        if not len(at):
            return np.empty((0, 3)), np.empty((0, 3))
        assert self._start_ns is not None
        first, last = ((int(time) - self._start_ns) // self._period_ns for time in at[[0, -1]])
        blocks = range(first // BLOCK, last // BLOCK + 1)
        outputs = [self._measured(block * BLOCK, self._start_ns) for block in blocks]
        wanted = slice(first - blocks.start * BLOCK, last + 1 - blocks.start * BLOCK)
        rate, acceleration = (np.concatenate(parts)[wanted] for parts in zip(*outputs, strict=True))
        return rate + tremor[:, None] * self._along, acceleration

    def _measured(self, index: int, start_ns: int) -> tuple[Floats, Floats]:
        """Return angular rate and acceleration of a block: the same numbers however calls of
        ``samples`` divide it.
        """
        time_s = np.arange(index, index + BLOCK) * (self._period_ns / 1e9)
        over = bisect_left(self._over_ns, start_ns + index * self._period_ns)
        posture = dict(self._person.posture)
        for joint, off in self._made[over - 1].left.items() if over else ():
            posture[joint] = posture.get(joint, 0.0) + off
        strokes = [
            msgspec.structs.replace(
                stroke, begin_s=stroke.begin_s + (move.onset_ns - start_ns) / 1e9
            )
            for move in self._made[over:]
            for stroke in move.strokes
        ]
        output = measure(Movement(posture, tuple(strokes)), Site(), time_s)
        return output.rate, output.acceleration
