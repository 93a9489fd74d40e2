"""Turns of a hand beside the beats of a metronome, and the swings of simulated people."""

import math
from collections.abc import Sequence
from statistics import fmean, stdev
from typing import NamedTuple

from sar_tui.api.task import Act, RandomStreams

LISTENED = 3
"""Beats at the beginning that are heard only. The next is where the hand sets off, and is not
counted either.
"""
NEAR = 0.4
"""A turn belongs to a beat if it is nearer than this share of the interval."""
AHEAD_MS, NOISE_MS, NOISE_SHARE = 45.0, 18.0, 0.035
"""Simulated people turn so long before the beat, and vary by so much at any tempo and by a share of
the interval.
"""
_SWING_RAD = 0.6


class InTime(NamedTuple):
    """A row of beats.

    Attributes:
        asynchrony_ms: mean time from a beat to its turn; negative: ahead of it; None without any.
        variation_ms: standard deviation of these times; None for fewer than three.
        followed: share of beats that have exactly one turn.
    """

    asynchrony_ms: float | None
    variation_ms: float | None
    followed: float


def in_time(beats: Sequence[int], turns: Sequence[int], beat_ms: float) -> InTime:
    """Return how turns go with beats, both in ns. The first beat sets the hand in motion, and the
    last ends it.
    """
    found: list[float] = []
    counted = beats[1:-1]
    for beat in counted:
        near = [turn for turn in turns if abs(turn - beat) / 1e6 < NEAR * beat_ms]
        if len(near) == 1:
            found.append((near[0] - beat) / 1e6)
    return InTime(
        asynchrony_ms=fmean(found) if found else None,
        variation_ms=stdev(found) if len(found) > 2 else None,
        followed=len(found) / len(counted) if counted else 0.0,
    )


def swings(
    beat_ms: float,
    beats: int,
    unsteadiness: float,
    streams: RandomStreams,
    ahead_ms: float = AHEAD_MS,
) -> list[Act]:
    """Return the swings of a simulated person, each pair as a movement out and back, from the first
    counted beat on.
    """
    from sar_tui.api.task import ReachShape

    spread = math.hypot(NOISE_MS, NOISE_SHARE * beat_ms) * (1 + unsteadiness)
    noise = streams.generator("beats")
    turns = [
        beat * beat_ms - ahead_ms + noise.gauss(0.0, spread) for beat in range(LISTENED, beats)
    ]
    acts: list[Act] = []
    for begin, turn, end in zip(turns[:-2:2], turns[1:-1:2], turns[2::2], strict=False):
        out, back = (turn - begin) / 1000, (end - turn) / 1000
        peaks = 1.875 * _SWING_RAD
        acts.append(
            (
                begin,
                ReachShape(out_s=out, back_s=back, peak_out=peaks / out, peak_back=-peaks / back),
            )
        )
    return acts
