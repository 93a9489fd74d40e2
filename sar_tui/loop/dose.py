"""Counts what a participant has done, against the limits of a session and a day."""

from sar_tui.loop.task import Task
from sar_tui.model.units import SECOND
from sar_tui.rules.limits import Dose, is_rest_due, is_session_over, reached_of_day

_MINUTE = 60 * SECOND


class DoseCount:
    """Time and amount of practice, over all runs of a session. Times are in ns."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self._today = Dose()
        self._earlier_runs = 0
        self._run_began_at = 0
        self._attempt_began_at = 0
        self._attempt_ended_at = 0
        self._rested_at = 0
        self._attempts_since_rest = 0

    def begin_run(self, done_today: Dose, now: int) -> None:
        """Begin to count a run: the clock of the last one says nothing about the time between."""
        self._earlier_runs += max(self._attempt_ended_at - self._run_began_at, 0)
        self._run_began_at = self._attempt_began_at = self._attempt_ended_at = now
        self._rested_at = now
        self._today = done_today

    def begin_attempt(self, now: int) -> None:
        """Note that an attempt begins."""
        self._attempt_began_at = now

    def end_attempt(self, level: int, now: int, *, is_practice: bool) -> None:
        """Add the attempt that ends."""
        self._today = self._today.plus(
            minutes=(now - self._attempt_began_at) / _MINUTE,
            repetitions=self._task.trials_at(level),
            is_practice=is_practice,
        )
        self._attempt_ended_at = now
        self._attempts_since_rest += 1

    def limit_text(self, now: int) -> str:
        """Return a text for the participant if a limit is reached; empty for none."""
        if reached_of_day(self._task.parameters, self._today):
            return self._task.tr("That is enough for today. Well done.")
        minutes = (self._earlier_runs + now - self._run_began_at) / _MINUTE
        if is_session_over(self._task.parameters, minutes):
            return self._task.tr("The time for this session is over. Well done.")
        return ""

    def is_rest_due(self, now: int) -> bool:
        """Return True if a rest must be taken before the next attempt."""
        minutes = (now - self._rested_at) / _MINUTE
        return is_rest_due(self._task.parameters, self._attempts_since_rest, minutes)

    def begin_rest(self) -> None:
        """Begin to count the attempts until the next rest."""
        self._attempts_since_rest = 0

    def end_rest(self, now: int) -> None:
        """Begin to count the time until the next rest."""
        self._rested_at = now
