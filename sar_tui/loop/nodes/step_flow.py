"""Runs the steps between attempts: questions, screens to read, rests and calibrations."""

from abc import abstractmethod

from msgspec.structs import replace

from sar_tui.loop.attempt_state import AttemptScore
from sar_tui.loop.nodes.attempt_flow import AttemptFlow
from sar_tui.loop.session_phase import Phase
from sar_tui.loop.task import Task
from sar_tui.loop.topics import STEP_ENDED
from sar_tui.model import messages as m
from sar_tui.model.step import TIMED, Step, translated
from sar_tui.model.step_entry import Answer, Entry, press
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.questions import chosen

TOO_SOON = 400 * MS
"""Until rules 6, Enter within this time of a step's appearance was meant for what stood there
before.
"""


class StepFlow(AttemptFlow):
    """Asks what is due before the first attempt and after each other, before a rest and before the
    next.

    The steps are the task's, then those that the therapist chose, then those that the session was
    begun with; before all of them those that require an answer. In a task for several, each
    participant answers the questions in turn.
    """

    def __init__(self, task: Task, seed: int) -> None:
        super().__init__(task, seed)
        self._given: tuple[Step, ...] = ()
        self._due: tuple[tuple[Step, str], ...] = ()
        self._asked: m.AskedStep | None = None
        self._asked_after: int | None = None
        self._done = self._number = 0
        self._is_agreed = False

    @property
    def _steps(self) -> tuple[Step, ...]:
        own = chosen(self.parameters.questions, self.parameters.questions_every, self._rules)
        return (*self.task.steps, *own, *self._given)

    @property
    def awaits_agreement(self) -> bool:
        """True until each participant has given the answers that are required, if there are any."""
        return not self._is_agreed and any(step.required for step in self._steps)

    @abstractmethod
    def _refuse(self) -> None:
        """End the session, as a required answer was not given."""

    # --- what is due

    def _count_attempt(self, scored: AttemptScore) -> None:
        super()._count_attempt(scored)
        self._done += not scored.first.ended.practice

    def _wait_or_rest(self) -> None:
        """Ask what is due after the attempt, and then wait for what follows."""
        if self._is_step_due():
            self._ask()
        else:
            super()._wait_or_rest()

    def _is_step_due(self) -> bool:
        """Return True if there is a step now. Each is due once, even if the session waits here
        again.
        """
        if self._asked_after != self._done:
            self._asked_after = self._done
            is_over = self._done > 0 and self._after_feedback is Phase.REVIEW
            total = self._done if is_over else self.parameters.attempts
            self._due = tuple(
                (step, seat)
                for step in sorted(self._steps, key=lambda step: not step.required)
                if step.is_due(self._done, total)
                for seat in (self.task.seats if step.is_question else self.task.seats[:1])
            )
        return bool(self._due)

    # --- asking

    def _ask(self) -> None:
        """Show the first step that is due."""
        step, seat = self._due[0]
        self._number += 1
        is_one_of_several = len(self.task.seats) > 1 and step.is_question
        who = self.task.display_name(seat) if is_one_of_several else ""
        self._asked = m.AskedStep(
            number=self._number, step=translated(step, self.task.tr), seat=seat, who=who
        )
        self._show_step()

    def _show_step(self) -> None:
        """Show the step that is asked, for the first time or after a pause."""
        assert self._asked
        self._asked = replace(self._asked, shown=self.now)
        if self._asked.step.kind in TIMED:
            self.set_timer("step", self._step_until)
        self._wait(Phase.STEP)

    @property
    def _step_until(self) -> int:
        """When a rest or a calibration is over (ns); 0 for other steps."""
        if self._asked is None or self._asked.step.kind not in TIMED:
            return 0
        return self._asked.shown + round(self._asked.step.seconds * SECOND)

    def _key_in_step(self, percept: m.KeyPerceived) -> None:
        asked = self._asked
        if asked is None or asked.step.kind in TIMED:
            return
        is_too_soon = self._rules < 6 and percept.at < asked.shown + TOO_SOON
        if percept.key == "enter" and (percept.repeat or is_too_soon):
            return
        if not asked.step.is_question:
            if percept.key == "enter":
                self._end_step("done", None, percept.at)
            return
        given = press(asked.step, asked.entry, percept.key)
        if not isinstance(given, Entry):
            self._end_step(given.status, given.answer, percept.at)
        elif given != asked.entry:
            self._asked = replace(asked, entry=given)
            self._wait(Phase.STEP)

    def _end_step(self, status: m.StepStatus, answer: Answer, at: int) -> None:
        """Publish what came of the step, and go on."""
        asked = self._asked
        assert asked
        self.cancel_timer("step")
        self._asked, self._due = None, self._due[1:]
        step = asked.step
        ended = m.StepEnded(
            seat=asked.seat,
            number=asked.number,
            attempt=self._done,
            name=step.name,
            kind=step.kind,
            text=step.text,
            labels=step.labels,
            status=status,
            answer=answer,
            shown=asked.shown,
            ended=at,
        )
        self.emit(STEP_ENDED, ended)
        if step.required and answer != step.required:
            self._refuse()
            return
        self._is_agreed = self._is_agreed or not any(step.required for step, _ in self._due)
        if self._due:
            self._ask()
        elif self._done:
            super()._wait_or_rest()
        else:
            self._await_first_attempt()

    def _await_first_attempt(self) -> None:
        """Wait for Enter, which begins the first attempt."""
        self._wait(Phase.READY)
        self._wait_for_decision()

    def timer(self, name: str, late: int) -> None:
        if name == "step":
            self._end_step("done", None, self.now)
        else:
            super().timer(name, late)
