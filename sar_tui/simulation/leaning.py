"""A simulated person's trunk, which leans forward while the hand reaches and comes back with it."""

import math
from collections.abc import Callable

import msgspec

from sar_tui.model.random_streams import RandomStreams
from sar_tui.motion.shapes import ReachShape
from sar_tui.simulation.participant_model import Person

Move = Callable[[int, ReachShape], None]
"""Makes a simulated body part move, with its onset at a time, ns."""
SPREAD = 0.15
"""Standard deviation of the logarithm of the lean from reach to reach."""
_PEAK = 1.875
"""Peak of a minimum-jerk movement's speed over its mean (Flash & Hogan 1985)."""


def leaning(person: Person, hand: Move | None, trunk: Move | None) -> Move | None:
    """Return a function that moves the hand, and with it the trunk; either may be absent."""
    if trunk is None:
        return hand

    def move(at_ns: int, shape: ReachShape) -> None:
        if hand:
            hand(at_ns, shape)
        trunk(at_ns, lean(person, shape))

    return move


def lean(person: Person, shape: ReachShape) -> ReachShape:
    """Return the movement of a person's trunk in a reach: smooth, as long as the reach, by about
    ``lean_deg``.
    """
    generator = RandomStreams(shape.seed, "trunk").generator("lean", person.name)
    angle = math.radians(person.lean_deg) * math.exp(generator.gauss(0.0, SPREAD))
    return msgspec.structs.replace(
        shape,
        peak_out=_PEAK * angle / shape.out_s,
        peak_back=-_PEAK * angle / shape.back_s,
        submovements=0,
        twitch=False,
    )
