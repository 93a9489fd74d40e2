"""Marks that a therapist puts on a trial: missed, compensated, assisted. Pure (see
`trial_types.Mark`).
"""

from collections.abc import Iterable, Mapping

import msgspec
from msgspec.structs import replace

from sar_tui.model.messages import (
    AttemptStarted,
    Message,
    PromptVoided,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.model.trial_types import UNSURE, Mark, Results

_OPEN = ("quiet", "foreperiod", "storage", "response")
"""Waits of a trial in which a mark is put on that trial; at all other times it is put on the last
one.
"""
_NONE = (0, 0)


class TrialMark(msgspec.Struct, frozen=True):
    """The trial that a mark is put on now, and the mark that is on it. Followed by programs that
    offer marks.

    Attributes:
        done: attempt and number of the last trial that was done; zeros if there is none to mark.
        open: the same of the trial under way; zeros if there is none.
        marks: names of the marks in this attempt by trial; empty if one was removed.
        done_is_unsure: True if the trial that was done is not sure without a mark.
    """

    done: tuple[int, int] = _NONE
    open: tuple[int, int] = _NONE
    marks: dict[tuple[int, int], str] = {}
    done_is_unsure: bool = False

    @property
    def trial(self) -> tuple[int, int]:
        """Attempt and number of the trial that a mark is put on; zeros if there is none."""
        return self.done if self.open == _NONE else self.open

    @property
    def present(self) -> str:
        """Name of the mark on the trial; empty without one."""
        return self.marks.get(self.trial, "")

    @property
    def is_unsure(self) -> bool:
        """True if a mark would decide what the trial was."""
        return self.done_is_unsure and self.open == _NONE and not self.present

    def after(self, message: Message) -> "TrialMark":
        """Return the state after a message of the session."""
        match message:
            case Waiting(stage="trial") if message.what in _OPEN:
                return replace(self, open=(message.attempt, message.trial))
            case TrialEnded():
                return replace(
                    self,
                    done=(message.attempt, message.trial),
                    open=_NONE,
                    done_is_unsure=message.is_unsure,
                )
            case PromptVoided():  # its mark is removed, and the last trial can be marked again
                return replace(self, open=_NONE)
            case AttemptStarted():  # the last attempt's trial cannot be marked any more
                return TrialMark()
            case TrialMarked():
                return replace(
                    self, marks=self.marks | {(message.attempt, message.trial): message.mark}
                )
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

    @property
    def is_unsure(self) -> bool:
        """True if a result is not sure without a mark."""
        return any(UNSURE in result.flags for result in self.measured.values())

    def toggled(self, mark: Mark) -> "MarkedResults":
        """Return the results with ``mark`` instead of the present one, or without it if that is the
        present one.
        """
        return MarkedResults(self.measured, toggled(self.mark, mark))


def find(marks: Iterable[Mark], name: str) -> Mark | None:
    """Return the mark with that name; None if the task has no such mark."""
    return next((mark for mark in marks if mark.name == name), None)


def toggled(present: Mark | None, mark: Mark) -> Mark | None:
    """Return the mark of a trial after ``mark`` was chosen: choosing the present one again removes
    it.
    """
    return None if present == mark else mark


def messages(
    attempt: int, trial: int, mark: Mark | None, correct: Mapping[str, bool]
) -> list[TrialMarked]:
    """Return a message per seat that reports the trial's mark, and whether its result is correct
    with it.
    """
    name = mark.name if mark else ""
    return [
        TrialMarked(seat=seat, attempt=attempt, trial=trial, mark=name, correct=is_correct)
        for seat, is_correct in correct.items()
    ]
