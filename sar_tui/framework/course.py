"""The course of a session: which attempt it is at, at what level, and what became of the trials so far."""

from typing import NamedTuple

import msgspec

from sar_tui.framework.chance import Chance
from sar_tui.framework.clock import MS
from sar_tui.framework.messages import AttemptEnded, AttemptStarted, Feedback, FeedbackChoice, LevelChanged
from sar_tui.framework.policies import difficulty, feedback
from sar_tui.framework.task import Result, Score, Situation, Target, Task
from sar_tui.framework.trial import OpenTrial


class Scored(NamedTuple):
    """What follows from an attempt: its row, the change of level and the answer to it, where there are such.

    The answer is there whether it is due or not: the participant may ask for it.
    """

    ended: AttemptEnded
    level: LevelChanged | None
    feedback: Feedback

    @property
    def is_answered(self) -> bool:
        """Whether the answer is due."""
        return self.ended.feedback != "none"


class _Ended(NamedTuple):
    """What an attempt was scored from, so that it can be scored once more."""

    attempt: int
    level: int
    overridden: bool
    difficulty: difficulty.Difficulty
    history: feedback.History
    results: list[Result]
    scored: AttemptEnded
    feedback: Feedback


class Course:
    """Practice attempts first, then those that count. Scores and adapts; waits for nothing and shows nothing.

    Args:
        task: built with its parameters.
        seed: of the session.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self._difficulty = difficulty.start(task.parameters, task.levels)
        self._history = feedback.History()
        self._overridden = False
        self._started = 0
        self._ended: _Ended | None = None
        self._held: LevelChanged | None = None
        self.attempt = 1
        self.level = self._difficulty.level
        self.results: list[Result] = []

    @property
    def is_practice(self) -> bool:
        """Whether the attempt is for practice: answered each time, but without effect on the level."""
        return self.attempt <= self._task.parameters.practice_attempts

    @property
    def name(self) -> str:
        """The attempt in words: "attempt 3 of 20"."""
        practice, tr = self._task.parameters.practice_attempts, self._task.tr
        if self.is_practice:
            return tr("practice {number} of {total}", number=self.attempt, total=practice)
        return tr("attempt {number} of {total}", number=self.attempt - practice, total=self._task.parameters.attempts)

    @property
    def trial(self) -> int:
        """The number of the next trial, from 1."""
        return len(self.results) + 1

    @property
    def last_trial(self) -> tuple[int, int]:
        """The attempt and number of the last trial that was done."""
        return (self.attempt, len(self.results))

    @property
    def is_attempt_done(self) -> bool:
        """Whether every trial of the attempt is done."""
        return len(self.results) >= self._task.trials_per_attempt

    def begin(self, now: int) -> AttemptStarted:
        """Begin the attempt at ``now`` (ns)."""
        self.results = []
        self._ended = None
        self._overridden = False
        self._started = now
        return AttemptStarted(
            attempt=self.attempt,
            practice=self.is_practice,
            level=self.level,
            trials=self._task.trials_per_attempt,
        )

    def next_trial(self) -> OpenTrial:
        """The next trial of the attempt: the same whenever it is asked for."""
        situation = Situation(
            attempt=self.attempt,
            trial=self.trial,
            level=self.level,
            chance=Chance(self._seed, self.attempt, self.trial),
            session=Chance(self._seed),
        )
        return OpenTrial(situation, self._task.stimulus(situation))

    def score(self, now: int) -> Scored:
        """Score the attempt, and set the level of the next."""
        parameters = self._task.parameters
        score = self._task.score(self.results)
        level = self.level
        target = self._task.target(level)
        verdict = feedback.judge(score, self._task.metric, target, parameters.min_accuracy)
        before = self._history
        judged = feedback.Judged(score, target, verdict.outcome)
        if not self.is_practice:
            self._history = feedback.remember(before, judged, parameters)
        content = self._task.feedback_on
        choice = feedback.choose(self._history, judged, parameters, content, practice=self.is_practice)
        answer = self._answer(score, verdict, target, choice, now)
        if choice.due and not self.is_practice:
            self._history = feedback.answered(self._history)
        qualities = answer.qualities
        ended = AttemptEnded(
            attempt=self.attempt,
            practice=self.is_practice,
            level=level,
            metric=score.metric,
            metric_unit=self._task.metric.unit,
            accuracy=score.accuracy,
            correct=score.correct,
            trials=score.trials,
            goal=target.threshold,
            outcome=verdict.outcome,
            feedback=answer.valence if choice.due else "none",
            qualities=qualities,
            choice=answer.choice,
            started=self._started,
            ended=now,
        )
        self._ended = _Ended(
            self.attempt, level, self._overridden, self._difficulty, before, self.results, ended, answer
        )
        changed = None
        if not (self.is_practice or self._overridden):
            self._difficulty = difficulty.step(self._difficulty, verdict.outcome, parameters, self._task.levels)
            changed = self._change(level, verdict.outcome)
        self.level = self._difficulty.level
        return Scored(ended, changed, answer)

    def _answer(
        self, score: Score, verdict: feedback.Judgement, target: Target, choice: FeedbackChoice, now: int
    ) -> Feedback:
        """What there is to say of the attempt, or of the last ones where it sums them up."""
        reached = int(verdict.outcome == "success")
        if choice.attempts > 1:
            enough = self._task.parameters.min_accuracy
            verdict, mean, target, reached = feedback.judge_summary(self._history.recent, self._task.metric, enough)
            choice = msgspec.structs.replace(choice, degree=feedback.degree(mean.metric, target))
            score = msgspec.structs.replace(score, metric=mean.metric)
        return Feedback(
            attempt=self.attempt,
            level=self.level,
            valence=verdict.valence,
            reason=verdict.reason,
            metric=score.metric,
            goal=target.threshold,
            accuracy=score.accuracy,
            correct=score.correct,
            trials=score.trials,
            reached=reached,
            qualities=self._qualities(),
            remark=self._task.tr(next((result.remark for result in reversed(self.results) if result.remark), "")),
            due=now + choice.delay_ms * MS if choice.due else 0,
            choice=choice,
        )

    @property
    def unanswered(self) -> Feedback | None:
        """What there is to say of the last attempt, where the participant may ask for it and has not yet."""
        if self._ended is None or self._ended.scored.feedback != "none":
            return None
        return self._ended.feedback if self._ended.feedback.choice.schedule == "request" else None

    def ask(self, now: int) -> Scored | None:
        """Answer the last attempt, because the participant asked to; None where there is nothing to be had."""
        if (answer := self.unanswered) is None or self._ended is None:
            return None
        choice = msgspec.structs.replace(answer.choice, due=True, why="The participant asked for it.")
        answer = msgspec.structs.replace(answer, due=now, choice=choice)
        again = msgspec.structs.replace(self._ended.scored, feedback=answer.valence, choice=choice)
        self._ended = self._ended._replace(scored=again, feedback=answer)
        self._history = feedback.answered(self._history)
        return Scored(again, None, answer)

    def _qualities(self) -> dict[str, float]:
        """The mean of each of the task's qualities over the correct trials that have it."""
        means = {}
        for quality in self._task.qualities:
            kept = [result.details.get(quality.field) for result in self.results if result.correct]
            values = [float(value) for value in kept if isinstance(value, int | float)]
            if values:
                means[quality.field] = sum(values) / len(values)
        return means

    @property
    def amendable(self) -> tuple[int, int] | None:
        """The attempt and number of the last trial, while it can be amended."""
        if self._ended:
            return (self._ended.attempt, len(self._ended.results))
        return self.last_trial if self.results and not self.is_attempt_done else None

    def amend(self, result: Result, *, is_told: bool = True) -> Scored | None:
        """Put another result in the place of the last, and score its attempt once more if it has ended.

        That can be done until the next attempt begins, or the level is set by hand. What was said of it stands; what
        was not told yet is another answer then.
        """
        if self._ended is None:
            self.results[-1:] = [result]
            return None
        level, was = self.level, self._ended
        self.attempt, self.level, self._overridden, self._difficulty, self._history = was[:5]
        self._started = was.scored.started
        self.results = [*was.results[:-1], result]
        anew = self.score(was.scored.ended)
        again = anew.ended
        if is_told:
            again = msgspec.structs.replace(anew.ended, feedback=was.scored.feedback, choice=was.scored.choice)
        self._ended = self._ended._replace(scored=again)
        if is_told and not self.is_practice:
            since = was.history.since + 1 if was.scored.feedback == "none" else 0
            self._history = msgspec.structs.replace(self._history, since=since)
        self.advance()
        changed = LevelChanged(previous=level, level=self.level, reason="mark") if level != self.level else None
        return Scored(again, changed, anew.feedback)

    def advance(self) -> bool:
        """Go on to the next attempt; False if that was the last."""
        parameters = self._task.parameters
        if self.attempt == parameters.practice_attempts + parameters.attempts:
            return False
        self.attempt += 1
        self.results = []
        return True

    def set_level(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """Set the level of the next attempt. One that is under way keeps its own, and does not change the next."""
        parameters = self._task.parameters
        highest = min(parameters.max_level, self._task.levels)
        before = self._difficulty.level
        self._difficulty = difficulty.Difficulty(max(parameters.min_level, min(level, highest)))
        self._ended = None
        self._overridden = True
        if not under_way:
            self.level = self._difficulty.level
        return self._change(before, "operator")

    def hold(self, change: LevelChanged) -> None:
        """A change that followed from the last attempt does not happen, or not yet: the level stays as it was."""
        self._held = change
        self._difficulty = difficulty.Difficulty(change.previous)
        self.level = change.previous

    def settle(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """A change that was held happens after all, to ``level``; an attempt that is under way keeps its own."""
        held = self._held
        reason = held.reason if held and held.level == level else "operator"
        highest = min(self._task.parameters.max_level, self._task.levels)
        before = self._difficulty.level
        self._difficulty = difficulty.Difficulty(max(self._task.parameters.min_level, min(level, highest)))
        if not under_way:
            self.level = self._difficulty.level
        return self._change(before, reason)

    def _change(self, before: int, reason: str) -> LevelChanged | None:
        after = self._difficulty.level
        return LevelChanged(previous=before, level=after, reason=reason) if after != before else None
