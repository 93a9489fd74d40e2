"""Reaches that do not overlap: no part of a recording belongs to two of them."""

import math
from collections.abc import Iterable

import msgspec

from sar_tui.motion.reach_bounds import Bounds

MEET_S = 0.1
"""Two reaches without a rest between them overlap by less than this, as either's boundary is an
estimate.
"""


def apart(reaches: Iterable[Bounds], since_s: float = -math.inf) -> tuple[Bounds, ...]:
    """Return reaches in order of time, such that each begins at the end of the one before, or
    later.

    One that begins a little too early begins at that end instead. One that begins much earlier is
    the same movement found again, and is left out.

    Args:
        reaches: in any order.
        since_s: end of the last reach before them, in s.
    """
    kept: list[Bounds] = []
    for bounds in sorted(reaches, key=lambda bounds: bounds.onset_s):
        if bounds.onset_s < since_s - MEET_S or bounds.arrival_s <= since_s:
            continue
        kept.append(msgspec.structs.replace(bounds, onset_s=max(bounds.onset_s, since_s)))
        since_s = max(since_s, bounds.end_s)
    return tuple(kept)
