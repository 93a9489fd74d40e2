"""Tracks disk and sensor failures that block the session."""

from sar_tui.model.messages import SensorChanged, StorageChanged
from sar_tui.model.units import SECOND

_LOST = ("detached", "stalled", "ended")
_BACK = ("attached", "flowing")
_RECENT = 5 * SECOND
"""An error at most this long before a sensor stops is taken as the cause."""


class Blockers:
    """State of the disk and of the sensors that the task needs.

    Args:
        sensor_seats: the seats that need a sensor. A sensor is missing until it is attached.
    """

    def __init__(self, sensor_seats: tuple[str, ...]) -> None:
        self._sensor_seats = sensor_seats
        self.has_disk_failed = False
        self._lost = dict.fromkeys(sensor_seats, "")
        self._disk_error = ""
        self._over: set[str] = set()
        self._errors: dict[str, SensorChanged] = {}

    @property
    def is_sensor_lost(self) -> bool:
        """True if a sensor that is needed sends no data."""
        return bool(self._lost)

    @property
    def is_recording_over(self) -> bool:
        """True if a recording that replaces a sensor is at its end: it sends no more data in this
        run.
        """
        return bool(self._over)

    @property
    def lost_seat(self) -> str:
        """The seat whose sensor sends no data; empty if there are several."""
        return next(iter(self._lost)) if len(self._lost) == 1 else ""

    def reset(self) -> None:
        """Forget earlier reports, at the start of a run."""
        self.has_disk_failed = False
        self._lost = dict.fromkeys(self._sensor_seats, "")
        self._over = set()

    def update_storage(self, storage: StorageChanged) -> None:
        """Apply a report about the disk."""
        self.has_disk_failed = not storage.working
        self._disk_error = storage.reason

    def update_sensor(self, sensor: SensorChanged) -> bool:
        """Apply a report about a sensor; False if it does not affect the session, such as a lost
        sample.
        """
        if sensor.seat not in self._sensor_seats:
            return False
        if sensor.state == "ended":
            self._over.add(sensor.seat)
        if sensor.state in _BACK:
            self._over.discard(sensor.seat)
            self._lost.pop(sensor.seat, None)
            return True
        if sensor.state == "error":
            self._errors[sensor.seat] = sensor
        if sensor.state in _LOST or (sensor.state == "error" and sensor.seat in self._lost):
            self._lost[sensor.seat] = sensor.detail or self._reason(sensor)
            return True
        return False

    def _reason(self, lost: SensorChanged) -> str:
        error = self._errors.get(lost.seat)
        return error.detail if error and lost.at - error.at < _RECENT else ""

    def detail(self, reason: str) -> str:
        """Return the message for the experimenter; empty if ``reason`` concerns neither the disk
        nor a sensor.
        """
        if reason in ("storage", "restored"):
            return self._disk_error
        return (
            " ".join(dict.fromkeys(filter(None, self._lost.values()))) if reason == "sensor" else ""
        )
