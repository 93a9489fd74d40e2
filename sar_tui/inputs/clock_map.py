"""A sensor's clock, mapped to this computer's."""

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
