"""The fixed-threshold detector against its definition, on movements whose crossings of the
threshold are known.

Their angular rate is a formula, peak · (4u(1 − u))² of the share u of each way's time (minimum
jerk). It crosses a threshold at u = (1 − √(1 − √(threshold / peak))) / 2 and at 1 − u, which no
detector is needed for.
"""

import math
from itertools import pairwise

import numpy as np

from sar_tui.motion.fixed_threshold import FixedThresholdParameters, find
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import TABLE_4_1
from sar_tui.validation.report import Claim

RATE_HZ = 250.0
DEFINED = FixedThresholdParameters(threshold_rad_s=0.1, still_ms=800.0)
"""The thesis' numbers (4.2.2)."""
BEGIN_S = 2.0013
"""When a movement begins: between two samples."""

Way = tuple[float, float, float]
"""Movement one way: when it begins (s), its duration (s), its peak (rad/s, signed)."""


def claims() -> list[Claim]:
    """Return the claims that the detector does what its definition says."""
    return [
        Claim(
            "The fixed-threshold detector's reaches begin and end with the first sample after the "
            f"rate crosses {DEFINED.threshold_rad_s:g} rad/s.",
            _against_crossings(),
        ),
        Claim(
            f"It ends a reach where the rate stays below that for {DEFINED.still_ms:g} ms, and "
            "for no less.",
            _against_rests(),
        ),
    ]


def crossings(way: Way) -> tuple[float, float]:
    """Return when a movement exceeds the threshold and when it falls below it, in s."""
    begin_s, lasts_s, peak = way
    share = (1.0 - math.sqrt(1.0 - math.sqrt(DEFINED.threshold_rad_s / abs(peak)))) / 2.0
    return begin_s + share * lasts_s, begin_s + (1.0 - share) * lasts_s


def _against_crossings() -> str:
    wrong = []
    for number, row in enumerate(TABLE_4_1, 1):
        shape = row.shape
        out = BEGIN_S, shape.out_s, shape.peak_out
        back = BEGIN_S + shape.out_s, shape.back_s, shape.peak_back
        expected = [(_next_sample_s(crossings(out)[0]), _next_sample_s(crossings(back)[1]))]
        if (found := _found(out, back)) != expected:
            wrong.append(f"reach {number}: {found} instead of {expected}")
    return ", ".join(wrong)


def _against_rests() -> str:
    wrong = []
    needed = round(DEFINED.still_ms / 1000.0 * RATE_HZ)
    for samples, number in ((needed - 1, 1), (needed, 2), (needed + 1, 2)):
        one = BEGIN_S, 0.5, 2.0
        above_s, below_s = (_next_sample_s(at_s) for at_s in crossings(one))
        other = BEGIN_S + (below_s - above_s) + samples / RATE_HZ, 0.5, -2.0
        if len(found := _found(one, other)) != number:
            wrong.append(f"{len(found)} instead of {number} at {samples * 1000 / RATE_HZ:g} ms")
    return ", ".join(wrong)


def _next_sample_s(at_s: float) -> float:
    return round(math.ceil(at_s * RATE_HZ) / RATE_HZ, 6)


def _found(*ways: Way) -> list[tuple[float, float]]:
    """Return beginning and end of each reach that the detector finds in some movements."""
    assert all(one[0] + one[1] <= other[0] + 1e-9 for one, other in pairwise(ways))
    time_s = np.arange(round((ways[-1][0] + ways[-1][1] + 2.0) * RATE_HZ)) / RATE_HZ
    rate = np.zeros((len(time_s), 3))
    for begin_s, lasts_s, peak in ways:
        share = np.clip((time_s - begin_s) / lasts_s, 0.0, 1.0)
        rate[:, 2] += peak * (4.0 * share * (1.0 - share)) ** 2
    found = find(Recording(time_s, rate), DEFINED).reaches
    return [(round(bounds.onset_s, 6), round(bounds.end_s, 6)) for bounds in found]
