"""Marks that a therapist puts on a trial: missed, compensated, assisted. Pure (see `trial_types.Mark`)."""

from collections.abc import Iterable, Mapping

import msgspec
from msgspec.structs import replace

from sar_tui.framework.messages import AttemptStarted, Message, TrialEnded, TrialMarked, Waiting
from sar_tui.framework.trial_types import Mark, Results

_OPEN = ("quiet", "foreperiod", "storage", "response")
"""Waits of a trial in which a mark is put on that trial; at all other times it is put on the last one."""


class TrialMark(msgspec.Struct, frozen=True):
    """The trial that a mark is put on now, and the mark that is on it. Followed by programs that offer marks.

    Attributes:
        trial: attempt and trial that a mark is put on; zeros if there is none.
        marked: attempt and trial of the last mark.
        last: name of the last mark; empty if it was removed.
    """

    trial: tuple[int, int] = (0, 0)
    marked: tuple[int, int] = (0, 0)
    last: str = ""

    @property
    def present(self) -> str:
        """Name of the mark on the trial; empty without one."""
        return self.last if self.marked == self.trial else ""

    def after(self, message: Message) -> "TrialMark":
        """Return the state after a message of the session."""
        match message:
            case Waiting(stage="trial") if message.what in _OPEN:
                return replace(self, trial=(message.attempt, message.trial))
            case TrialEnded():
                return replace(self, trial=(message.attempt, message.trial))
            case AttemptStarted():  # the last attempt's trial cannot be marked any more
                return replace(self, trial=(0, 0))
            case TrialMarked():
                return replace(self, marked=(message.attempt, message.trial), last=message.mark)
        return self


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
