"""Shape of a simulated reach: the angular rate and the angle of the hand at every moment."""

from functools import lru_cache
from typing import NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.samples import Floats

STEP_S = 0.001
TWITCH_S = 0.08
TAIL = 0.02


class ReachShape(msgspec.Struct, frozen=True, kw_only=True):
    """An ideal reach: out to the target, a rest there, and back.

    Its onset is at 0 and its end at ``duration_s``. A minimum-jerk lobe is exactly still outside of
    them. A lognormal submovement never quite begins or ends: its onset and end are where the speed
    is 2 % of its phase's peak, as Alt Murphy, Willén & Sunnerhagen (2011, Neurorehabil Neural
    Repair 25:71-80) bound the movements of patients.

    Args:
        out_s: duration of the way out, s.
        back_s: duration of the way back, s.
        dwell_s: the rest at the target, s.
        peak_out: largest angular rate on the way out, rad/s, positive.
        peak_back: largest angular rate on the way back, rad/s, negative.
        submovements: 0 for one minimum-jerk lobe per phase; otherwise the number of lognormal
            submovements in all, at least two.
        twitch: True for an involuntary jerk of 80 ms, 0.9 to 1.2 s before the onset.
        seed: the seed of the submovements and the twitch.
    """

    out_s: float
    back_s: float
    dwell_s: float = 0.0
    peak_out: float = 1.5
    peak_back: float = -2.0
    submovements: int = 0
    twitch: bool = False
    seed: int = 0

    @property
    def duration_s(self) -> float:
        """From onset to end, s."""
        return self.out_s + self.dwell_s + self.back_s


class Waveform(NamedTuple):
    """A reach in steps of 1 ms: time since its onset (s), angular rate (rad/s), angle (rad),
    acceleration (rad/s²).
    """

    time_s: Floats
    rate: Floats
    angle: Floats
    acceleration: Floats


def minimum_jerk(u: Floats) -> Floats:
    """Return the speed of the smoothest movement, 1 at its peak, at the share ``u`` of its time
    (Flash & Hogan 1985).

    30u² − 60u³ + 30u⁴ over its largest value 30/16; 0 outside of 0 to 1.
    """
    inside = np.clip(u, 0.0, 1.0)
    return 16.0 * inside**2 * (1.0 - inside) ** 2


def _lognormals(time: Floats, count: int, generator: np.random.Generator) -> Floats:
    """Return a sum of ``count`` overlapping lognormal speed profiles (Plamondon 1995), each of
    median 1.
    """
    speed = np.zeros_like(time)
    begins = np.concatenate(([0.0], np.cumsum(generator.uniform(0.6, 1.0, count - 1))))
    widths = generator.uniform(0.25, 0.4, count)
    sizes = generator.uniform(0.6, 1.0, count)
    for begin, width, size in zip(begins, widths, sizes, strict=True):
        elapsed = np.maximum(time - begin, 1e-9)
        speed += size / (width * elapsed) * np.exp(-(np.log(elapsed) ** 2) / (2 * width**2))
    return speed


@lru_cache(maxsize=64)
def _submovements(count: int, seed: int, phase: int) -> tuple[Floats, Floats]:
    """Return a phase of submovements: time, from 0 to 1 between the 2 % marks, and speed, 1 at its
    peak.
    """
    time = np.linspace(0.0, count + 4.0, 4000)
    speed = _lognormals(time, count, np.random.default_rng([seed, phase]))
    speed /= speed.max()
    moving = np.flatnonzero(speed >= TAIL)
    first, last = time[moving[0]], time[moving[-1]]
    return (time - first) / (last - first), speed


def _phase(u: Floats, count: int, seed: int, phase: int) -> Floats:
    """Return the speed of one phase, 1 at its peak, at the share ``u`` of its time."""
    if not count:
        return minimum_jerk(u)
    time, speed = _submovements(count, seed, phase)
    return np.interp(u, time, speed, left=0.0, right=0.0)


def _twitch(time: Floats, seed: int) -> Floats:
    """Return an involuntary jerk of 80 ms, of 0.5 to 1.5 rad/s in either direction."""
    generator = np.random.default_rng([seed, 2])
    begin = -generator.uniform(0.9, 1.2)
    peak = generator.uniform(0.5, 1.5) * generator.choice((-1.0, 1.0))
    jerk: Floats = peak * minimum_jerk((time - begin) / TWITCH_S)
    return jerk


@lru_cache(maxsize=64)
def waveform(shape: ReachShape) -> Waveform:
    """Return a whole reach, from 1.5 s before its onset to 1.5 s after its end.

    Raises ValueError for an impossible duration or number of submovements.
    """
    if min(shape.out_s, shape.back_s) <= 0 or shape.dwell_s < 0:
        raise ValueError(
            "A reach takes time: out_s and back_s must be above 0, dwell_s 0 or above."
        )
    if shape.submovements < 0 or shape.submovements == 1:
        raise ValueError("A reach has two phases: submovements must be 0, or 2 and above.")
    time = np.arange(-1.5, shape.duration_s + 1.5, STEP_S)
    back = shape.submovements // 2
    out_u = time / shape.out_s
    back_u = (time - shape.out_s - shape.dwell_s) / shape.back_s
    rate = shape.peak_out * _phase(out_u, shape.submovements - back, shape.seed, 0)
    rate += shape.peak_back * _phase(back_u, back, shape.seed, 1)
    if shape.twitch:
        rate += _twitch(time, shape.seed)
    return Waveform(time, rate, np.cumsum(rate) * STEP_S, np.gradient(rate, STEP_S))
