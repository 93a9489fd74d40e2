"""A sensor's clock, mapped to this computer's."""

DRIFT_PPM = 100
"""How much faster than the sensor's clock the computer's may run and be followed evenly; a quartz keeps within 50."""
WINDOW_NS = 2_000_000_000
"""Where it runs faster still, the map catches up so often."""


class ClockMap:
    """Tells when, on this computer's clock, a sensor measured: its own clock plus the least delay seen.

    A sample comes late by what the bus and the scheduler make of it, never early. So the smallest of
    (host - device) is the best guess of how the two clocks lie to each other, and the jitter of single samples goes.
    The minimum leaks upwards by ``DRIFT_PPM``, so that it follows clocks that drift apart; what is left of a faster
    drift is made up for every two seconds. What cannot be seen from
    here stays in: the shortest time that a sample is ever under way.
    """

    def __init__(self) -> None:
        self._offset: int | None = None
        self._device = 0
        self._last: int | None = None
        self._window = 0
        self._excess = 0

    def restart(self) -> None:
        """The sensor's clock begins anew. What is mapped from here on still comes after what was mapped before."""
        self._offset = None

    def at(self, device_ms: float, host_ns: int) -> int:
        """When a sample was measured, in ns of the host's clock; strictly rising from call to call.

        Where the minimum falls, at the start or after a delay, the stamps close up at half the sensor's pace: no two
        samples lie closer together than half of what they did on the sensor's clock.

        Args:
            device_ms: the sensor's clock. If it goes back, it is a clock that begins anew.
            host_ns: when the sample came in.
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
