"""A reach as a curve: how fast the hand turned about the reach's own axis, small enough to be drawn."""

import math
from collections.abc import Mapping

import msgspec
import numpy as np

from sar_tui.motion.filters import smooth
from sar_tui.motion.grid import even
from sar_tui.motion.phases import principal_axis
from sar_tui.motion.rest import find_rest
from sar_tui.motion.samples import Samples, recording

MOST_POINTS = 200
"""A curve has no more points than this."""
BEFORE_S, AFTER_S = 0.3, 0.5
"""How much of the rest before and after a reach is part of its curve."""

_REST_BEFORE_S, _REST_AFTER_S = 3.0, 1.0
_SMOOTH_HZ = 15.0
_NS = 1e9


class Trace(msgspec.Struct, frozen=True, kw_only=True):
    """One reach, to be drawn. Times in s since the first point.

    ``rate``: angular rate about the reach's axis, rad/s, without the sensor's bias, positive on the way out.
    ``rate_hz``: points a second. The way out lasts from ``onset_s`` to ``arrival_s``, the rest at the target (dwell)
    until ``departure_s``, the way back until ``end_s``. ``label``: what to call it.
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
    """The curve of a reach that was found; None where there are no samples of it.

    Args:
        samples: dtype SAMPLE; those of the reach, and the rest before it, from which the bias is taken.
        onset_ns, end_ns: when it began and ended, as an `analysis.Finding` or a ReachPerceived tells.
        measured: their details, of which ``out_ms`` and ``back_ms`` are used.
        label: what to call it.
    """
    since_s = (samples["at"] - onset_ns) / _NS
    end_s = (end_ns - onset_ns) / _NS
    grid = even(recording(samples[(since_s >= -_REST_BEFORE_S) & (since_s <= end_s + _REST_AFTER_S)], onset_ns))
    time = grid.time_s
    inside = (time >= 0) & (time <= end_s)
    if inside.sum() < 2:
        return None
    arrival_s = min(end_s, _seconds(measured["out_ms"]))
    departure_s = max(arrival_s, end_s - _seconds(measured["back_ms"]))
    rate = grid.rate - find_rest(grid.rate, grid.rate_hz, 1.0).bias
    shown = (time >= -BEFORE_S) & (time <= end_s + AFTER_S)
    stride = math.ceil(shown.sum() / MOST_POINTS)
    light = smooth(rate, grid.rate_hz, min(_SMOOTH_HZ, grid.rate_hz / stride / 3))
    turning = light @ principal_axis(light[inside])
    out = turning[inside & (time <= arrival_s)].sum() - turning[inside & (time >= departure_s)].sum()
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
