"""The simulated hand of a person whose whole arm moves: requested reaches become reaches of one
kind.
"""

import math
from bisect import bisect_left
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.body_model import Joint, Site
from sar_tui.motion.reach_kinds import end_of, plan, repeated
from sar_tui.motion.samples import Floats
from sar_tui.motion.shapes import ReachShape
from sar_tui.motion.strokes import STILL, Stroke
from sar_tui.motion.synthesis import BLOCK, Profile, SimulatedHand
from sar_tui.motion.trajectories import STEP_S, Movement, measure


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
