"""The motion sensor on the bus: its samples as a stream of blocks, its statuses as messages."""

from typing import TYPE_CHECKING, Any, ClassVar

import msgspec

from sar_tui.inputs.imu import Info, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import Handle
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import IMU, SENSOR, SESSION_ENDED, TRUNK_IMU, TRUNK_SENSOR
from sar_tui.model.messages import ImuBlock, SensorChanged, SessionEnded
from sar_tui.model.units import MS
from sar_tui.motion.samples import pack

DRAIN = 10 * MS
"""Interval at which new samples are published."""
TRUNK_DRAIN = 50 * MS
"""The same for a sensor on the trunk."""
_BEFORE_SAMPLES = ("attached", "flowing")


class SensorNode(Node):
    """Base of nodes that publish the samples of one participant's sensor, from the beginning of the
    session to its end.

    Args:
        seat: the participant with the sensor.
    """

    name = "imu"
    emits: ClassVar[tuple[Topic[Any], ...]] = (IMU, SENSOR)

    def __init__(self, seat: str = "A") -> None:
        super().__init__()
        self.seat = seat
        self._next: Handle | None = None
        self._stopped = False

    def attach(self, bus: Bus) -> None:
        """Join a bus, and start when the session does."""
        super().attach(bus)
        bus.clock.call_soon(self._begin)

    @on(SESSION_ENDED)
    def session_ended(self, _: SessionEnded) -> None:
        """Stop publishing."""
        self.detach()

    def detach(self) -> None:
        """Stop publishing."""
        self._stopped = True
        if self._next:
            self._next.cancel()

    if TYPE_CHECKING:  # defined by each node

        def _begin(self) -> None:
            """Start publishing, unless it was stopped before."""


class Imu(SensorNode):
    """Publishes a motion sensor's samples and statuses.

    Args:
        feed: the sensor's; one that is running already, after the sensor check, is used as it is.
        seat: the participant with the sensor.

    Attributes:
        samples, statuses: topics on which they are published.
        interval: time between two looks for new samples, in ns.
    """

    samples: ClassVar[Topic[ImuBlock]] = IMU
    statuses: ClassVar[Topic[SensorChanged]] = SENSOR
    interval: ClassVar[int] = DRAIN

    def __init__(self, feed: ImuFeed, seat: str = "A") -> None:
        super().__init__(seat)
        self.feed = feed

    def detach(self) -> None:
        """Stop publishing, and release the sensor."""
        super().detach()
        self.feed.stop()

    def _begin(self) -> None:
        if self._stopped:
            return
        if self.feed.is_running:
            self.feed.drain()
            now = self.bus.clock.now()
            if self.feed.is_attached:
                self._publish(Status(state="attached", at=now))
            else:
                self._publish(Status(state="detached", at=now, detail=self.feed.detail))
            if self.feed.is_stalled:
                self._publish(Status(state="stalled", at=now, detail=self.feed.detail))
        else:
            self.feed.start()
        self._drain()

    def _drain(self) -> None:
        if self._stopped:
            return
        samples, statuses = self.feed.drain()
        before = max(
            (n for n, status in enumerate(statuses, 1) if status.state in _BEFORE_SAMPLES),
            default=0,
        )
        for status in statuses[:before]:
            self._publish(status)
        if len(samples):
            self.emit(self.samples, ImuBlock(seat=self.seat, samples=pack(samples)))
        for status in statuses[before:]:
            self._publish(status)
        self._next = self.bus.clock.call_at(self.bus.clock.now() + self.interval, self._drain)

    def _publish(self, status: Status) -> None:
        self.emit(self.statuses, changed(status, self.feed.info, self.seat))


class TrunkImu(Imu):
    """Publishes the sensor on a participant's trunk, which no session waits for.

    Its samples are not needed before a reach is over, so it looks for them less often.
    """

    name = "trunk_imu"
    emits = (TRUNK_IMU, TRUNK_SENSOR)
    samples = TRUNK_IMU
    statuses = TRUNK_SENSOR
    interval = TRUNK_DRAIN


def changed(status: Status, info: Info | None, seat: str = "A") -> SensorChanged:
    """Return a status as a message, with the sensor's description if it is attached."""
    facts = msgspec.structs.asdict(status)
    if status.state == "attached" and info:
        known = {field.name for field in msgspec.structs.fields(SensorChanged)}
        facts |= {
            name: value for name, value in msgspec.structs.asdict(info).items() if name in known
        }
    return SensorChanged(seat=seat, **facts)
