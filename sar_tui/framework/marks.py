"""Marks that a therapist puts on a trial: missed, compensated, assisted. Pure (see `trial_types.Mark`)."""

from collections.abc import Iterable, Mapping

import msgspec

from sar_tui.framework.messages import TrialMarked
from sar_tui.framework.trial_types import Mark, Results


class MarkedResults(msgspec.Struct, frozen=True):
    """The results of the last trial as they were measured, and the mark that is on it."""

    measured: Results
    mark: Mark | None = None

    @property
    def results(self) -> Results:
        """The results with the mark applied."""
        if self.mark is None:
            return self.measured
        return {seat: self.mark.applied(result) for seat, result in self.measured.items()}

    def toggled(self, mark: Mark) -> "MarkedResults":
        """Return the results with ``mark`` instead of the present one, or without it if that is the present one."""
        return MarkedResults(self.measured, toggled(self.mark, mark))


def find(marks: Iterable[Mark], name: str) -> Mark | None:
    """Return the mark with that name; None if the task has no such mark."""
    return next((mark for mark in marks if mark.name == name), None)


def toggled(present: Mark | None, mark: Mark) -> Mark | None:
    """Return the mark of a trial after ``mark`` was chosen: choosing the present one again removes it."""
    return None if present == mark else mark


def messages(attempt: int, trial: int, mark: Mark | None, correct: Mapping[str, bool]) -> list[TrialMarked]:
    """Return a message per seat that reports the trial's mark, and whether its result is correct with it."""
    name = mark.name if mark else ""
    return [
        TrialMarked(seat=seat, attempt=attempt, trial=trial, mark=name, correct=is_correct)
        for seat, is_correct in correct.items()
    ]
