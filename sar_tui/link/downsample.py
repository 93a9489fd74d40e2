"""Sensor samples downsampled for a plot in the panel. Imports numpy, so it is imported late."""

import math

import numpy as np

from sar_tui.link.peer import MotionTrace
from sar_tui.model.units import SECOND
from sar_tui.motion.samples import Samples, join, unpack

INTERVAL = SECOND // 12
"""Shortest time between two traces of a seat (ns)."""
MAX_POINTS = 50
_POINTS_HZ = 60.0
"""Finer than a panel's plot can show."""


class Downsampler:
    """Traces of one session's motion sensors, by seat."""

    def __init__(self) -> None:
        self._pending: dict[str, list[Samples]] = {}
        self._sent_at: dict[str, int] = {}

    def add(self, seat: str, data: bytes) -> None:
        """Add packed samples. Raises ValueError if they cannot be unpacked."""
        if len(samples := unpack(data)):
            self._pending.setdefault(seat, []).append(samples)

    def due(self, now: int) -> list[MotionTrace]:
        """Return the traces to send at ``now`` (ns)."""
        seats = [
            seat for seat in self._pending if now - self._sent_at.get(seat, -INTERVAL) >= INTERVAL
        ]
        self._sent_at |= dict.fromkeys(seats, now)
        return [_trace(seat, join(self._pending.pop(seat))) for seat in seats]


def _trace(seat: str, samples: Samples) -> MotionTrace:
    """Return the norm of the angular rate, averaged over as many samples as needed to keep to
    ``MAX_POINTS``.
    """
    speeds = np.linalg.norm(samples["rate"].astype(float), axis=1)
    seconds = float(samples["at"][-1] - samples["at"][0]) / SECOND
    rate_hz = (len(samples) - 1) / seconds if seconds > 0 else _POINTS_HZ
    stride = max(math.ceil(len(speeds) / MAX_POINTS), math.ceil(rate_hz / _POINTS_HZ))
    points = [
        float(np.mean(speeds[start : start + stride])) for start in range(0, len(speeds), stride)
    ]
    return MotionTrace(
        seat=seat,
        at=int(samples["at"][-1]),
        hz=round(rate_hz / stride, 3),
        rates=tuple(round(point, 4) for point in points),
    )
