"""Phases of movement about an axis, and the pairs of them that make a reach."""

import math
from typing import NamedTuple

import numpy as np

from sar_tui.motion.changes import changes
from sar_tui.motion.samples import Floats

ADJACENT_S = 0.2
"""Longest pause after which a small movement still belongs to its neighbour."""
TINY_RAD = 0.02
"""Smaller movements are ignored."""
UNEVEN = 4.0
"""Largest ratio of the angles out and back in a reach."""
UNPAIRED = 10.0
"""Cost of a phase without a partner: more than that of any possible pair."""


class Phase(NamedTuple):
    """Movement in one direction, from sample ``first`` to before ``last``; ``angle`` in rad,
    signed.
    """

    first: int
    last: int
    angle: float


def principal_axis(rate: Floats) -> Floats:
    """Return the main axis of rotation, a unit vector of shape (3,); ``rate`` without bias, shape
    (n, 3).
    """
    axis: Floats = np.linalg.eigh(rate.T @ rate)[1][:, -1]
    return axis


def phases(
    turning: Floats,
    rate_hz: float,
    *,
    begin: float,
    end: float,
    least_rad: float,
    shortest_s: float,
    pause_s: float,
) -> list[Phase]:
    """Return the phases in a smooth angular rate about one axis.

    Args:
        turning: shape (n,), rad/s.
        rate_hz: samples per second.
        begin: a movement exceeds this, rad/s.
        end: it lasts while it is above this, rad/s.
        least_rad: smallest angle of a phase.
        shortest_s: shortest duration of a phase.
        pause_s: movements in the same direction with a shorter pause between them are one phase;
            one of less than ``least_rad`` belongs to a neighbour only within ``ADJACENT_S``.
    """
    found: list[Phase] = []
    for lobe in _lobes(turning, rate_hz, begin, end):
        before = found[-1] if found else None
        if before and before.angle * lobe.angle > 0:
            large = min(abs(before.angle), abs(lobe.angle)) >= least_rad
            if lobe.first - before.last < (pause_s if large else ADJACENT_S) * rate_hz:
                found[-1] = Phase(before.first, lobe.last, before.angle + lobe.angle)
                continue
        found.append(lobe)
    shortest = shortest_s * rate_hz
    return [
        phase
        for phase in found
        if abs(phase.angle) >= least_rad and phase.last - phase.first >= shortest
    ]


def _lobes(turning: Floats, rate_hz: float, begin: float, end: float) -> list[Phase]:
    """Return stretches of movement in one direction, except the smallest."""
    side = np.where(np.abs(turning) > end, np.sign(turning), 0.0)
    edges = changes(side)
    found = []
    for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        lobe = turning[first:last]
        angle = float(lobe.sum()) / rate_hz
        if abs(angle) > TINY_RAD and np.abs(lobe).max() > begin:
            found.append(Phase(first, last, angle))
    return found


def pairs(found: list[Phase], rate_hz: float, dwell_s: float) -> list[tuple[Phase, Phase]]:
    """Return the pairs of phases that are a reach: opposite, of similar angle, with a short rest
    between them.

    The pairing has as many reaches as possible and, among those, the best fit (dynamic programming
    over the phases).

    Args:
        found: in order of time.
        rate_hz: samples per second.
        dwell_s: the longest rest at the target.
    """
    best: list[tuple[float, list[tuple[Phase, Phase]]]] = [(0.0, [])]
    for index, phase in enumerate(found):
        alone = (best[-1][0] + UNPAIRED, best[-1][1])
        misfit = _misfit(found[index - 1], phase, rate_hz, dwell_s) if index else math.inf
        together = (
            (best[-2][0] + misfit, [*best[-2][1], (found[index - 1], phase)]) if index else alone
        )
        best.append(min(alone, together, key=lambda option: option[0]))
    return best[-1][1]


def _misfit(out: Phase, back: Phase, rate_hz: float, dwell_s: float) -> float:
    """Return how badly two phases fit as a reach; infinite if they cannot be one."""
    rest_s = (back.first - out.last) / rate_hz
    uneven = abs(math.log(abs(out.angle / back.angle)))
    possible = out.angle * back.angle < 0 and rest_s <= dwell_s and uneven < math.log(UNEVEN)
    return uneven + rest_s if possible else math.inf
