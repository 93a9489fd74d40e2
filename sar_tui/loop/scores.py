"""Publishes what follows from the trials: scores, levels, goals, feedback, and marks."""

from collections.abc import Collection

from msgspec.structs import replace

from sar_tui.loop import marks
from sar_tui.loop.attempt_state import AttemptScore, AttemptState
from sar_tui.loop.attempts import Attempts
from sar_tui.loop.marks import MarkedResults, TrialMark
from sar_tui.loop.node import Node
from sar_tui.loop.session_phase import IN_TRIAL, MARKABLE, text_of
from sar_tui.loop.status import Status
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    FEEDBACK,
    GOAL,
    LEVEL,
    LEVEL_REQUEST,
    MARKED,
    UNSAID_FEEDBACK,
)
from sar_tui.loop.trial import OpenTrial
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Mark, Results

_HARDER = {
    "target": "That went well, so it gets a little harder.",
    "sequence": "Your plan goes on: a little harder now.",
}
_EASIER = {
    "target": "It gets a little easier now.",
    "sequence": "Your plan goes on: a little easier now.",
}
_UNSURE = "I did not see that one clearly, so it does not count. That is all right."


class Scores:
    """The scores of a session's attempts, and what the next attempt owes to them.

    Nothing here changes the order of a session, so that marks, levels and requests are possible at
    any time. A caller shows the session's state again if a method returns True.
    """

    def __init__(self, node: Node, task: Task, attempts: Attempts, status: Status) -> None:
        self._node = node
        self._task = task
        self._attempts = attempts
        self._status = status
        self._last_results = MarkedResults({})
        self._announced_level = 0
        self._level_change: m.LevelChanged | None = None
        self._goal_change: m.GoalChanged | None = None

    # --- trials and attempts

    def begin_attempt(self) -> None:
        """Note what the participant knows from here on."""
        self._announced_level = self._attempts.level
        self._level_change = self._goal_change = None

    def add(self, results: Results, mark: Mark | None) -> Results:
        """Add the results of a trial. Returns them as they are stored: with its mark."""
        self._last_results = MarkedResults(results, mark)
        self._attempts.add(self._last_results.results)
        return self._last_results.results

    def end_attempt(self) -> AttemptScore:
        """Score the attempt, and publish what follows.

        Memory must hold the attempt before feedback recalls it.
        """
        before = self._attempts.state
        scored = self._attempts.score(self._node.now)
        self._publish(scored, before)
        self._give_feedback(scored, self._task.seats)
        return scored

    def request_feedback(self) -> bool:
        """Give the requested feedback on the last attempt; False if there is none."""
        before = self._attempts.state
        requested = self._attempts.request_feedback(self._node.now)
        if requested is None:
            return False
        self._publish(requested, before)
        self._give_feedback(requested, self._task.seats)
        return True

    def _publish(self, scored: AttemptScore, before: AttemptState) -> None:
        """Publish the attempt, the level that follows, and the goal."""
        for one in scored.seats:
            self._node.emit(ATTEMPT_ENDED, one.ended)
        if change := scored.level:
            is_last = scored.first.ended.attempt == self._attempts.total
            request = m.LevelRequest(change=change, is_last=is_last)
            if self._node.ask(LEVEL_REQUEST, request).happens:
                self._emit_level(change)
            else:
                self._attempts.hold(change)
        self._publish_goal(before)

    def _give_feedback(self, scored: AttemptScore, seats: Collection[str]) -> None:
        for one in scored.seats:
            if one.feedback and one.is_feedback_due and one.ended.seat in seats:
                self._node.emit(FEEDBACK, one.feedback)

    # --- the level and the settings of the next attempt

    def set_level(self, level: int) -> None:
        """Set the level by hand."""
        before = self._attempts.state
        under_way = self._status.is_attempt_under_way
        self._change_level(self._attempts.set_level(level, under_way=under_way), before)

    def restore_level(self, before: AttemptState) -> None:
        """Take back a level that was set by hand, in the state ``before`` it."""
        now = self._attempts.state
        self._change_level(self._attempts.restore_level(before), now)

    def settle_level(self, level: int) -> None:
        """Apply a change of level that waited for an operator, as decided."""
        before = self._attempts.state
        under_way = self._status.is_attempt_under_way
        self._change_level(self._attempts.settle(level, under_way=under_way), before)

    def change_setting(self, name: str, value: int | float) -> None:
        """Change a setting. Raises ParameterError if it cannot be, or not to this value."""
        under_way = self._status.is_attempt_under_way
        self._attempts.change_setting(name, value, under_way=under_way)

    def _change_level(self, change: m.LevelChanged | None, before: AttemptState) -> None:
        if change:
            self._emit_level(change)
        self._publish_goal(before)

    def _emit_level(self, change: m.LevelChanged) -> None:
        self._level_change = change
        self._node.emit(LEVEL, change)

    def _publish_goal(self, before: AttemptState) -> None:
        if change := self._attempts.goal_change_since(before):
            self._goal_change = change
            self._node.emit(GOAL, change)

    @property
    def explained(self) -> str:
        """Sentences for the participant: that the last attempt does not count, and why the next one
        has another level or goal.

        Nothing is said of a level under the default difficulty policy, as the feedback has just
        said whether the goal was reached, nor of one that somebody set by hand.
        """
        if not self._announced_level:
            return ""
        tr = self._task.tr
        found = [tr(_UNSURE)] if self._attempts.is_unsure else []
        if (change := self._level_change) and self._attempts.level != self._announced_level:
            is_harder = self._attempts.level > self._announced_level
            text = (_HARDER if is_harder else _EASIER).get(change.reason, "")
            found.append(tr(text) if text else "")
        if self._goal_change:
            found.append(tr("The goal follows what you have just done."))
        return " ".join(filter(None, found))

    @property
    def level_notice(self) -> str:
        """Notice of a level that differs from the last attempt's; empty for none."""
        level, before = self._attempts.level, self._announced_level
        return "" if level == before else text_of(self._task.notice(level, before), "notice")

    # --- marks

    def mark(self, mark: Mark, trial: OpenTrial | None) -> bool:
        """Mark the open trial, or else the last one. Returns True if its attempt was scored again."""
        if self._status.phase in MARKABLE:
            return self._mark_last_trial(mark)
        if self._status.phase in IN_TRIAL and trial:
            self.mark_open_trial(trial, marks.toggled(trial.mark, mark))
        return False

    def mark_open_trial(self, trial: OpenTrial, mark: Mark | None) -> None:
        """Mark the open trial, or remove its mark."""
        trial.mark = mark
        correct = dict.fromkeys(trial.seats, mark.counts if mark else True)
        attempts = self._attempts
        for message in marks.messages(attempts.attempt, attempts.trial, mark, correct):
            self._node.emit(MARKED, message)

    def _mark_last_trial(self, mark: Mark) -> bool:
        last = self._attempts.amendable_trial
        if last is None:
            return False
        self._last_results = self._last_results.toggled(mark)
        results = self._last_results.results
        correct = {seat: result.correct for seat, result in results.items()}
        for message in marks.messages(*last, self._last_results.mark, correct):
            self._node.emit(MARKED, message)
        request = m.UnsaidFeedbackRequest(attempt=last[0])
        unsaid = self._node.ask(UNSAID_FEEDBACK, request).seats
        if self._attempts.is_unsure:  # there was no feedback
            unsaid = tuple(results)
        before = self._attempts.state
        scored = self._attempts.amend(results, unsaid)
        if scored is None:
            return False
        self._publish(scored, before)
        self._give_feedback(scored, unsaid)
        return True

    def trial_mark(self, trial: OpenTrial | None) -> TrialMark:
        """Return the trial that a mark is put on now, and the mark that is on it."""
        found = TrialMark()
        if last := self._attempts.amendable_trial:
            found = replace(
                found,
                done=last,
                marks={last: _name(self._last_results.mark)},
                done_is_unsure=self._last_results.is_unsure,
            )
        if trial and self._status.phase in IN_TRIAL and self._status.phase not in MARKABLE:
            number = (self._attempts.attempt, self._attempts.trial)
            found = replace(found, open=number, marks=found.marks | {number: _name(trial.mark)})
        return found


def _name(mark: Mark | None) -> str:
    return mark.name if mark else ""
