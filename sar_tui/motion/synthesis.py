"""The simulated hand: reaches about one axis as measured by a motion sensor on its back, with
imperfections of sensor and hand; and scenarios of them for tests of detectors.
"""

import math
from bisect import bisect_left
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.motion.imperfections import Imperfections, Vector
from sar_tui.motion.samples import SAMPLE, Floats, Recording, Samples, recording

GRAVITY_M_S2 = 9.81
FOREARM_M = 0.3
ACCELERATION_NOISE_M_S2 = 0.02
BLOCK = 512
SINCE, LUCK, TREMOR = 0, 1, 2
TREMOR_ACROSS, BIAS, RATE_NOISE, ACCELERATION_NOISE = (
    slice(3, 6),
    slice(6, 9),
    slice(9, 12),
    slice(12, 15),
)
COLUMNS = 15
"""Columns of the imperfections of samples: seconds since the first, the draw of the loss, rad/s,
m/s².
"""
STEP_S = 0.001
TWITCH_S = 0.08
TAIL = 0.02
QUIET = math.radians(0.2)
"""Noise of a good gyroscope, rad/s; the default of the scenarios."""


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


class Profile(Imperfections, frozen=True, kw_only=True):
    """Imperfections of a sensor and of a hand that turns about one axis. The tremor's main axis is
    that of the reach.

    Args:
        axis: the axis of the reach in the sensor's axes; of any length. z points out of the back of
            the hand.
        saturation_rad_s: a sample with any axis beyond this is not delivered, as with a Phidget.
    """

    axis: Vector = (0.0, 0.0, 1.0)
    saturation_rad_s: float = math.inf


TILTED: Vector = (0.8, math.sqrt(1 - 0.8**2 - 0.1**2), 0.1)
"""A tilted sensor: a tenth of the reach's rotation is about its z."""


PROFILES: dict[str, Profile] = {
    "clean": Profile(),
    "steady": Profile(noise_rad_s=math.radians(0.3), bias_rad_s=(0.005, -0.005, 0.01)),
    "noisy": Profile(noise_rad_s=math.radians(2)),
    "biased": Profile(bias_rad_s=(math.radians(6), math.radians(-6), math.radians(6))),
    "drifting": Profile(noise_rad_s=math.radians(0.2), drift_rad_s_per_s=math.radians(0.1)),
    "tremor": Profile(noise_rad_s=math.radians(0.2), tremor_rad_s=0.15),
    "tilted": Profile(noise_rad_s=math.radians(0.2), axis=TILTED),
    "lossy": Profile(noise_rad_s=math.radians(0.2), lost=0.1),
    "saturating": Profile(noise_rad_s=math.radians(0.2), saturation_rad_s=3.0),
    "patient": Profile(
        noise_rad_s=math.radians(1),
        bias_rad_s=(math.radians(3), math.radians(-3), math.radians(3)),
        drift_rad_s_per_s=math.radians(0.01),
        tremor_rad_s=0.1,
        axis=(0.4, 0.3, 0.87),
        lost=0.01,
    ),
}
"""Sensors and hands for tests and demonstrations, by name."""


class SimulatedHand:
    """A hand that makes requested reaches, and the samples of the sensor on it.

    The same calls of ``move`` give the same samples, however calls of ``samples`` divide the time.

    Args:
        profile: imperfections of sensor and hand.
        rate_hz: samples per second.
        seed: the seed of noise, losses and the tremor's phase.
    """

    def __init__(self, profile: Profile, rate_hz: float = 250.0, seed: int = 0) -> None:
        self.profile = profile
        self.rate_hz = rate_hz
        self._seed = seed
        self._period_ns = round(1e9 / rate_hz)
        self._start_ns: int | None = None
        self._moves: list[tuple[int, Waveform]] = []
        self._over_ns: list[int] = []
        self._turned = [0.0]
        self._blocks: dict[int, Floats] = {}
        self._along, self._forearm, self._way = _frame(profile.axis)
        up = np.array([0.0, 0.0, GRAVITY_M_S2])
        self._parallel = self._along * (self._along @ up)
        self._upright = up - self._parallel
        self._sideways = np.cross(self._along, up)
        self._tremor_phase = float(np.random.default_rng([seed, 0]).uniform(0.0, 2 * math.pi))

    def move(self, at_ns: int, shape: ReachShape) -> None:
        """Make a reach with its onset at ``at_ns``. Reaches that overlap add up."""
        form = waveform(shape)
        self._moves.append((at_ns, form))
        over_ns = at_ns + math.ceil(form.time_s[-1] * 1e9) + 1
        self._over_ns.append(max(over_ns, self._over_ns[-1]) if self._over_ns else over_ns)
        self._turned.append(self._turned[-1] + float(form.angle[-1]))

    def samples(self, from_ns: int, to_ns: int) -> Samples:
        """Return the samples with ``from_ns`` <= at < ``to_ns``, dtype SAMPLE.

        The sensor's clock starts at the first call's ``from_ns``: samples lie on a grid from there.
        """
        start = self._start_ns = from_ns if self._start_ns is None else self._start_ns
        first = max(0, -((start - from_ns) // self._period_ns))
        last = max(first, -((start - to_ns) // self._period_ns))
        index = np.arange(first, last, dtype=np.int64)
        at = start + index * self._period_ns
        imperfections = self._imperfections(first, last)
        rate, acceleration = self._motion(at, imperfections[:, TREMOR])
        rate += imperfections[:, TREMOR_ACROSS]
        rate += imperfections[:, BIAS]
        rate += imperfections[:, RATE_NOISE]
        samples = np.zeros(len(index), dtype=SAMPLE)
        samples["at"] = samples["host"] = at
        samples["device_ms"] = imperfections[:, SINCE] * 1e3
        samples["rate"] = rate
        samples["acceleration"] = acceleration + imperfections[:, ACCELERATION_NOISE]
        samples["field"] = np.nan
        kept = imperfections[:, LUCK] >= self.profile.lost
        if math.isfinite(self.profile.saturation_rad_s):
            kept &= (np.abs(rate.astype("<f4")) <= self.profile.saturation_rad_s).all(axis=1)
        delivered: Samples = samples[kept]
        return delivered

    def _imperfections(self, first: int, last: int) -> Floats:
        """Return the imperfections of each sample, calculated in blocks that never change."""
        wanted = range(first // BLOCK, -(-last // BLOCK))
        if not wanted:
            return np.empty((0, COLUMNS))
        if wanted[-1] not in self._blocks or wanted[0] not in self._blocks:
            self._blocks = {
                block: self._blocks[block] if block in self._blocks else self._drawn(block)
                for block in wanted
            }
        blocks = [self._blocks[block] for block in wanted]
        offset = wanted.start * BLOCK
        return (blocks[0] if len(blocks) == 1 else np.concatenate(blocks))[
            first - offset : last - offset
        ]

    def _drawn(self, block: int) -> Floats:
        """Return the columns of a block. The tremor's frequency wanders a little, as in reality."""
        profile = self.profile
        generator = np.random.default_rng([self._seed, 1, block])
        noise, luck = generator.standard_normal((BLOCK, 6)), generator.random(BLOCK)
        since_s = np.arange(block * BLOCK, (block + 1) * BLOCK) * (self._period_ns / 1e9)
        phase = (
            2 * math.pi * profile.tremor_hz * since_s
            + 0.5 * np.sin(2 * since_s)
            + self._tremor_phase
        )
        return np.column_stack(
            (
                since_s,
                luck,
                profile.tremor_rad_s * np.sin(phase),
                np.outer(0.5 * profile.tremor_rad_s * np.cos(phase), self._forearm),
                np.asarray(profile.bias_rad_s) + profile.drift_rad_s_per_s * since_s[:, None],
                profile.noise_rad_s * noise[:, 0:3],
                ACCELERATION_NOISE_M_S2 * noise[:, 3:6],
            )
        )

    def _reaches(self, at: npt.NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
        """Return angular rate, angle and angular acceleration about the reaches' axis."""
        rate, angle, acceleration = np.zeros((3, len(at)))
        if not len(at):
            return rate, angle, acceleration
        first_ns, last_ns = int(at[0]), int(at[-1])
        over = bisect_left(self._over_ns, first_ns)
        angle += self._turned[over]
        for onset_ns, form in self._moves[over:]:
            if (last_ns - onset_ns) / 1e9 < form.time_s[0]:
                continue
            if (first_ns - onset_ns) / 1e9 > form.time_s[-1]:
                angle += form.angle[-1]
                continue
            time_s = (at - onset_ns) / 1e9
            angle += np.interp(time_s, form.time_s, form.angle)
            rate += np.interp(time_s, form.time_s, form.rate, left=0.0, right=0.0)
            acceleration += np.interp(time_s, form.time_s, form.acceleration, left=0.0, right=0.0)
        return rate, angle, acceleration

    def _motion(self, at: npt.NDArray[np.int64], tremor: Floats) -> tuple[Floats, Floats]:
        """Return the hand's angular rate, with its tremor (rad/s, shape (n,)), and its
        acceleration, shape (n, 3).
        """
        turning, angle, acceleration = self._reaches(at)
        return (turning + tremor)[:, None] * self._along, self._acceleration(
            turning, angle, acceleration
        )

    def _acceleration(self, turning: Floats, angle: Floats, acceleration: Floats) -> Floats:
        """Return the acceleration at the sensor, shape (n, 3): gravity as the hand turns, and the
        hand's own.
        """
        across = np.cos(angle)[:, None] * self._upright - np.sin(angle)[:, None] * self._sideways
        own = FOREARM_M * (
            acceleration[:, None] * self._way - (turning**2)[:, None] * self._forearm
        )
        felt: Floats = self._parallel + across + own
        return felt


class Simulation(NamedTuple):
    """A recording with its true (onset, end) of each reach, in s."""

    recording: Recording
    truth: tuple[tuple[float, float], ...]


class Scenario(NamedTuple):
    """A named difficulty. ``make`` returns a recording of one reach, between two rests of 2 s, for
    a seed.
    """

    name: str
    make: Callable[[int], Simulation]


class TableRow(NamedTuple):
    """A row of the thesis' Table 4.1: peaks in rad/s. The table's "[ms]" are seconds."""

    type: str
    reach_time_s: float
    peak_extension_rad_s: float
    peak_return_rad_s: float

    @property
    def shape(self) -> ReachShape:
        """A minimum-jerk reach of this row, with durations of its phases such that the hand returns
        to its start.
        """
        share = self.peak_return_rad_s / (self.peak_return_rad_s - self.peak_extension_rad_s)
        return ReachShape(
            out_s=self.reach_time_s * share,
            back_s=self.reach_time_s * (1 - share),
            peak_out=self.peak_extension_rad_s,
            peak_back=self.peak_return_rad_s,
        )


TABLE_4_1 = (
    TableRow("slow near", 1.3385, 0.8622, -1.6876),
    TableRow("slow near", 1.4416, 1.0226, -1.7875),
    TableRow("fast near", 0.8117, 2.4040, -3.4104),
    TableRow("fast near", 0.8239, 2.8159, -3.2666),
    TableRow("slow far", 1.4920, 1.9187, -2.9641),
    TableRow("slow far", 1.5169, 1.9366, -3.0210),
    TableRow("fast far", 1.0922, 3.3147, -4.4224),
    TableRow("fast far", 1.0792, 3.9105, -4.4508),
)
"""The eight reaches of the thesis' system test."""


def _frame(axis: Vector) -> tuple[Floats, Floats, Floats]:
    """Return unit vectors along the axis of the reach, and two across it: the forearm's, and the
    hand's direction.
    """
    length = math.hypot(*axis)
    if length == 0:
        raise ValueError("A reach turns about an axis: it cannot be (0, 0, 0).")
    along = np.asarray(axis, dtype=float) / length
    fingers = np.array([0.0, 1.0, 0.0]) if abs(along[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    forearm = fingers - along * (fingers @ along)
    forearm /= np.linalg.norm(forearm)
    return along, forearm, np.cross(along, forearm)


def simulate(
    shapes: list[ReachShape],
    profile: Profile = PROFILES["clean"],
    *,
    rate_hz: float = 250.0,
    rest_s: float = 2.0,
    seed: int = 0,
) -> Simulation:
    """Return reaches one after the other, with ``rest_s`` of rest before, between and after
    them.
    """
    hand = SimulatedHand(profile, rate_hz, seed)
    onset_s, truth = rest_s, []
    for shape in shapes:
        hand.move(round(onset_s * 1e9), shape)
        truth.append((onset_s, onset_s + shape.duration_s))
        onset_s += shape.duration_s + rest_s
    samples = hand.samples(0, round(onset_s * 1e9))
    share = max(map(abs, profile.axis)) / math.hypot(*profile.axis)
    saturated = any(
        share * max(shape.peak_out, -shape.peak_back) > profile.saturation_rad_s for shape in shapes
    )
    return Simulation(recording(samples, flags=("saturated",) if saturated else ()), tuple(truth))


def table_4_1_recording(
    rate_hz: float = 250.0,
    still_s: float = 2.0,
    profile: Profile = PROFILES["clean"],
    seed: int = 0,
) -> Simulation:
    """Return the eight reaches of Table 4.1 in order, with ``still_s`` of rest before, between and
    after them.
    """
    return simulate(
        [row.shape for row in TABLE_4_1], profile, rate_hz=rate_hz, rest_s=still_s, seed=seed
    )


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


def random_reach(
    generator: np.random.Generator, dwell_s: float = 0.0, twitch: bool = False
) -> ReachShape:
    """Return a minimum-jerk reach between two random rows of Table 4.1, in time and in peaks."""
    one, other = (TABLE_4_1[i] for i in generator.integers(0, len(TABLE_4_1), 2))
    mix = generator.uniform()
    time_s, out, back = (mix * a + (1 - mix) * b for a, b in zip(one[1:], other[1:], strict=True))
    share = back / (back - out)
    return ReachShape(
        out_s=time_s * share,
        back_s=time_s * (1 - share),
        dwell_s=dwell_s,
        peak_out=out,
        peak_back=back,
        twitch=twitch,
        seed=int(generator.integers(1 << 31)),
    )


def slow_reach(generator: np.random.Generator) -> ReachShape:
    """Return a patient's reach: 2 to 6 s, 3 to 7 lognormal submovements, with the angles of Table
    4.1.
    """
    time_s, angle, share = (
        generator.uniform(2, 6),
        generator.uniform(0.4, 1.1),
        generator.uniform(0.4, 0.6),
    )
    out_s, back_s = time_s * share, time_s * (1 - share)
    return ReachShape(
        out_s=out_s,
        back_s=back_s,
        peak_out=2 * angle / out_s,
        peak_back=-2 * angle / back_s,
        submovements=int(generator.integers(3, 8)),
        seed=int(generator.integers(1 << 31)),
    )


def _scenario(
    name: str,
    *,
    noise_deg_s: float | None = None,
    bias_deg_s: float = 0.0,
    tremor_rad_s: float = 0.0,
    twitch: bool = False,
    dwell_s: float = 0.0,
    tilted: bool = False,
    slow: bool = False,
) -> Scenario:
    def make(seed: int) -> Simulation:
        generator = np.random.default_rng([seed, 4])
        shape = slow_reach(generator) if slow else random_reach(generator, dwell_s, twitch)
        x, y, z = math.radians(bias_deg_s) * generator.choice((-1.0, 1.0), 3)
        profile = Profile(
            noise_rad_s=QUIET if noise_deg_s is None else math.radians(noise_deg_s),
            bias_rad_s=(x, y, z),
            tremor_hz=generator.uniform(4, 6),
            tremor_rad_s=tremor_rad_s,
            axis=TILTED if tilted else (0.0, 0.0, 1.0),
        )
        return simulate([shape], profile, seed=seed)

    return Scenario(name, make)


def scenarios() -> tuple[Scenario, ...]:
    """Return all scenarios: noise and bias in deg/s on each axis, tremor in rad/s at 4-6 Hz, pauses
    in s.
    """
    return (
        _scenario("clean"),
        *(_scenario(f"noise {noise} deg/s", noise_deg_s=noise) for noise in (1, 2, 5)),
        *(_scenario(f"bias {bias} deg/s", bias_deg_s=bias) for bias in (2, 6, 12)),
        *(_scenario(f"tremor {tremor} rad/s", tremor_rad_s=tremor) for tremor in (0.1, 0.15, 0.3)),
        _scenario("twitch", twitch=True),
        *(_scenario(f"pause {pause} s", dwell_s=pause) for pause in (0.5, 0.75, 1.2)),
        _scenario("tilted", tilted=True),
        _scenario(
            "all combined",
            noise_deg_s=2,
            bias_deg_s=6,
            tremor_rad_s=0.15,
            twitch=True,
            dwell_s=0.75,
            tilted=True,
        ),
        _scenario("slow, submovements", slow=True),
    )
