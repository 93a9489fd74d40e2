"""Runs attempts: trials, score, feedback, the next level, and a therapist's marks."""

from collections.abc import Collection

from sar_tui.framework import marks
from sar_tui.framework import messages as m
from sar_tui.framework.attempt_state import AttemptScore
from sar_tui.framework.attempts import Attempts
from sar_tui.framework.marks import MarkedResults, TrialMark
from sar_tui.framework.node import on
from sar_tui.framework.nodes.trial_flow import TrialFlow
from sar_tui.framework.session_phase import IN_TRIAL, MARKABLE, OVER, Phase
from sar_tui.framework.task import Task
from sar_tui.framework.topics import (
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FEEDBACK,
    LEVEL,
    LEVEL_DECIDED,
    LEVEL_REQUEST,
    MARKED,
    UNSAID_FEEDBACK,
)
from sar_tui.framework.trial_types import Mark, Results


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

    @property
    def _is_under_way(self) -> bool:
        """True if an attempt has begun and not ended."""
        return (self._paused_from if self._phase is Phase.PAUSED else self._phase) in IN_TRIAL

    # --- trials, score, feedback ----------------------------------------------------------------------------

    def _begin_attempt(self) -> None:
        self.emit(ATTEMPT_STARTED, self._attempts.begin(self.now))
        self._announced_level = self._attempts.level
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
        """Score, adapt and give feedback, in this order: memory must hold the attempt before feedback recalls it."""
        scored = self._attempts.score(self.now)
        self._publish_score(scored)
        self._give_feedback(scored, self.task.seats)
        self._after_feedback = Phase.READY if self._attempts.advance() else Phase.REVIEW
        self._feedback_due_at = max(one.feedback.due for one in scored.seats)
        self._await_feedback()

    def _give_feedback(self, scored: AttemptScore, seats: Collection[str]) -> None:
        for one in scored.seats:
            if one.is_feedback_due and one.ended.seat in seats:
                self.emit(FEEDBACK, one.feedback)

    def _request_feedback(self) -> None:
        """Give the requested feedback on the last attempt."""
        if requested := self._attempts.request_feedback(self.now):
            self._publish_score(requested)
            self._give_feedback(requested, self.task.seats)
            self._wait(self._phase)

    # --- waiting for feedback -------------------------------------------------------------------------------

    def _await_feedback(self) -> None:
        """Wait for delayed feedback: the next attempt does not begin before it."""
        if self._feedback_due_at > self.now:
            self._wait(Phase.FEEDBACK)
            self.set_timer("answer", self._feedback_due_at)
        else:
            self._wait(Phase.FEEDBACK if self._is_decision_pending else self._after_feedback)

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
        else:
            super().timer(name, late)

    # --- the level ------------------------------------------------------------------------------------------

    def _publish_score(self, scored: AttemptScore) -> None:
        """Publish the attempt, and the level that follows unless an operator has a say in it."""
        for one in scored.seats:
            self.emit(ATTEMPT_ENDED, one.ended)
        if scored.level is None:
            return
        request = m.LevelRequest(change=scored.level, is_last=scored.first.ended.attempt == self._attempts.total)
        if self.ask(LEVEL_REQUEST, request).happens:
            self.emit(LEVEL, scored.level)
        else:
            self._attempts.hold(scored.level)

    @on(LEVEL_DECIDED)
    def level_decided(self, decided: m.LevelDecided) -> None:
        """Apply a change of level that waited for an operator; a rejected one leaves the level as it is."""
        if decided.decision == "rejected" or self._phase in OVER:
            return
        self._publish_level(self._attempts.settle(decided.level, under_way=self._is_under_way))

    def _set_level(self, level: int) -> None:
        self._publish_level(self._attempts.set_level(level, under_way=self._is_under_way))

    def _publish_level(self, change: m.LevelChanged | None) -> None:
        if change:
            self.emit(LEVEL, change)
        if self._phase is Phase.READY:
            self._wait(Phase.READY)

    # --- marks ----------------------------------------------------------------------------------------------

    @property
    def trial_mark(self) -> TrialMark:
        """The trial that a mark is put on now, and the mark that is on it."""
        if self._phase in IN_TRIAL and self._phase not in MARKABLE:
            trial, mark = (self._attempts.attempt, self._attempts.trial), self._trial.mark
            return TrialMark(open=trial, marks={trial: mark.name if mark else ""})
        if last := self._attempts.amendable_trial:
            mark = self._last_results.mark
            return TrialMark(done=last, marks={last: mark.name if mark else ""})
        return TrialMark()

    def _mark(self, mark: Mark) -> None:
        """Mark the open trial, or else the last one, whose attempt is then scored again if it has ended."""
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
        if scored := self._attempts.amend(results, unsaid):
            self._publish_score(scored)
            self._give_feedback(scored, unsaid)
            self._wait(self._phase)

    def _mark_open_trial(self, mark: Mark | None) -> None:
        self._trial.mark = mark
        correct = dict.fromkeys(self._trial.seats, mark.counts if mark else True)
        for message in marks.messages(self._attempts.attempt, self._attempts.trial, mark, correct):
            self.emit(MARKED, message)
