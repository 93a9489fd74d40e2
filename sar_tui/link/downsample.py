"""How a hand moves, for an eye to follow: a sensor's samples thinned out. Loads numpy, and so is loaded late."""

import math

import numpy as np

from sar_tui.framework.clock import SECOND
from sar_tui.link.peer import MotionTrace
from sar_tui.motion.samples import Samples, unpack

EVERY = SECOND // 12
"""A trace is sent no more often than this (ns)."""
MOST_POINTS = 50
_POINTS_HZ = 60.0
"""An eye sees no more than this; a panel's plot shows less."""


class Downsampler:
    """The traces of one session's sensors, by seat."""

    def __init__(self) -> None:
        self._waiting: dict[str, list[Samples]] = {}
        self._sent: dict[str, int] = {}

    def hear(self, seat: str, data: bytes) -> None:
        """Take samples on. Raises ValueError where these are none."""
        if len(samples := unpack(data)):
            self._waiting.setdefault(seat, []).append(samples)

    def due(self, now: int) -> list[MotionTrace]:
        """What may be sent by ``now`` (ns)."""
        seats = [seat for seat in self._waiting if now - self._sent.get(seat, -EVERY) >= EVERY]
        self._sent |= dict.fromkeys(seats, now)
        return [_trace(seat, np.concatenate(self._waiting.pop(seat))) for seat in seats]


def _trace(seat: str, samples: Samples) -> MotionTrace:
    """The norm of the angular rate, in means of as many samples as leave few enough points."""
    speeds = np.linalg.norm(samples["rate"].astype(float), axis=1)
    seconds = float(samples["at"][-1] - samples["at"][0]) / SECOND
    rate_hz = (len(samples) - 1) / seconds if seconds > 0 else _POINTS_HZ
    stride = max(math.ceil(len(speeds) / MOST_POINTS), math.ceil(rate_hz / _POINTS_HZ))
    points = [float(np.mean(speeds[start : start + stride])) for start in range(0, len(speeds), stride)]
    return MotionTrace(
        seat=seat,
        at=int(samples["at"][-1]),
        hz=round(rate_hz / stride, 3),
        rates=tuple(round(point, 4) for point in points),
    )
