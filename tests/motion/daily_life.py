"""Simulated daily life as a motion sensor on the wrist sees it, for tests of how rarely a detector
finds reaches there.

Nothing has a fixed rhythm: times between events are drawn anew, most from exponential
distributions; frequencies and amplitudes differ from bout to bout and wander within one. The
orientation is simulated, and gyroscope and accelerometer follow from it
(`wrist_motion.WristMotion`).

Where a hand goes out and comes back to where it lay, once, it makes a reach by its shape: to the
mouse and back at once, one single push of a wheel, a hand that scratches and returns to its place.
These are *trips*. They are simulated as often as everything else, and listed, so that they can be
counted apart.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from sar_tui.motion.samples import Recording
from tests.motion.wrist_motion import Angles, Trip, WristMotion

MINUTES = 10.0
RATE_HZ = 100.0
BACK_DEG = 10.0
"""A trip ends at most this far from where it began, in degrees."""
TRIP_S = 15.0
"""The longest trip; a hand that comes back later has been elsewhere."""


class DailyLife(NamedTuple):
    """A recording of daily life, and the trips in it, in order of time."""

    recording: Recording
    trips: tuple[Trip, ...]


class Kind(NamedTuple):
    """A kind of daily life: what the hand does, and the function that adds it to a still wrist."""

    text: str
    add: Callable[[WristMotion], None]


def simulate(
    kind: str, seed: int, *, minutes: float = MINUTES, rate_hz: float = RATE_HZ
) -> DailyLife:
    """Return a stretch of daily life.

    Args:
        kind: a name in ``KINDS``.
        seed: another seed gives other events at other times.
        minutes: its duration.
        rate_hz: samples per second.
    """
    generator = np.random.default_rng([seed, list(KINDS).index(kind), 15])
    motion = WristMotion(minutes * 60.0, rate_hz, generator)
    KINDS[kind].add(motion)
    trips = sorted(trip for trip in motion.trips if trip.to_s < motion.lasts_s)
    return DailyLife(motion.measured(), tuple(trips))


def _sit(motion: WristMotion) -> None:
    """Sit with the hand in the lap.

    Breathing at 12 to 20 a minute (Cretikos et al. 2008, Med J Aust 188:657-659), sway, and
    physiological tremor at 8 to 12 Hz (Elble & Koller 1990, Tremor). Healthy people change their
    posture eight times an hour (Reenalda et al. 2009, J Rehabil Res Dev 46:545-554); here it is
    twice a minute, and a small gesture twelve times.
    """
    _lie(motion)
    _shift_posture(motion, every_s=30.0)
    _make_small_gestures(motion, every_s=5.0)


def _type(motion: WristMotion) -> None:
    """Type, with the hand between keyboard and mouse.

    Wrists turn by 3 to 8 degrees at 20 to 30 degrees a second (Serina, Tal & Rempel 1999,
    Ergonomics 42:938-951), three to six keys a second in bursts, with pauses to think. A hand takes
    0.4 s to the mouse (Card, Moran & Newell 1983, The Psychology of Human-Computer Interaction) and
    turns by 15 to 35 degrees.
    """
    random = motion.generator
    motion.rest((random.normal(20, 8), random.normal(8, 4), random.normal(10, 6)))
    motion.sway((0.4, 0.4, 0.4), 0.05, 0.5)
    for from_s, to_s in _bouts(motion, pause_s=3.0, lasts_s=6.0):
        swing = _about(random, (1.0, 0.8, 0.7), 0.3)
        motion.rhythm(
            from_s, to_s, random.uniform(3, 6), swing, harmonics=(1.0, 0.3), lags=_lags(random),
            frequency_cv=0.2, amplitude_cv=0.6,
        )  # fmt: skip
        # to a key far away, and on from there
        for at_s in _times(motion, every_s=4.0, from_s=from_s, to_s=to_s):
            far = random.uniform(4, 14) * random.choice((-1.0, 1.0))
            takes_s = random.uniform(0.15, 0.35)
            motion.shift(at_s, (far, random.normal(0, 2), random.normal(0, 3)), takes_s)
            motion.shift(
                at_s + takes_s + random.exponential(0.4), (-far, 0.0, 0.0), random.uniform(0.2, 0.5)
            )
    free_s = 0.0
    for at_s in _times(motion, every_s=25.0):
        if at_s < free_s:
            continue
        to_mouse = (-random.uniform(15, 35), random.normal(-2, 3), random.normal(-6, 4))
        stays_s = random.lognormal(math.log(5.0), 0.9)
        free_s = (
            _go_and_return(
                motion, at_s, to_mouse, random.uniform(0.35, 0.8), stays_s, astray_deg=3.0
            )
            + 1.0
        )
        for move_s in _times(motion, every_s=1.2, from_s=at_s + 0.8, to_s=at_s + stays_s):
            motion.shift(
                move_s,
                _direction(random, random.lognormal(math.log(2.0), 0.6)),
                random.uniform(0.2, 0.6),
            )


def _walk(motion: WristMotion) -> None:
    """Walk in bouts, 1.8 steps a second.

    The arm swings once in two steps, by 20 to 45 degrees (Mirelman et al. 2015, Gait Posture
    42:287-290; less on the affected side), and the body bounces with each step. Of all bouts 40 %
    have fewer than 12 steps (Orendurff et al. 2008, J Rehabil Res Dev 45:1077-1090). Between them
    people stand, and turn.
    """
    random = motion.generator
    motion.rest((0.0, random.normal(-72, 6), random.normal(60, 15)))
    motion.sway((0.8, 0.8, 1.0), 0.05, 0.5)
    motion.sway((0.02, 0.02, 0.02), 8.0, 12.0)
    _shift_posture(motion, every_s=25.0)
    for from_s, to_s in _bouts(motion, pause_s=8.0, lasts_s=12.0, least_s=2.2):
        stride_hz = random.normal(0.9, 0.05)
        swing = random.uniform(10, 22)
        motion.rhythm(
            from_s, to_s, stride_hz, (0.25 * swing, swing, 0.35 * swing),
            harmonics=(1.0, 0.2, 0.08), lags=_lags(random), bounce_m=(0.0, 0.015, 0.02),
            bounce_hz=2 * stride_hz,
        )  # fmt: skip
        for at_s in _times(motion, every_s=8.0, from_s=from_s, to_s=to_s):
            motion.shift(
                at_s,
                (random.uniform(30, 180) * random.choice((-1.0, 1.0)), 0.0, 0.0),
                random.uniform(1, 3),
            )


def _tremble(motion: WristMotion) -> None:
    """Sit with a tremor at rest, of 4 to 6 Hz.

    It turns the forearm most (Deuschl, Bain & Brin 1998, Mov Disord 13 S3:2-23), by 0.5 to 10
    degrees, in bouts whose amplitude waxes and wanes.
    """
    random = motion.generator
    _lie(motion)
    _shift_posture(motion, every_s=40.0)
    _make_small_gestures(motion, every_s=12.0)
    for from_s, to_s in _bouts(motion, pause_s=8.0, lasts_s=20.0):
        swing = min(10.0, random.lognormal(math.log(3.0), 0.7))
        motion.rhythm(
            from_s, to_s, random.uniform(4, 6), (0.25 * swing, 0.35 * swing, swing),
            harmonics=(1.0, 0.15), lags=_lags(random), frequency_cv=0.04, amplitude_cv=0.5,
        )  # fmt: skip


def _scratch(motion: WristMotion) -> None:
    """Scratch: bring the hand somewhere, rub at 3 to 5 Hz, and take it away.

    Bouts of people awake last seconds, as those at night do (Ebata et al. 1999, Br J Dermatol
    141:82-86); the frequency is that of finger and wrist movements in such bouts (Moreau et al.
    2018, IEEE J Biomed Health Inform 22:1011-1018). In half of them the hand goes back to its
    place, in the others elsewhere.
    """
    random = motion.generator
    _lie(motion)
    _make_small_gestures(motion, every_s=15.0)
    at_s = random.exponential(10.0)
    while at_s < motion.lasts_s:
        go_s, rubs_s = random.uniform(0.6, 1.4), 1.0 + random.gamma(2.0, 1.5)
        to_place = (random.normal(0, 30), random.uniform(25, 80), random.normal(-20, 35))
        hz, swing = random.uniform(3, 5), _about(random, (3.0, 5.0, 3.0), 0.4)
        motion.rhythm(
            at_s + 0.9 * go_s, at_s + go_s + rubs_s, hz, swing, harmonics=(1.0, 0.25),
            lags=_lags(random), frequency_cv=0.08, amplitude_cv=0.3,
        )  # fmt: skip
        astray_deg = 3.0 if random.random() < 0.5 else 20.0
        over_s = _go_and_return(motion, at_s, to_place, go_s, rubs_s, astray_deg=astray_deg)
        at_s = over_s + 1.0 + random.exponential(15.0)


def _wheel(motion: WristMotion) -> None:
    """Push a wheelchair, coast, and turn it.

    About one push a second, of half its time with the hand on the rim (Boninger et al. 2000, Arch
    Phys Med Rehabil 81:608-613), in bouts of some pushes; between them the hand rests on the rim or
    in the lap. Now and then it is one push only.
    """
    random = motion.generator
    motion.rest((random.normal(0, 5), random.normal(-45, 6), random.normal(50, 10)))
    motion.sway((0.6, 0.6, 0.6), 0.05, 0.5)
    _shift_posture(motion, every_s=15.0)
    at_s = random.exponential(4.0)
    while at_s < motion.lasts_s:
        hz, swing = random.uniform(0.8, 1.1), random.uniform(15, 28)
        pushes = int(random.geometric(0.18))
        if pushes == 1:
            push = (random.normal(0, 6), 2 * swing, random.normal(0, 8))
            over_s = _go_and_return(motion, at_s, push, 0.5 / hz, 0.0, astray_deg=2.0)
        else:
            over_s = at_s + pushes / hz
            motion.rhythm(
                at_s, over_s, hz, (0.3 * swing, swing, 0.5 * swing), harmonics=(1.0, 0.3),
                lags=_lags(random), frequency_cv=0.06, amplitude_cv=0.2,
                bounce_m=(0.01, 0.05, 0.01), bounce_hz=hz,
            )  # fmt: skip
        at_s = over_s + 0.5 + random.exponential(4.0)


KINDS: dict[str, Kind] = {
    "sitting": Kind("breathing, sway, small gestures, changes of posture", _sit),
    "typing": Kind("bursts of keys, far keys, mouse", _type),
    "walking": Kind("bouts of 1.8 steps a second, standing, turning", _walk),
    "tremor": Kind("bouts of 4 to 6 Hz at rest", _tremble),
    "scratching": Kind("rubbing at 3 to 5 Hz at some place", _scratch),
    "wheelchair": Kind("bouts of pushes, coasting", _wheel),
}
"""The kinds of daily life by name."""


def _lie(motion: WristMotion) -> None:
    """Let the hand lie in the lap: breathing, sway, physiological tremor."""
    random = motion.generator
    motion.rest((random.normal(30, 15), random.normal(-10, 8), random.normal(20, 20)))
    motion.rhythm(
        0.0, motion.lasts_s, random.uniform(0.2, 0.33), (0.1, random.uniform(0.3, 1.2), 0.2),
        harmonics=(1.0, 0.3), frequency_cv=0.12, amplitude_cv=0.3,
    )  # fmt: skip
    motion.sway((0.5, 0.4, 0.6), 0.05, 0.5)
    motion.sway((0.02, 0.02, 0.02), 8.0, 12.0)


def _shift_posture(motion: WristMotion, every_s: float) -> None:
    """Change the posture now and then, to one about the first that has nothing to do with the one
    before.
    """
    random = motion.generator
    now = np.zeros(3)
    for at_s in _times(motion, every_s):
        then = random.normal(0.0, (18.0, 10.0, 18.0))
        elbow_m = random.normal(0.0, 0.02, 3)
        motion.shift(at_s, _angles(then - now), random.uniform(0.5, 1.8), elbow_m=_angles(elbow_m))
        now = then


def _make_small_gestures(motion: WristMotion, every_s: float) -> None:
    """Move the hand a little, by 6 degrees in the median; it comes back in part, wholly, or not at
    all.
    """
    random = motion.generator
    left = np.zeros(3)
    for at_s in _times(motion, every_s):
        by = (
            np.array(_direction(random, min(20.0, random.lognormal(math.log(5.0), 0.5))))
            - 0.5 * left
        )
        takes_s = random.uniform(0.2, 0.7)
        back = -by * random.uniform(0.0, 1.0)
        motion.shift(at_s, _angles(by), takes_s)
        motion.shift(
            at_s + takes_s + random.exponential(0.4), _angles(back), random.uniform(0.2, 0.8)
        )
        left += by + back


def _go_and_return(
    motion: WristMotion,
    at_s: float,
    by: Angles,
    takes_s: float,
    stays_s: float,
    *,
    astray_deg: float,
) -> float:
    """Go somewhere, stay, and go back to ``astray_deg`` (standard deviation) from the start; return
    the time then.

    It is a trip if it ends where it began, soon enough.
    """
    random = motion.generator
    astray = random.normal(0.0, astray_deg, 3)
    back_s = takes_s * random.uniform(0.8, 1.3)
    over_s = at_s + takes_s + stays_s + back_s
    motion.shift(at_s, by, takes_s, elbow_m=(0.0, 0.05, 0.1 * by[1] / 90))
    motion.shift(
        at_s + takes_s + stays_s,
        _angles(astray - by),
        back_s,
        elbow_m=(0.0, -0.05, -0.1 * by[1] / 90),
    )
    if np.linalg.norm(astray) <= BACK_DEG and over_s - at_s <= TRIP_S:
        motion.trips.append(Trip(at_s, over_s))
    return over_s


def _bouts(
    motion: WristMotion, pause_s: float, lasts_s: float, least_s: float = 1.0
) -> Iterator[tuple[float, float]]:
    """Yield the start and end of bouts: pauses are exponential about a mean, durations lognormal
    about a median.
    """
    random = motion.generator
    at_s = random.exponential(pause_s)
    while at_s < motion.lasts_s:
        over_s = at_s + max(least_s, random.lognormal(math.log(lasts_s), 0.8))
        yield at_s, min(over_s, motion.lasts_s)
        at_s = over_s + 0.5 + random.exponential(pause_s)


def _times(
    motion: WristMotion, every_s: float, from_s: float = 0.0, to_s: float = math.inf
) -> Iterator[float]:
    """Yield times of events at random, ``every_s`` apart on average."""
    at_s = from_s + motion.generator.exponential(every_s)
    while at_s < min(to_s, motion.lasts_s):
        yield at_s
        at_s += motion.generator.exponential(every_s)


def _direction(random: np.random.Generator, size: float) -> Angles:
    """Return angles of a size in a random direction."""
    towards = random.standard_normal(3)
    return _angles(towards * (size / np.linalg.norm(towards)))


def _about(random: np.random.Generator, angles: Angles, cv: float) -> Angles:
    """Return angles that scatter about some."""
    return _angles(np.abs(np.array(angles) * random.normal(1.0, cv, 3)))


def _lags(random: np.random.Generator) -> Angles:
    """Return delays of the three angles of a rhythm: it turns in an ellipse, not in a line."""
    return _angles(random.uniform(0.0, 0.4, 3))


def _angles(values: np.typing.NDArray[np.floating]) -> Angles:
    x, y, z = values.tolist()
    return x, y, z
