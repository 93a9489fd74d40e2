"""Facts that hold whatever the session waits for: its phase, the disk, sensors, agent, keys."""

from sar_tui.loop.session_phase import (
    ASKABLE,
    ASKABLE_PAUSES,
    IN_TRIAL,
    LEFT,
    PAUSES,
    VISIT_ASKED,
    Phase,
)
from sar_tui.loop.task import Task
from sar_tui.model.messages import KeyPerceived, SensorChanged, StorageChanged
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.keys import GuardedPress, HeldKey, KeyGuard


class Status:
    """Facts about the moment. The node updates them before it resumes the script.

    Attributes:
        phase: what the session waits for.
        paused_from: the phase that the last pause interrupted.
        pause_reason: as it was given for that pause; see `reason`.
        focused: True while the terminal has the focus.
        is_agent_acting: True while the agent speaks or moves.
        awaits_operator: True while a proposal with a deadline is pending.
        asking: names of those who ask to watch, and to whom the participant has not answered.
        are_visits_over: True once the participant declined or ended a visit.
        last_trial: attempt and number of the last trial that was done.
        stored: the same of the last trial that is on disk.
    """

    def __init__(self, task: Task) -> None:
        self.phase = Phase.INSTRUCTIONS
        self.paused_from = Phase.INSTRUCTIONS
        self.pause_reason = ""
        self.focused = True
        self.is_agent_acting = False
        self.awaits_operator = False
        self.asking: list[str] = []
        self.are_visits_over = False
        self.last_trial = (0, 0)
        self.stored = (0, 0)
        self.blockers = Blockers(task.sensor_seats(task.parameters))
        self.keys = Keys(task.start_key, task.parameters.bounce_ms * MS)

    def begin_run(self) -> None:
        """Forget what only the last run of the program knew; all that it recorded is on disk."""
        self.focused = True
        self.is_agent_acting = False
        self.awaits_operator = False
        self.asking = []
        self.are_visits_over = False
        self.stored = self.last_trial
        self.blockers.reset()
        self.keys.begin_run()

    @property
    def place(self) -> Phase:
        """The phase; during a pause the one that was interrupted."""
        return self.paused_from if self.phase is Phase.PAUSED else self.phase

    @property
    def is_attempt_under_way(self) -> bool:
        """True if an attempt has begun and not ended, also while the session is paused."""
        return self.place in IN_TRIAL or self.place is Phase.RESULT

    @property
    def can_skip_attempt(self) -> bool:
        """True if an attempt is under way, or waits to be begun."""
        return self.is_attempt_under_way or self.place is Phase.READY

    @property
    def is_resting(self) -> bool:
        """True in a rest that must be taken, also while the session is paused."""
        return self.place is Phase.REST

    @property
    def is_last_trial_stored(self) -> bool:
        """True if every trial that was done is on disk."""
        return self.stored == self.last_trial

    @property
    def is_paused_by_person(self) -> bool:
        """True in a pause that only a command ends, unless it was made to leave the session."""
        return self.phase is Phase.PAUSED and self.pause_reason not in (*PAUSES, LEFT, VISIT_ASKED)

    @property
    def must_ask(self) -> bool:
        """True if the participant is to be asked now whether somebody may watch: no response is
        awaited, and the agent is still.
        """
        if not self.asking or self.is_agent_acting or self.awaits_operator:
            return False
        if self.phase is Phase.PAUSED:
            return self.reason in ASKABLE_PAUSES
        return self.phase in ASKABLE

    @property
    def reason(self) -> str:
        """Reason of the pause: a disk failure takes precedence over what a person gave."""
        if self.blockers.has_disk_failed and self.phase in (Phase.PAUSED, Phase.CLOSING):
            return "storage"
        return self.pause_reason if self.phase is Phase.PAUSED else ""


class Keys:
    """The keys so far, and whether the last one was pressed for what is on the screen.

    Attributes:
        last: stamp (ns) of the last key or pasted text; None before it.
        is_start: True if the last key was a fresh press of the key that starts a trial.
    """

    def __init__(self, start_key: str, bounce: int = 0) -> None:
        self._start_key = start_key
        self._held_start = HeldKey(bounce)
        self._guard = KeyGuard(bounce)
        self._press: GuardedPress
        self._asked: object = None
        self._key = ""
        self.last: int | None = None
        self.is_start = False

    def begin_run(self) -> None:
        """Forget all: stamps of another run cannot be compared."""
        self.last = None
        self._held_start.release()
        self._guard.reset()
        self._asked = None

    def asked_for(self, what: object, now: int) -> None:
        """Note what the participant is asked for. The same in other words is nothing new."""
        if what != self._asked:
            self._asked = what
            self._guard.appeared(now)

    def press(self, key: KeyPerceived) -> None:
        """Note a key."""
        self.last = key.at
        self.is_start = key.key == self._start_key and self._held_start.press(key.at) != "held"
        self._key = key.key
        self._press = self._guard.press(key.key, key.at)

    def is_meant(self, phase: Phase) -> bool:
        """Return True if the last key was pressed for what ``phase`` shows between trials."""
        press = self._press
        is_new = press.after_quiet if phase is Phase.READY else press.is_new
        return press.counts and (is_new or self._key != "enter")


# --- the disk and the sensors


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
