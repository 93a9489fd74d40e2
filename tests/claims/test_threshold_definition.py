"""The fixed-threshold detector keeps to its definition, on movements whose crossings of the
threshold are known.

Their angular rate is a formula, peak · (4u(1 − u))² of the share u of each way's time (minimum
jerk). It crosses a threshold at u = (1 − √(1 − √(threshold / peak))) / 2 and at 1 − u, which no
detector is needed for.
"""

import math

import numpy as np
import pytest

from sar_tui.motion.fixed_threshold import FixedThresholdParameters, find
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import TABLE_4_1, TableRow

RATE_HZ = 250.0
DEFINED = FixedThresholdParameters(threshold_rad_s=0.1, still_ms=800.0)
"""The thesis' numbers (4.2.2)."""
BEGIN_S = 2.0013
"""When a movement begins: between two samples."""
RESTED = round(DEFINED.still_ms / 1000.0 * RATE_HZ)
"""Samples of a rest that ends a reach."""

Way = tuple[float, float, float]
"""Movement one way: when it begins (s), its duration (s), its peak (rad/s, signed)."""


@pytest.mark.parametrize("row", TABLE_4_1)
def test_a_reach_begins_and_ends_with_the_first_sample_after_a_crossing(row: TableRow) -> None:
    shape = row.shape
    out = BEGIN_S, shape.out_s, shape.peak_out
    back = BEGIN_S + shape.out_s, shape.back_s, shape.peak_back
    expected = next_sample_s(crossings(out)[0]), next_sample_s(crossings(back)[1])
    assert found(out, back) == [expected]


@pytest.mark.parametrize(("samples", "reaches"), [(RESTED - 1, 1), (RESTED, 2), (RESTED + 1, 2)])
def test_a_reach_ends_where_the_rate_stays_below_for_long_enough(
    samples: int, reaches: int
) -> None:
    one = BEGIN_S, 0.5, 2.0
    above_s, below_s = (next_sample_s(at_s) for at_s in crossings(one))
    other = BEGIN_S + (below_s - above_s) + samples / RATE_HZ, 0.5, -2.0
    assert len(found(one, other)) == reaches


def crossings(way: Way) -> tuple[float, float]:
    """Return when a movement exceeds the threshold and when it falls below it, in s."""
    begin_s, lasts_s, peak = way
    share = (1.0 - math.sqrt(1.0 - math.sqrt(DEFINED.threshold_rad_s / abs(peak)))) / 2.0
    return begin_s + share * lasts_s, begin_s + (1.0 - share) * lasts_s


def next_sample_s(at_s: float) -> float:
    return round(math.ceil(at_s * RATE_HZ) / RATE_HZ, 6)


def found(*ways: Way) -> list[tuple[float, float]]:
    """Return beginning and end of each reach that the detector finds in some movements."""
    time_s = np.arange(round((ways[-1][0] + ways[-1][1] + 2.0) * RATE_HZ)) / RATE_HZ
    rate = np.zeros((len(time_s), 3))
    for begin_s, lasts_s, peak in ways:
        share = np.clip((time_s - begin_s) / lasts_s, 0.0, 1.0)
        rate[:, 2] += peak * (4.0 * share * (1.0 - share)) ** 2
    reaches = find(Recording(time_s, rate), DEFINED).reaches
    return [(round(bounds.onset_s, 6), round(bounds.end_s, 6)) for bounds in reaches]
