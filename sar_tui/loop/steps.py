"""The steps between attempts: which are due, the one that is asked, and what came of it."""

from collections.abc import Iterator
from typing import NamedTuple

from msgspec.structs import replace

from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.step import TIMED, Answer, Entry, Given, Step, press, translated
from sar_tui.model.units import SECOND
from sar_tui.rules.questions import chosen


class Ended(NamedTuple):
    """End of a step: how, with which answer, and when (ns)."""

    status: m.StepStatus
    answer: Answer
    at: int


class Steps:
    """Questions, screens to read, rests and calibrations.

    The steps are the task's, then those that the therapist chose, then those that the session was
    begun with; before all of them those that require an answer. In a task for several, each
    participant answers the questions in turn.

    Attributes:
        given: those that the session was begun with.
        attempts_done: number of attempts that ended, without practice.
        asked: the step on the screen.
    """

    def __init__(self, task: Task) -> None:
        self._task = task
        self.given: tuple[Step, ...] = ()
        self.attempts_done = 0
        self.asked: m.AskedStep | None = None
        self._due: tuple[tuple[Step, str], ...] = ()
        self._before_end: tuple[tuple[tuple[Step, str], ...], bool] = ((), False)
        self._looked_after: int | None = None
        self._number = 0
        self._is_agreed = False

    @property
    def awaits_agreement(self) -> bool:
        """True until each participant has given the answers that are required, if there are any."""
        return not self._is_agreed and any(step.required for step in self._all)

    @property
    def _all(self) -> tuple[Step, ...]:
        parameters = self._task.parameters
        own = chosen(parameters.questions, parameters.questions_every)
        return (*self._task.steps, *own, *self.given)

    def due(self, *, is_last: bool) -> Iterator[Step]:
        """Yield the steps that are due now, as they are to be asked. Each is due once.

        ``is_last``: no attempt follows.
        """
        if self._looked_after != self.attempts_done:
            self._looked_after = self.attempts_done
            self._due = self._due_now(is_last=is_last)
        while self._due:
            yield self._ask(*self._due[0])

    def _due_now(self, *, is_last: bool) -> tuple[tuple[Step, str], ...]:
        done = self.attempts_done
        total = done if is_last and done else self._task.parameters.attempts
        required_first = sorted(self._all, key=lambda step: not step.required)
        return tuple(
            (step, seat)
            for step in required_first
            if step.is_due(done, total)
            for seat in (self._task.seats if step.is_question else self._task.seats[:1])
        )

    def _ask(self, step: Step, seat: str) -> Step:
        self._number += 1
        is_one_of_several = len(self._task.seats) > 1 and step.is_question
        who = self._task.display_name(seat) if is_one_of_several else ""
        step = translated(step, self._task.tr)
        self.asked = m.AskedStep(number=self._number, step=step, seat=seat, who=who)
        return step

    def show(self, now: int) -> None:
        """Note that the step appears now: for the first time, or after a pause."""
        assert self.asked
        self.asked = replace(self.asked, shown=now)

    @property
    def until(self) -> int:
        """When a rest or a calibration is over (ns); 0 for other steps."""
        if self.asked is None or self.asked.step.kind not in TIMED:
            return 0
        return self.asked.shown + round(self.asked.step.seconds * SECOND)

    def press(self, key: m.KeyPerceived) -> Ended | Entry | None:
        """Take a key. Returns how it ends the step, or a changed answer; None if it does nothing."""
        asked = self.asked
        assert asked
        if key.key == "enter" and key.repeat:
            return None
        if not asked.step.is_question:
            return Ended("done", None, key.at) if key.key == "enter" else None
        given = press(asked.step, asked.entry, key.key)
        if isinstance(given, Given):
            return Ended(given.status, given.answer, key.at)
        if given == asked.entry:
            return None
        self.asked = replace(asked, entry=given)
        return given

    def end(self, ended: Ended) -> m.StepEnded:
        """End the step. Returns what came of it."""
        asked = self.asked
        assert asked
        self._before_end = self._due, self._is_agreed
        self.asked, self._due = None, self._due[1:]
        step = asked.step
        if not is_refusal(step, ended.answer):
            self._is_agreed = self._is_agreed or not any(step.required for step, _ in self._due)
        return m.StepEnded(
            seat=asked.seat,
            number=asked.number,
            attempt=self.attempts_done,
            name=step.name,
            kind=step.kind,
            text=step.text,
            labels=step.labels,
            status=ended.status,
            answer=ended.answer,
            shown=asked.shown,
            ended=ended.at,
        )

    def take_back(self) -> None:
        """Take back the end of the last step: it is due again."""
        self.asked = None
        self._due, self._is_agreed = self._before_end


def is_refusal(step: Step, answer: Answer) -> bool:
    """Return True if an answer is required, and another was given."""
    return bool(step.required) and answer != step.required
