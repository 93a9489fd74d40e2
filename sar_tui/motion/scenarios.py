"""Simulated reaches under difficulties, one at a time and all together, for tests of detectors."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sar_tui.motion.shapes import ReachShape
from sar_tui.motion.synthesis import TABLE_4_1, TILTED, Profile, Simulation, simulate

QUIET = math.radians(0.2)
"""Noise of a good gyroscope, rad/s; the default of the scenarios."""


class Scenario(NamedTuple):
    """A named difficulty. ``make`` returns a recording of one reach, between two rests of 2 s, for
    a seed.
    """

    name: str
    make: Callable[[int], Simulation]


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
