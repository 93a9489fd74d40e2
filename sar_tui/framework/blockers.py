"""What keeps a session from going on that nobody in it can help: a disk that refuses, a sensor that is loose."""

from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import SensorChanged, StorageChanged

_LOST = ("detached", "stalled", "ended")
_BACK = ("attached", "flowing")
_RECENT = 5 * SECOND
"""An error so short a time before a sensor falls silent is the reason for it."""


class Blockers:
    """Keeps what was told of the disk and of the sensors.

    Args:
        sensors_of: the seats that need a sensor each, which is missing until it is attached.
    """

    def __init__(self, sensors_of: tuple[str, ...]) -> None:
        self._sensors_of = sensors_of
        self.disk_refuses = False
        self._lost = dict.fromkeys(sensors_of, "")
        self._disk_says = ""
        self._errors: dict[str, SensorChanged] = {}

    @property
    def sensor_lost(self) -> bool:
        """Whether nothing comes from a sensor that is needed."""
        return bool(self._lost)

    @property
    def lacking(self) -> str:
        """The seat whose sensor that is; empty where it is so at several."""
        return next(iter(self._lost)) if len(self._lost) == 1 else ""

    def begin_run(self) -> None:
        """A run of the program begins: nothing is known yet."""
        self.disk_refuses = False
        self._lost = dict.fromkeys(self._sensors_of, "")

    def hear_storage(self, storage: StorageChanged) -> None:
        """The disk told something."""
        self.disk_refuses = not storage.working
        self._disk_says = storage.reason

    def hear_sensor(self, sensor: SensorChanged) -> bool:
        """A sensor told something; False if that is nothing to a session: it lost a sample, say."""
        if sensor.seat not in self._sensors_of:
            return False
        if sensor.state in _BACK:
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

    def says(self, reason: str) -> str:
        """The words of what stands in the way, for the experimenter."""
        sensors = " ".join(dict.fromkeys(filter(None, self._lost.values())))
        return {"storage": self._disk_says, "sensor": sensors}.get(reason, "")
