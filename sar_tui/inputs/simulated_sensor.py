"""A simulated sensor on the bus of a session on a virtual clock: all samples until something may
happen as one block.

`sensor.Imu` publishes what has arrived every 10 ms. On a virtual clock nothing else happens between
two callbacks, so this node publishes the samples of many such intervals at once: up to the next
callback, to a gap, or to the samples at which a node that watches the hand would react. All
messages and their times are the same as those of `sensor.Imu`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from sar_tui.inputs.imu import Info, Status
from sar_tui.inputs.imu_feed import GAP_STEPS
from sar_tui.inputs.sensor import DRAIN, SensorNode, changed
from sar_tui.loop.bus import Bus
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import IMU, SENSOR
from sar_tui.model.messages import ImuBlock
from sar_tui.model.units import SECOND
from sar_tui.motion.samples import SAMPLE, Samples, join, pack
from sar_tui.motion.synthesis import ReachShape, SimulatedHand

AHEAD = 5 * SECOND
"""Time for which samples are calculated at once: about a reach, with the rest after it."""
LATE = DRAIN
"""Time from the end of an interval to the publication of its samples, as `sensor.Imu` drains at the
end of the next.
"""


@runtime_checkable
class Foresight(Protocol):
    """A node that receives samples, and can tell beforehand at which it will react."""

    @property
    def seat(self) -> str:
        """The participant whose samples it watches."""
        ...

    def foresee(self, samples: Samples, ends: Sequence[int]) -> int | None:
        """Return the first of ``ends`` at which the node reacts if nothing but samples comes; None
        if at none of them.

        The samples up to there must then come in blocks that end at some of ``ends``.

        Args:
            samples: the samples that come next, dtype SAMPLE.
            ends: numbers of samples, rising: where blocks would end.
        """
        ...


class SimulatedSensor(SensorNode):
    """Publishes the samples and statuses of a simulated hand.

    Args:
        hand: the hand and its sensor. The sensor's range must not be limited.
        seat: the participant with the sensor.
    """

    def __init__(self, hand: SimulatedHand, seat: str = "A") -> None:
        super().__init__(seat)
        self._hand = hand
        self._info = Info(source="simulated", model="Simulated hand", rate_hz=hand.rate_hz)
        self._ahead: Samples = np.empty(0, SAMPLE)
        """Samples that are calculated and not published, up to ``_calculated``."""
        self._calculated = 0
        self._last_ms = math.inf
        self._leaps = False
        self._watcher: Foresight | None = None

    def attach(self, bus: Bus) -> None:
        """Join a bus with a virtual clock, and start when the session does."""
        assert isinstance(bus.clock, VirtualClock)
        self._clock = bus.clock
        super().attach(bus)

    def move(self, at_ns: int, shape: ReachShape) -> None:
        """Make a reach with its onset at ``at_ns``, which is to come."""
        self._hand.move(at_ns, shape)
        now = self._clock.now()
        if self._calculated > now:
            self._ahead = self._ahead[: np.searchsorted(self._ahead["at"], now)]
            self._calculated = now

    def _begin(self) -> None:
        if self._stopped:
            return
        receivers = self.bus.receivers(IMU)
        watchers = [
            node for node in receivers if isinstance(node, Foresight) and node.seat == self.seat
        ]
        self._leaps = len(watchers) < 2 and all(isinstance(node, Foresight) for node in receivers)
        self._watcher = watchers[0] if watchers and self._leaps else None
        self._calculated = now = self._clock.now()
        attached = Status(state="attached", at=now)
        self._next = self._clock.call_at(now + DRAIN, lambda: self._publish(0, [attached]))

    def _publish(self, count: int, statuses: Sequence[Status]) -> None:
        """Publish the next ``count`` samples, then statuses, and schedule those that follow."""
        self._calculate()
        if count:
            if self._watcher:
                # it may have begun to watch since this was scheduled
                self._watcher.foresee(self._ahead, [count])
            block, self._ahead = self._ahead[:count], self._ahead[count:]
            self._last_ms = float(block["device_ms"][-1])
            self.emit(IMU, ImuBlock(seat=self.seat, samples=pack(block)))
        for status in statuses:
            self.emit(SENSOR, changed(status, self._info, self.seat))
        if not self._stopped:
            self._schedule()

    def _schedule(self) -> None:
        """Schedule the next block: as late as nothing happens before."""
        self._calculate()
        due = self._quiet_times()
        ends = np.searchsorted(self._ahead["at"], due - LATE)
        if (
            ends[-1]
            and self._watcher
            and (end := self._watcher.foresee(self._ahead, np.unique(ends[ends > 0]).tolist()))
        ):
            ends = ends[: np.searchsorted(ends, end) + 1]
        gaps = self._gaps(int(ends[-1]))
        if gaps:
            ends = ends[: np.searchsorted(ends, gaps[0].before, "right") + 1]
        count = int(ends[-1])
        statuses = [gap.status for gap in gaps if gap.before < count]
        # without intervals that bring no samples
        last = np.searchsorted(ends, count) if count else len(ends) - 1
        self._next = self._clock.call_at(int(due[last]), lambda: self._publish(count, statuses))

    def _quiet_times(self) -> npt.NDArray[np.int64]:
        """Return the times (ns) at which a block can end: the next, and those before the clock's
        next callback.
        """
        now, until = self._clock.now(), self._clock.next_at()
        last = self._calculated + LATE
        if until is not None:
            last = min(last, until - 1)
        count = max(1, (last - now) // DRAIN) if self._leaps else 1
        return now + DRAIN * np.arange(1, count + 1)

    def _calculate(self) -> None:
        """Calculate samples ahead if there are none, so that all of a reach can be foreseen at
        once.
        """
        if self._calculated <= self._clock.now():
            until = self._clock.now() + AHEAD
            self._ahead = join((self._ahead, self._hand.samples(self._calculated, until)))
            self._calculated = until

    def _gaps(self, count: int) -> list["_Gap"]:
        """Return the gaps between the next ``count`` samples, which ImuFeed would report."""
        interval_ms = 1000 / self._hand.rate_hz
        device_ms = self._ahead["device_ms"][:count]
        steps = np.diff(device_ms, prepend=self._last_ms)
        gaps = []
        for index in np.flatnonzero(steps > GAP_STEPS * interval_ms).tolist():
            step = float(steps[index])
            missing = round(step / interval_ms) - 1
            at = int(self._ahead["at"][index])
            gaps.append(_Gap(index, Status(state="gap", at=at, count=missing, duration_ms=step)))
        return gaps


class _Gap(NamedTuple):
    """Missing samples ``before`` a number of samples, and the status that reports them."""

    before: int
    status: Status
