"""The course of a session: which attempt it is at, at what level, and what became of the trials so far."""

from collections.abc import Collection
from typing import NamedTuple

import msgspec

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import AttemptEnded, AttemptStarted, Feedback, FeedbackChoice, LevelChanged, Outcome
from sar_tui.framework.policies import difficulty, feedback
from sar_tui.framework.random_streams import RandomStreams
from sar_tui.framework.task import Task
from sar_tui.framework.trial import OpenTrial
from sar_tui.framework.trial_types import Result, Results, Score, Situation, Target


class Scored(NamedTuple):
    """What follows from an attempt: its row, the change of level and the answer to it, where there are such.

    The answer is there whether it is due or not: the participant may ask for it. ``others``: the same for those at the
    other seats; the level is everybody's.
    """

    ended: AttemptEnded
    level: LevelChanged | None
    feedback: Feedback
    others: tuple["Scored", ...] = ()

    @property
    def each(self) -> tuple["Scored", ...]:
        """What follows for each of those who took part."""
        return (self, *self.others)

    @property
    def is_answered(self) -> bool:
        """Whether the answer is due."""
        return self.ended.feedback != "none"


_FAILURE_FIRST: tuple[Outcome, ...] = ("failure", "success")
"""Of several the one that counts for the level."""


class _Ended(NamedTuple):
    """What an attempt was scored from, so that it can be scored once more."""

    attempt: int
    level: int
    overridden: bool
    difficulty: difficulty.Difficulty
    histories: dict[str, feedback.History]
    results: list[Result | Results]
    scored: dict[str, AttemptEnded]
    feedback: dict[str, Feedback]
    outcome: Outcome

    @property
    def at(self) -> int:
        """When it ended (ns)."""
        return next(iter(self.scored.values())).ended


class Attempts:
    """Practice attempts first, then those that count. Scores and adapts; waits for nothing and shows nothing.

    Where several take part each is scored and answered for themselves. The level is everybody's, and an attempt counts
    for it as a success where all of them reached the goal. Who won a race is another matter, which the answers tell.

    Args:
        task: built with its parameters.
        seed: of the session.

    Attributes:
        results: of the attempt's trials so far: by seat, or alone where there is but one.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self._difficulty = difficulty.start(task.parameters, task.levels)
        self._histories = {seat: feedback.History() for seat in task.seats}
        self._overridden = False
        self._started = 0
        self._ended: _Ended | None = None
        self._held: LevelChanged | None = None
        self.attempt = 1
        self.level = self._difficulty.level
        self.results: list[Result | Results] = []

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
            streams=RandomStreams(self._seed, self.attempt, self.trial),
            session=RandomStreams(self._seed),
        )
        return OpenTrial(situation, self._task.stimulus(situation), self._task.seats)

    def _of(self, seat: str) -> list[Result]:
        """The results of one who took part."""
        each = (result if isinstance(result, dict) else {self._task.seats[0]: result} for result in self.results)
        return [results[seat] for results in each if seat in results]

    def score(self, now: int) -> Scored:
        """Score the attempt, and set the level of the next."""
        parameters, task = self._task.parameters, self._task
        level, before = self.level, dict(self._histories)
        target = task.target(level)
        scores = {seat: task.score(results) for seat in task.seats if (results := self._of(seat))}
        verdicts = {
            seat: feedback.judge(score, task.metric, target, parameters.min_accuracy) for seat, score in scores.items()
        }
        told = feedback.judge_race(scores, verdicts)
        each = [
            self._score(seat, score, feedback.Judged(score, target, verdicts[seat].outcome), told[seat], now)
            for seat, score in scores.items()
        ]
        outcome = min((verdict.outcome for verdict in verdicts.values()), key=_FAILURE_FIRST.index)
        self._ended = _Ended(
            self.attempt,
            level,
            self._overridden,
            self._difficulty,
            before,
            self.results,
            {one.ended.seat: one.ended for one in each},
            {one.ended.seat: one.feedback for one in each},
            outcome,
        )
        changed = None
        if not (self.is_practice or self._overridden):
            self._difficulty = difficulty.step(self._difficulty, outcome, parameters, task.levels)
            changed = self._change(level, outcome)
        self.level = self._difficulty.level
        return each[0]._replace(level=changed, others=tuple(each[1:]))

    def _score(self, seat: str, score: Score, judged: feedback.Judged, verdict: feedback.Judgement, now: int) -> Scored:
        """Score the attempt for one of those who took part."""
        parameters = self._task.parameters
        if not self.is_practice:
            self._histories[seat] = feedback.remember(self._histories[seat], judged, parameters)
        history, content = self._histories[seat], self._task.feedback_on
        choice = feedback.choose(history, judged, parameters, content, practice=self.is_practice)
        if verdict.reason in feedback.RACED:
            choice = msgspec.structs.replace(choice, degree="clear")
        answer = self._answer(seat, score, verdict, judged.target, choice, now)
        if choice.due and not self.is_practice:
            self._histories[seat] = feedback.answered(history)
        ended = AttemptEnded(
            seat=seat,
            attempt=self.attempt,
            practice=self.is_practice,
            level=self.level,
            metric=score.metric,
            metric_unit=self._task.metric.unit,
            accuracy=score.accuracy,
            correct=score.correct,
            trials=score.trials,
            goal=judged.target.threshold,
            outcome=verdict.outcome,
            feedback=answer.valence if choice.due else "none",
            qualities=answer.qualities,
            choice=answer.choice,
            started=self._started,
            ended=now,
        )
        return Scored(ended, None, answer)

    def _answer(
        self, seat: str, score: Score, verdict: feedback.Judgement, target: Target, choice: FeedbackChoice, now: int
    ) -> Feedback:
        """What there is to say of the attempt, or of the last ones where it sums them up."""
        reached = int(verdict.outcome == "success")
        if choice.attempts > 1:
            enough = self._task.parameters.min_accuracy
            verdict, mean, target, reached = feedback.judge_summary(
                self._histories[seat].recent, self._task.metric, enough
            )
            choice = msgspec.structs.replace(choice, degree=feedback.degree(mean.metric, target))
            score = msgspec.structs.replace(score, metric=mean.metric)
        results = self._of(seat)
        return Feedback(
            seat=seat,
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
            won=score.won,
            qualities=self._qualities(results) | self._task.measures(results),
            remark=self._task.tr(next((result.remark for result in reversed(results) if result.remark), "")),
            due=now + choice.delay_ms * MS if choice.due else 0,
            choice=choice,
        )

    @property
    def unanswered(self) -> Feedback | None:
        """What there is to say of the last attempt, where the participant may ask for it and has not yet."""
        return next(iter(self._unanswered()), None)

    def _unanswered(self) -> list[Feedback]:
        if self._ended is None:
            return []
        scored = self._ended.scored
        return [
            answer
            for seat, answer in self._ended.feedback.items()
            if scored[seat].feedback == "none" and answer.choice.schedule == "request"
        ]

    def ask(self, now: int) -> Scored | None:
        """Answer the last attempt, because a participant asked to; None where there is nothing to be had."""
        each = [self._ask(answer, now) for answer in self._unanswered()]
        return each[0]._replace(others=tuple(each[1:])) if each else None

    def _ask(self, answer: Feedback, now: int) -> Scored:
        assert self._ended
        choice = msgspec.structs.replace(answer.choice, due=True, why="The participant asked for it.")
        answer = msgspec.structs.replace(answer, due=now, choice=choice)
        again = msgspec.structs.replace(self._ended.scored[answer.seat], feedback=answer.valence, choice=choice)
        self._ended.scored[answer.seat] = again
        self._ended.feedback[answer.seat] = answer
        self._histories[answer.seat] = feedback.answered(self._histories[answer.seat])
        return Scored(again, None, answer)

    def _qualities(self, results: list[Result]) -> dict[str, float]:
        """The mean of each of the task's qualities over the correct trials that have it."""
        means = {}
        for quality in self._task.qualities:
            kept = [result.details.get(quality.field) for result in results if result.correct]
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

    def amend(self, result: Result | Results, unsaid: Collection[str] = ()) -> Scored | None:
        """Put another result in the place of the last, and score its attempt once more if it has ended.

        That can be done until the next attempt begins, or the level is set by hand. What was said of it stands; those
        at the seats that are ``unsaid`` get another answer. The level stands, as an operator may have ruled on
        it, unless the attempt comes out another way.
        """
        if self._ended is None:
            self.results[-1:] = [result]
            return None
        level, settled, was = self.level, self._difficulty, self._ended
        self.attempt, self.level, self._overridden, self._difficulty = was[:4]
        self._histories = dict(was.histories)
        self._started = next(iter(was.scored.values())).started
        self.results = [*was.results[:-1], result]
        anew = self.score(was.at)
        each = [one if one.ended.seat in unsaid else self._keep_told(one, was) for one in anew.each]
        self._ended.scored.update({one.ended.seat: one.ended for one in each})
        if self._ended.outcome == was.outcome:
            self.level, self._difficulty = level, settled
        self.advance()
        changed = LevelChanged(previous=level, level=self.level, reason="mark") if level != self.level else None
        return each[0]._replace(level=changed, others=tuple(each[1:]))

    def _keep_told(self, anew: Scored, was: _Ended) -> Scored:
        """What is scored anew, with what was said of it before."""
        seat = anew.ended.seat
        told = was.scored[seat]
        if not self.is_practice:
            since = was.histories[seat].since + 1 if told.feedback == "none" else 0
            self._histories[seat] = msgspec.structs.replace(self._histories[seat], since=since)
        return anew._replace(ended=msgspec.structs.replace(anew.ended, feedback=told.feedback, choice=told.choice))

    @property
    def total(self) -> int:
        """How many attempts there are, those for practice included: also the number of the last."""
        return self._task.parameters.practice_attempts + self._task.parameters.attempts

    def advance(self) -> bool:
        """Go on to the next attempt; False if that was the last."""
        if self.attempt == self.total:
            return False
        self.attempt += 1
        self.results = []
        return True

    def set_level(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """Set the level of the next attempt. One that is under way keeps its own, and does not change the next."""
        self._ended = None
        self._overridden = True
        return self._put(level, "operator", under_way=under_way)

    def hold(self, change: LevelChanged) -> None:
        """A change that followed from the last attempt does not happen, or not yet: the level stays as it was."""
        self._held = change
        self._difficulty = difficulty.Difficulty(change.previous)
        self.level = change.previous

    def settle(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """A change that was held happens after all, to ``level``; an attempt that is under way keeps its own."""
        held = self._held
        reason = held.reason if held and held.level == level else "operator"
        return self._put(level, reason, under_way=under_way)

    def _put(self, level: int, reason: str, *, under_way: bool) -> LevelChanged | None:
        parameters = self._task.parameters
        highest = min(parameters.max_level, self._task.levels)
        before = self._difficulty.level
        self._difficulty = difficulty.Difficulty(max(parameters.min_level, min(level, highest)))
        if not under_way:
            self.level = self._difficulty.level
        return self._change(before, reason)

    def _change(self, before: int, reason: str) -> LevelChanged | None:
        after = self._difficulty.level
        return LevelChanged(previous=before, level=after, reason=reason) if after != before else None
