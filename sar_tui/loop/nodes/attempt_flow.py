"""Runs attempts: trials, score, feedback, the next level, and a therapist's marks."""

from collections.abc import Collection

from msgspec.structs import replace

from sar_tui.loop import change_text, marks
from sar_tui.loop.answers import answer_to
from sar_tui.loop.attempt_state import AttemptScore, AttemptState
from sar_tui.loop.attempts import Attempts, NextAttempt
from sar_tui.loop.marks import MarkedResults, TrialMark
from sar_tui.loop.node import on
from sar_tui.loop.nodes.trial_flow import TrialFlow
from sar_tui.loop.session_phase import IN_TRIAL, MARKABLE, OVER, Phase
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ANSWERED,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FEEDBACK,
    GOAL,
    LEVEL,
    LEVEL_DECIDED,
    LEVEL_REQUEST,
    MARKED,
    SETTING,
    UNSAID_FEEDBACK,
)
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Mark, Results
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.limits import Dose, is_rest_due, is_session_over, reached_of_day

_MINUTE = 60 * SECOND
CONTINUES_AFTER = 1500 * MS
"""Time between two attempts of a continuous task."""
READING = 5 * SECOND
"""The same if there was feedback."""


class AttemptFlow(TrialFlow):
    """Runs one attempt after the other. A subclass runs the session around them."""

    def __init__(self, task: Task, seed: int) -> None:
        super().__init__(task)
        self._attempts = Attempts(task, seed)
        self._last_results = MarkedResults({})
        self._paused_from = Phase.INSTRUCTIONS
        self._after_feedback = Phase.READY
        self._feedback_due_at = 0
        self._is_decision_pending = False
        self._announced_level = 0
        self._done_today = Dose()
        self._run_began_at = self._attempt_began_at = self._last_ended_at = 0
        self._earlier_ns = 0
        self._limit = ""
        self._attempts_since_rest = 0
        self._must_rest = False
        self._rested_at = 0
        self._rest_until = 0
        self._level_change: m.LevelChanged | None = None
        self._goal_change: m.GoalChanged | None = None
        self._has_feedback = False
        self._continues_at = 0
        self._is_restarted = False

    @property
    def _is_under_way(self) -> bool:
        """True if an attempt has begun and not ended."""
        phase = self._paused_from if self._phase is Phase.PAUSED else self._phase
        return phase in IN_TRIAL or phase is Phase.RESULT

    # --- trials, score, feedback

    # --- limits

    def _count_from_here(self, done_today: Dose) -> None:
        """Begin to count the time and the dose of a run."""
        self._earlier_ns += max(self._last_ended_at - self._run_began_at, 0)
        self._run_began_at = self._attempt_began_at = self._last_ended_at = self.now
        self._done_today = done_today
        self._rested_at = self.now

    def _count_attempt(self, scored: AttemptScore) -> None:
        """Add the attempt that has ended."""
        self._done_today = self._done_today.plus(
            minutes=(self.now - self._attempt_began_at) / _MINUTE,
            repetitions=self.task.trials_at(scored.first.ended.level),
            is_practice=scored.first.ended.practice,
        )
        self._last_ended_at = self.now
        self._attempts_since_rest += 1

    @property
    def _limit_text(self) -> str:
        """Text for the participant if a limit is reached; empty for none."""
        if reached_of_day(self.task.parameters, self._done_today):
            return self.task.tr("That is enough for today. Well done.")
        minutes = (self._earlier_ns + self.now - self._run_began_at) / _MINUTE
        if is_session_over(self.task.parameters, minutes):
            return self.task.tr("The time for this session is over. Well done.")
        return ""

    # --- rests that must be taken

    def _wait_or_rest(self) -> None:
        """Wait for what follows the feedback: a rest first, if one must be taken before the next
        attempt.
        """
        if self._must_rest:
            self._must_rest, self._attempts_since_rest = False, 0
            self._rest(self.now + self.task.parameters.rest_seconds * SECOND)
        else:
            self._continue_after(READING if self._has_feedback else CONTINUES_AFTER)
            self._wait(self._after_feedback)

    def _continue_after(self, duration: int) -> None:
        """Let the next attempt of a continuous task begin by itself after a time in ns, unless it
        is the first.
        """
        goes_on = self._after_feedback is Phase.READY and not self._attempts.is_first_after_practice
        if self.task.continuous and goes_on:
            self._continues_at = self.now + duration
            self.set_timer("continue", self._continues_at)

    def _rest(self, until: int) -> None:
        """Rest until a time (ns), then wait for the next attempt."""
        self._rest_until = until
        if until > self.now:
            self._wait(Phase.REST)
            self.set_timer("rest", until)
        else:
            self._rested_at, self._rest_until = self.now, 0
            self.cancel_timer("rest")
            self._wait(Phase.READY)
            self._wait_for_decision()

    @property
    def is_resting(self) -> bool:
        """True in a rest that must be taken, also while the session is paused."""
        return (self._paused_from if self._phase is Phase.PAUSED else self._phase) is Phase.REST

    def _end_rest(self) -> None:
        """End a rest by hand; if the session is paused, when it goes on."""
        if self._phase is Phase.REST:
            self._rest(self.now)
        else:
            self._rest_until = self.now

    def _begin_attempt(self) -> None:
        self.cancel_timer("continue")
        self._is_restarted = False
        self._attempt_began_at = self.now
        self.emit(ATTEMPT_STARTED, self._attempts.begin(self.now))
        self._announced_level = self._attempts.level
        self._level_change = self._goal_change = None
        self._trial = self._attempts.next_trial()
        self._begin_trial()

    def _trial_done(self, results: Results) -> Results:
        self._last_results = MarkedResults(results, self._trial.mark)
        self._attempts.add(self._last_results.results)
        self._last_trial = self._attempts.last_trial
        return self._last_results.results

    def _next(self) -> None:
        if self._attempts.is_attempt_done:
            self._end_attempt()
        else:
            self._trial = self._attempts.next_trial()
            self._begin_trial()

    def _end_attempt(self) -> None:
        """Score, adapt and give feedback, in this order: memory must hold the attempt before
        feedback recalls it.
        """
        before = self._attempts.state
        scored = self._attempts.score(self.now)
        self._publish_score(scored, before)
        self._give_feedback(scored, self.task.seats)
        self._count_attempt(scored)
        self._limit = "" if self._attempts.attempt == self._attempts.total else self._limit_text
        goes_on = not self._limit and self._attempts.advance()
        self._after_feedback = Phase.READY if goes_on else Phase.REVIEW
        minutes = (self.now - self._rested_at) / _MINUTE
        self._must_rest = goes_on and is_rest_due(
            self.task.parameters, self._attempts_since_rest, minutes
        )
        self._feedback_due_at = max(one.feedback.due if one.feedback else 0 for one in scored.seats)
        self._has_feedback = any(one.is_feedback_due for one in scored.seats)
        self._await_feedback()

    def _give_feedback(self, scored: AttemptScore, seats: Collection[str]) -> None:
        for one in scored.seats:
            if one.feedback and one.is_feedback_due and one.ended.seat in seats:
                self.emit(FEEDBACK, one.feedback)

    def _request_feedback(self) -> None:
        """Give the requested feedback on the last attempt."""
        before = self._attempts.state
        if requested := self._attempts.request_feedback(self.now):
            self._publish_score(requested, before)
            self._give_feedback(requested, self.task.seats)
            if self.has_timer("continue"):
                self._continue_after(READING)
            self._wait(self._phase)

    # --- waiting for feedback

    def _await_feedback(self) -> None:
        """Wait for delayed feedback: the next attempt does not begin before it."""
        if self._feedback_due_at > self.now:
            self._wait(Phase.FEEDBACK)
            self.set_timer("answer", self._feedback_due_at)
        elif self._is_decision_pending:
            self._wait(Phase.FEEDBACK)
        else:
            self._wait_or_rest()

    def agent_acted(self, agent: m.AgentActing) -> None:
        """Wait for an operator's decision in the same way as for delayed feedback."""
        super().agent_acted(agent)
        was_pending, self._is_decision_pending = self._is_decision_pending, agent.awaits_operator
        if was_pending and not agent.awaits_operator and self._phase is Phase.FEEDBACK:
            self._await_feedback()
        self._wait_for_decision()

    def _wait_for_decision(self) -> None:
        if self._is_decision_pending and self._phase in (Phase.READY, Phase.REVIEW):
            self._after_feedback = self._phase
            self._wait(Phase.FEEDBACK)

    def timer(self, name: str, late: int) -> None:
        if name == "answer":
            self._await_feedback()
        elif name == "rest":
            self._rest(self.now)
        else:
            super().timer(name, late)

    # --- level and goal

    def _publish_score(self, scored: AttemptScore, before: AttemptState) -> None:
        """Publish the attempt, and the level that follows unless an operator has a say in it; then
        the goal.
        """
        for one in scored.seats:
            self.emit(ATTEMPT_ENDED, one.ended)
        if change := scored.level:
            request = m.LevelRequest(
                change=change, is_last=scored.first.ended.attempt == self._attempts.total
            )
            if self.ask(LEVEL_REQUEST, request).happens:
                self._emit_level(change)
            else:
                self._attempts.hold(change)
        self._publish_goal(before)

    def _emit_level(self, change: m.LevelChanged) -> None:
        self._level_change = change
        self.emit(LEVEL, change)

    def _publish_goal(self, before: AttemptState) -> None:
        if change := self._attempts.goal_change_since(before):
            self._goal_change = change
            self.emit(GOAL, change)

    @property
    def _why_changed(self) -> str:
        """Sentences for the participant: why the next attempt has another level or goal than the
        last one.
        """
        if not self._announced_level:
            return ""
        found = []
        if (change := self._level_change) and self._attempts.level != self._announced_level:
            harder = self._attempts.level > self._announced_level
            found.append(
                change_text.level_change_text(change.reason, harder=harder, tr=self.task.tr)
            )
        if self._goal_change:
            found.append(change_text.goal_change_text(self.task.tr))
        return " ".join(filter(None, found))

    @on(LEVEL_DECIDED)
    def level_decided(self, decided: m.LevelDecided) -> None:
        """Apply a change of level that waited for an operator; a rejected one leaves the level as
        it is.
        """
        if decided.decision == "rejected" or self._phase in OVER:
            return
        before = self._attempts.state
        self._publish_level(
            self._attempts.settle(decided.level, under_way=self._is_under_way), before
        )

    def _set_level(self, level: int) -> None:
        before = self._attempts.state
        self._publish_level(self._attempts.set_level(level, under_way=self._is_under_way), before)

    def _publish_level(self, change: m.LevelChanged | None, before: AttemptState) -> None:
        if change:
            self._emit_level(change)
        self._publish_goal(before)
        if self._phase is Phase.READY:
            self._wait(Phase.READY)

    # --- changes by a therapist

    @property
    def next_attempt(self) -> NextAttempt:
        """Level and settings of the next attempt."""
        return self._attempts.next

    @on(SETTING)
    def setting_changed(self, change: m.SettingChanged) -> None:
        """Change a setting from the next attempt on; one that does not fit is recorded, and left as
        it was.
        """
        if self._phase in OVER:
            self._answer(change, "late", "The session is over.")
            return
        try:
            self._attempts.change_setting(change.name, change.value, under_way=self._is_under_way)
        except ParameterError as error:
            self._answer(change, "refused", str(error))
        else:
            self._answer(change)
        if self._phase is Phase.READY:
            self._wait(Phase.READY)

    def _answer(self, act: m.OperatorAct, outcome: m.ActOutcome = "done", why: str = "") -> None:
        """Answer an operator's act, if it carries an id."""
        if act.id:
            self.emit(ANSWERED, answer_to(act, self.now, outcome, why))

    # --- marks

    @property
    def trial_mark(self) -> TrialMark:
        """The trial that a mark is put on now, and the mark that is on it."""
        found = TrialMark()
        if last := self._attempts.amendable_trial:
            found = replace(found, done=last, marks={last: _name(self._last_results.mark)})
        if self._phase in IN_TRIAL and self._phase not in MARKABLE:
            trial = (self._attempts.attempt, self._attempts.trial)
            found = replace(found, open=trial, marks=found.marks | {trial: _name(self._trial.mark)})
        return found

    def _mark(self, mark: Mark) -> None:
        """Mark the open trial, or else the last one, whose attempt is then scored again if it has
        ended.
        """
        if self._phase in MARKABLE:
            self._mark_last_trial(mark)
        elif self._phase in IN_TRIAL:
            self._mark_open_trial(marks.toggled(self._trial.mark, mark))

    def _mark_last_trial(self, mark: Mark) -> None:
        if (last := self._attempts.amendable_trial) is None:
            return
        self._last_results = self._last_results.toggled(mark)
        results = self._last_results.results
        correct = {seat: result.correct for seat, result in results.items()}
        for message in marks.messages(*last, self._last_results.mark, correct):
            self.emit(MARKED, message)
        unsaid = self.ask(UNSAID_FEEDBACK, m.UnsaidFeedbackRequest(attempt=last[0])).seats
        before = self._attempts.state
        if scored := self._attempts.amend(results, unsaid):
            self._publish_score(scored, before)
            self._give_feedback(scored, unsaid)
            self._wait(self._phase)

    def _mark_open_trial(self, mark: Mark | None) -> None:
        self._trial.mark = mark
        correct = dict.fromkeys(self._trial.seats, mark.counts if mark else True)
        for message in marks.messages(self._attempts.attempt, self._attempts.trial, mark, correct):
            self.emit(MARKED, message)


def _name(mark: Mark | None) -> str:
    return mark.name if mark else ""
