"""The simulated hand as a sensor."""

import math
import threading
from collections import deque
from collections.abc import Callable

from sar_tui.inputs.imu import Info, Sample, Status
from sar_tui.inputs.recorded import Pace, as_sent
from sar_tui.loop.clock import Clock
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.synthesis import ReachShape, SimulatedHand

STEP = 10 * MS
"""Interval at which samples are delivered."""
AHEAD = 2 * SECOND
"""Time for which samples are calculated at once."""
_SATURATION = "The simulated gyroscope was turned faster than it can measure."


class SimulatedSource:
    """A simulated hand with a sensor, whose samples are delivered every 10 ms.

    On a virtual clock the same movements give the same samples each time. A sensor that leaves out
    samples beyond its range, and loses no others, reports them as a Phidget does.

    Args:
        hand: the hand and its sensor.
        clock: the hand's clock; the host's, with its own thread, if None.
        model: the sensor's description.
    """

    def __init__(
        self, hand: SimulatedHand, clock: Clock | None = None, model: str = "Simulated hand"
    ) -> None:
        self.hand = hand
        self._model = model
        self.info: Info | None = None
        self._pace = Pace(self._measure, clock)
        self._ahead: deque[Sample] = deque()
        self._until = self._calculated = 0
        self._moving = threading.Lock()

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Begin to deliver samples."""
        self._pace.stop()
        self._sink, self._on_status = sink, on_status
        self.info = None
        self._pace.start()

    def stop(self) -> None:
        """Stop delivering samples."""
        self._pace.stop()

    def zero(self) -> None:
        """Do nothing: a simulated sensor keeps its bias."""

    def move(self, at_ns: int, shape: ReachShape) -> None:
        """Make a reach with its onset at ``at_ns`` of the hand's clock. May be called from any
        thread.
        """
        with self._moving:
            self.hand.move(at_ns, shape)
            self._forget_ahead()

    def _measure(self, now: int) -> int:
        profile, rate_hz = self.hand.profile, self.hand.rate_hz
        saturates = math.isfinite(profile.saturation_rad_s)
        if self.info is None:
            self.info = Info(
                source="simulated",
                model=self._model,
                rate_hz=rate_hz,
                rate_range_rad_s=profile.saturation_rad_s if saturates else 0.0,
            )
            with self._moving:
                self._until = now
                self._forget_ahead()
            self._last_ms = math.inf
            self._on_status(Status(state="attached", at=now))
        for sample in self._samples(now):
            if saturates and not profile.lost and sample.device_ms - self._last_ms > 1500 / rate_hz:
                self._on_status(
                    Status(state="saturated", at=sample.host_ns, count=1, detail=_SATURATION)
                )
            self._last_ms = sample.device_ms
            self._sink(sample)
        return now + STEP

    def _samples(self, now: int) -> list[Sample]:
        """Return the samples since the last call, as they are at ``now``."""
        with self._moving:
            if now > self._calculated:
                until = max(now, self._until + AHEAD)
                self._ahead.extend(as_sent(self.hand.samples(self._calculated, until)))
                self._calculated = until
            self._until = now
            found = []
            while self._ahead and self._ahead[0].host_ns < now:
                found.append(self._ahead.popleft())
            return found

    def _forget_ahead(self) -> None:
        """Forget samples that are calculated but not measured yet: the hand is about to move."""
        self._ahead.clear()
        self._calculated = self._until
