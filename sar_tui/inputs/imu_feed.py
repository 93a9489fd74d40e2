"""Transfers samples from a sensor's thread to the consumer: stamped, checked and counted."""

import struct
from collections import deque
from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np

from sar_tui.inputs.imu import ImuSource, Info, Sample, Status, Vector
from sar_tui.model.messages import BodyPart
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import SAMPLE, Samples, unpack

STALL = 500 * MS
"""An attached sensor without samples for this long is stalled."""
GAP_STEPS = 1.5
"""A step of the sensor's clock of more than this many intervals is a gap."""
RESTART_MS = 1000.0
"""A sensor's clock that goes back by more than this has restarted; by less, the sample is wrong."""
RATE_WINDOW = 2 * SECOND

_TOO_LARGE = 1e30
"""More than any sensor measures, and more than 32 bits hold. NaN is not below it either."""
_TOO_LATE_MS = 1e12

_NOT_RISING = "The sensor's time stamps do not increase; such samples are left out."
_NO_NUMBER = "The sensor reports an angular rate that is not a number; such samples are left out."
_NO_SAMPLE = (
    "The sensor sends something other than three numbers for each of its axes; such "
    "samples are left out."
)
_RESTARTED = "The sensor's clock began anew; the number of missing samples is unknown."
_BEYOND = "Faster or harder than the sensor can measure."

_pack = struct.Struct("<qqd9f").pack
"""One sample of dtype SAMPLE."""
_Row = tuple[int, int, float, Vector, Vector, Vector]


class Drained(NamedTuple):
    """Everything since the last drain: valid samples (dtype SAMPLE) and statuses, each in order."""

    samples: Samples
    statuses: list[Status]


class ImuFeed:
    """Owns a source. The source's thread only appends to a queue; everything else happens in
    ``drain``.

    It adds these statuses: ``gap``, stamped like the first sample after it, or ``saturated`` if the
    sensor reported that it left the samples out for that reason; ``saturated`` for samples at or
    beyond the sensor's range, which are kept, once per drain and stamped like the first; ``error``
    for each run of discarded samples, at its beginning; ``stalled`` and ``flowing``.

    Args:
        source: the source of samples.
        now: returns the present, in ns of the clock of the source's ``host_ns``.
        seat: the participant with the sensor.
        part: where they wear it.

    Attributes:
        is_running: True from start to stop.
        received: number of valid samples.
        lost: number of samples that never arrived.
        dropped: number of samples that arrived and were discarded.
    """

    def __init__(
        self, source: ImuSource, now: Callable[[], int], seat: str = "A", part: BodyPart = "hand"
    ) -> None:
        self.source = source
        self.seat = seat
        self.part: BodyPart = part
        self.is_running = False
        self._now = now
        self._begin()

    def _begin(self) -> None:
        self._queue: deque[Sample | Status] = deque()
        self.received = self.lost = self.dropped = 0
        self._attached = self._has_arrived = self._stalled = False
        self._detail = ""
        self._last_arrival = 0
        self._interval_ms = self._rate_range = self._acceleration_range = inf
        self._counts: deque[tuple[int, int]] = deque()
        self._beyond: list[int] = []
        self._clock = ClockMap()
        self._forget_last_sample()

    def _forget_last_sample(self) -> None:
        self._last_ms = -inf
        self._dropping = ""
        self._dropped_since = 0
        self._saturations: list[Status] = []
        self._clock.restart()

    @property
    def info(self) -> Info | None:
        """Description of the sensor; None until it is attached."""
        return self.source.info

    @property
    def detail(self) -> str:
        """Detail of the last report of an attached or missing sensor, for the experimenter."""
        return self._detail

    @property
    def is_attached(self) -> bool:
        """True if a sensor is attached, as far as has been drained."""
        return self._attached

    @property
    def is_stalled(self) -> bool:
        """True if the sensor is attached but sends nothing."""
        return self._stalled

    @property
    def rate_hz(self) -> float:
        """Valid samples per second over the last two seconds; 0 if not known yet."""
        if len(self._counts) < 2:
            return 0.0
        (first, before), (last, after) = self._counts[0], self._counts[-1]
        return (after - before) * SECOND / (last - first)

    def start(self) -> None:
        """Start the source, with all counts at zero."""
        self._begin()
        self.is_running = True
        self.source.start(self._queue.append, self._queue.append)

    def stop(self) -> None:
        """Stop the source. Samples that have arrived can still be drained."""
        self.is_running = False
        self.source.stop()

    def drain(self) -> Drained:
        """Return everything since the last call, up to a new attachment of the sensor; the rest
        comes next time.

        Call it about every 10 ms, always from the same thread.
        """
        now, queue = self._now(), self._queue
        rows: list[_Row] = []
        statuses: list[Status] = []
        for _ in range(len(queue)):
            if rows and isinstance(queue[0], Status) and queue[0].state == "attached":
                break
            item = queue.popleft()
            if isinstance(item, Sample):
                self._sample(item, rows, statuses)
            else:
                self._status(item, now, statuses)
        if self._beyond:
            statuses.append(
                Status(
                    state="saturated", at=self._beyond[0], detail=_BEYOND, count=len(self._beyond)
                )
            )
            self._beyond.clear()
        self._watch(now, statuses)
        return Drained(_packed(rows), statuses)

    def _sample(self, sample: Sample, rows: list[_Row], statuses: list[Status]) -> None:
        host_ns, device_ms, acceleration, rate, field = sample
        if not (len(acceleration) == len(rate) == len(field) == 3):
            self._drop(_NO_SAMPLE, host_ns, statuses)
            return
        known = abs(device_ms) < _TOO_LATE_MS
        step = device_ms - self._last_ms
        if known and step < -RESTART_MS:
            self._flush(statuses)
            self._forget_last_sample()
            statuses.append(Status(state="gap", at=host_ns, detail=_RESTARTED))
            step = inf
        if not (known and step > 0):
            self._drop(_NOT_RISING, host_ns, statuses)
            return
        if not abs(rate[0]) + abs(rate[1]) + abs(rate[2]) < _TOO_LARGE:
            self._drop(_NO_NUMBER, host_ns, statuses)
            self._dropped_since += 1
            return
        at = self._clock.at(device_ms, host_ns)
        if self._saturations or GAP_STEPS * self._interval_ms < step < inf:
            self._hole(at, step, statuses)
        if _reaches(rate, self._rate_range) or _reaches(acceleration, self._acceleration_range):
            self._beyond.append(at)
        self._last_ms, self._dropping, self._dropped_since = device_ms, "", 0
        self._has_arrived = True
        self.received += 1
        rows.append((at, host_ns, device_ms, acceleration, rate, field))

    def _drop(self, why: str, host_ns: int, statuses: list[Status]) -> None:
        self.dropped += 1
        if self._dropping != why:
            self._dropping = why
            statuses.append(Status(state="error", at=host_ns, detail=why))

    def _hole(self, at: int, step: float, statuses: list[Status]) -> None:
        """Report samples that are missing before ``at``, or the saturation that the sensor gave as
        the reason.
        """
        missing = (
            round(step / self._interval_ms) - 1 if GAP_STEPS * self._interval_ms < step < inf else 0
        )
        self.lost += max(0, missing - self._dropped_since)
        if self._saturations:
            self._flush(statuses, at, missing, step)
        else:
            statuses.append(Status(state="gap", at=at, count=missing, duration_ms=step))

    def _flush(
        self, statuses: list[Status], at: int | None = None, missing: int = 0, step: float = 0.0
    ) -> None:
        """Report the saturations since the last sample as one status."""
        if self._saturations:
            first = self._saturations[0]
            count = missing or sum(saturation.count for saturation in self._saturations)
            duration_ms = step if missing else 0.0
            statuses.append(
                Status(
                    state="saturated",
                    at=at or first.at,
                    detail=first.detail,
                    count=count,
                    duration_ms=duration_ms,
                )
            )
            self._saturations.clear()

    def _status(self, status: Status, now: int, statuses: list[Status]) -> None:
        if status.state == "saturated":
            self._saturations.append(status)
            self._has_arrived = True
            return
        if status.state in ("attached", "detached", "ended"):
            self._flush(statuses)
            self._forget_last_sample()
            self._attached, self._stalled = status.state == "attached", False
        if status.state == "attached":
            self._last_arrival = now
            self._counts.clear()
            info = self.source.info
            self._interval_ms = 1000 / info.rate_hz if info and info.rate_hz > 0 else inf
            self._rate_range = (info.rate_range_rad_s if info else 0) or inf
            self._acceleration_range = (info.acceleration_range_m_s2 if info else 0) or inf
        if status.state in ("attached", "detached", "error", "ended"):
            self._detail = status.detail
        statuses.append(status)

    def _watch(self, now: int, statuses: list[Status]) -> None:
        """Report a sensor that falls silent, and count samples."""
        if self._has_arrived:
            self._last_arrival = now
            if self._stalled:
                statuses.insert(0, Status(state="flowing", at=now))
            self._has_arrived = self._stalled = False
        elif self._attached and not self._stalled and now - self._last_arrival >= STALL:
            self._stalled = True
            statuses.append(
                Status(state="stalled", at=now, duration_ms=(now - self._last_arrival) / MS)
            )
        if self._counts and self._counts[-1][0] >= now:
            self._counts.pop()
        self._counts.append((now, self.received))
        while now - self._counts[0][0] > RATE_WINDOW:
            self._counts.popleft()


def _packed(rows: list[_Row]) -> Samples:
    """Return rows as samples. `struct` packs a few of them much faster than numpy."""
    try:
        return unpack(b"".join([_pack(*row[:3], *row[3], *row[4], *row[5]) for row in rows]))
    except (OverflowError, struct.error):  # beyond the range of 32 bits
        with np.errstate(over="ignore"):
            return np.array(rows, dtype=SAMPLE)


def _reaches(vector: Vector, limit: float) -> bool:
    x, y, z = vector
    return abs(x) >= limit or abs(y) >= limit or abs(z) >= limit


DRIFT_PPM = 100
"""Largest drift, in parts per million, that is followed smoothly; a quartz keeps within 50."""
WINDOW_NS = 2_000_000_000
"""Interval at which the map catches up with a faster drift."""


class ClockMap:
    """Maps a sensor's clock to the host's: the sensor's time plus the smallest delay seen.

    A sample may arrive late, because of the bus and the scheduler, but never early. So the smallest
    (host - device) is the best estimate of the offset between the clocks, and removes the jitter of
    single samples. The minimum leaks upwards by ``DRIFT_PPM`` to follow clocks that drift apart; a
    faster drift is corrected every two seconds. The shortest transmission time cannot be observed
    and remains included.
    """

    def __init__(self) -> None:
        self._offset: int | None = None
        self._device = 0
        self._last: int | None = None
        self._window = 0
        self._excess = 0

    def restart(self) -> None:
        """Restart after the sensor's clock restarted. Later results still follow earlier ones."""
        self._offset = None

    def at(self, device_ms: float, host_ns: int) -> int:
        """Return when a sample was measured, in ns of the host's clock; strictly increasing from
        call to call.

        When the minimum falls, at the start or after a delay, the results are at least half as far
        apart as the samples are on the sensor's clock.

        Args:
            device_ms: the sensor's clock. If it goes back, it restarted.
            host_ns: when the sample arrived.
        """
        device = round(device_ms * 1e6)
        step = device - self._device
        if self._offset is None or step < 0:
            self._offset, step = host_ns - device, 0
            self._window, self._excess = device, WINDOW_NS
        else:
            self._offset = min(self._offset + step * DRIFT_PPM // 1_000_000, host_ns - device)
        self._excess = min(self._excess, host_ns - device - self._offset)
        if device - self._window >= WINDOW_NS:
            self._offset += self._excess
            self._window, self._excess = device, WINDOW_NS
        self._device = device
        at = device + self._offset
        if self._last is not None:
            at = max(at, self._last + max(step // 2, 1))
        self._last = at
        return at
