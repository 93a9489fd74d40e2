"""A reach as a curve for drawing: the angular rate about the reach's own axis, with few points."""

import math
from collections.abc import Mapping

import msgspec
import numpy as np

from sar_tui.motion.arrays import principal_axis
from sar_tui.motion.filters import smooth
from sar_tui.motion.rest import even, find_rest
from sar_tui.motion.samples import Samples, recording

MOST_POINTS = 200
"""Largest number of points of a curve."""
BEFORE_S, AFTER_S = 0.3, 0.5
"""Rest before and after a reach that its curve includes."""

_REST_BEFORE_S, _REST_AFTER_S = 3.0, 1.0
_SMOOTH_HZ = 15.0
_NS = 1e9


class Trace(msgspec.Struct, frozen=True, kw_only=True):
    """One reach for drawing. Times in s since the first point.

    ``rate``: angular rate about the reach's axis, rad/s, without the sensor's bias, positive on the
    way out. ``rate_hz``: points per second. The way out lasts from ``onset_s`` to ``arrival_s``,
    the rest at the target (dwell) until ``departure_s``, the way back until ``end_s``. ``label``:
    its name.
    """

    rate: list[float]
    rate_hz: float
    onset_s: float
    arrival_s: float
    departure_s: float
    end_s: float
    label: str = ""


def trace_of(
    samples: Samples, onset_ns: int, end_ns: int, measured: Mapping[str, object], label: str = ""
) -> Trace | None:
    """Return the curve of a reach; None without samples of it.

    Args:
        samples: dtype SAMPLE; those of the reach, and of the rest before it, which gives the bias.
        onset_ns, end_ns: its beginning and end, from an `analysis.Finding` or a ReachPerceived.
        measured: their details, of which ``out_ms`` and ``back_ms`` are used.
        label: its name.
    """
    since_s = (samples["at"] - onset_ns) / _NS
    end_s = (end_ns - onset_ns) / _NS
    grid = even(
        recording(
            samples[(since_s >= -_REST_BEFORE_S) & (since_s <= end_s + _REST_AFTER_S)], onset_ns
        )
    )
    time = grid.time_s
    inside = (time >= 0) & (time <= end_s)
    if inside.sum() < 2:
        return None
    arrival_s = min(end_s, _seconds(measured["out_ms"]))
    departure_s = max(arrival_s, end_s - _seconds(measured["back_ms"]))
    rate = grid.rate - find_rest(grid.rate, grid.rate_hz, 1.0, tremor=False).bias
    shown = (time >= -BEFORE_S) & (time <= end_s + AFTER_S)
    stride = math.ceil(shown.sum() / MOST_POINTS)
    light = smooth(rate, grid.rate_hz, min(_SMOOTH_HZ, grid.rate_hz / stride / 3))
    turning = light @ principal_axis(light[inside])
    out = (
        turning[inside & (time <= arrival_s)].sum() - turning[inside & (time >= departure_s)].sum()
    )
    points = turning[shown][::stride] * math.copysign(1.0, out)
    first_s = float(time[shown][0])
    return Trace(
        rate=np.round(points, 4).tolist(),
        rate_hz=grid.rate_hz / stride,
        onset_s=-first_s,
        arrival_s=arrival_s - first_s,
        departure_s=departure_s - first_s,
        end_s=end_s - first_s,
        label=label,
    )


def _seconds(milliseconds: object) -> float:
    assert isinstance(milliseconds, int | float)
    return milliseconds / 1000
