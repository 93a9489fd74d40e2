"""The words of an answer to an attempt: results and performance, in words and in figures."""

import math
from collections.abc import Sequence
from typing import Protocol

from sar_tui.framework.messages import AttemptEnded, Attempts, Feedback
from sar_tui.framework.task import Quality, Task

ALIKE = 0.2
"""Results that differ by no more than this share are near enough for the ways they came about to be compared."""
_VOCABULARY = {
    "last attempt": "last_attempt",
    "best attempt": "best_attempt",
    "session's mean": "session_mean",
    "goal": "goal",
}


class Wordings(Protocol):
    """Where wordings come from: one for a situation, its slots filled."""

    def __call__(self, situation: str, **slots: str) -> str: ...

    def choose(self, choices: Sequence[str]) -> str:
        """One of some texts, at random."""
        ...

    def call(self, name: str) -> str:
        """A word of the theme's vocabulary."""
        ...


class Answers:
    """Puts an answer into words.

    Args:
        task: whose metric and qualities are spoken of.
        word: makes a wording for a situation.
    """

    def __init__(self, task: Task, word: Wordings) -> None:
        self._task = task
        self._word = word

    def words(self, feedback: Feedback, recalled: Attempts) -> str:
        """What there is to say, in the form and about what the choice says."""
        choice = feedback.choice
        if choice.attempts > 1:
            return self._join(self._summary(feedback), feedback)
        failed = feedback.reason in ("accuracy", "empty")
        performance = self._performance(feedback, recalled) if choice.content != "results" and not failed else []
        if performance and choice.content == "performance":
            return self._join(performance, feedback)
        results = self._results(feedback, recalled)
        if failed and feedback.remark:
            results = [feedback.remark, results[1]]
        return self._join(results, feedback, performance)

    def _join(self, told: list[str], feedback: Feedback, more: Sequence[str] = ()) -> str:
        """Words and figures as the form wants them. Each is a pair: in words, in figures."""
        pick = {"qualitative": slice(0, 1), "quantitative": slice(1, 2), "both": slice(0, 2)}[feedback.choice.form]
        figures = slice(1, 2) if feedback.choice.form != "qualitative" else slice(0, 1)
        return " ".join(filter(None, [*told[pick], *more[figures]]))

    # --- knowledge of results ------------------------------------------------------------------------------

    def _results(self, feedback: Feedback, recalled: Attempts) -> list[str]:
        situation = feedback.reason if feedback.reason in ("accuracy", "empty") else _graded(feedback)
        return [self._word(situation), self._figures(feedback, recalled)]

    def _figures(self, feedback: Feedback, recalled: Attempts) -> str:
        """Compare with what is asked for; where there is nothing to compare with, give the result and the goal."""
        if feedback.reason in ("accuracy", "empty") or feedback.metric is None:
            situation = "empty" if feedback.reason == "empty" else "accuracy"
            return self._word(f"{situation}_figures", correct=str(feedback.correct), trials=str(feedback.trials))
        value, goal = self._show(feedback.metric), self._show(feedback.goal)
        before = self._reference(feedback, recalled)
        if before is None:
            return self._word(f"{feedback.valence}_first", value=value, goal=goal)
        metric, reference = self._task.metric, self._word.call(_VOCABULARY[feedback.choice.compared_with])
        difference = self._show(abs(feedback.metric - before))
        if difference == self._show(0):
            return self._word(f"{feedback.valence}_same", value=value, goal=goal, reference=reference)
        improved = metric.is_better(feedback.metric, before)
        return self._word(
            f"{feedback.valence}_{'improved' if improved else 'worsened'}",
            value=value,
            goal=goal,
            difference=difference,
            change=self._task.tr(metric.improved if improved else metric.worsened),
            reference=reference,
        )

    def _reference(self, feedback: Feedback, recalled: Attempts) -> float | None:
        """What the result is held against: at the same level, but for the goal."""
        if feedback.choice.compared_with == "goal":
            return feedback.goal
        earlier = [attempt for attempt in _before(feedback, recalled) if attempt.metric is not None]
        before = [attempt.metric for attempt in earlier if attempt.metric is not None]
        if feedback.choice.compared_with == "best attempt":
            enough = self._task.parameters.min_accuracy
            accurate = [
                a.metric for a in earlier if a.metric is not None and (a.accuracy is None or a.accuracy >= enough)
            ]
            known = [*accurate, *([recalled.earlier_best] if recalled.earlier_best is not None else [])]
            best = min if self._task.metric.better == "lower" else max
            return best(known) if known else None
        if feedback.choice.compared_with == "last attempt":
            return before[-1] if before else None
        return sum(before) / len(before) if before else None

    def _summary(self, feedback: Feedback) -> list[str]:
        counts = {"reached": str(feedback.reached), "attempts": str(feedback.choice.attempts)}
        if feedback.metric is None:
            figures = self._word("summary_empty_figures", **counts)
        else:
            shown = {"value": self._show(feedback.metric), "goal": self._show(feedback.goal)}
            figures = self._word("summary_figures", **counts, **shown)
        return [self._word(f"summary_{feedback.valence}"), figures]

    def _show(self, value: float) -> str:
        return self._task.tr.figures(self._task.metric.show(value))

    # --- knowledge of performance --------------------------------------------------------------------------

    def _performance(self, feedback: Feedback, recalled: Attempts) -> list[str]:
        """What was better about *how* it was done than when it was last done alike; else what to heed next.

        Alike is at the same level, and with nearly the same result: a slower movement has more of everything. Empty
        where nothing was measured.
        """
        measured = [quality for quality in self._task.qualities if quality.field in feedback.qualities]
        if not measured or feedback.metric is None:
            return []
        tr, aims = self._task.tr, self._word.choose([quality.aim for quality in measured])
        before = _alike(feedback, recalled)
        changes = [
            (quality.change(feedback.qualities[quality.field], before.qualities[quality.field]), quality)
            for quality in measured
            if before and quality.field in before.qualities
        ]
        if not changes or before is None:
            if feedback.choice.content == "both":  # the results have told the figures already
                return [self._word("performance_first", aim=tr(aims))] * 2
            shown = {"value": self._show(feedback.metric), "goal": self._show(feedback.goal)}
            return self._both("performance_first", {"aim": tr(aims)}, shown)
        reference = {"reference": self._word.call("last_attempt")}
        best, worst = max(changes, key=lambda change: change[0]), min(changes, key=lambda change: change[0])
        if best[0] >= 1:
            words = {"change": tr(best[1].improved), **reference}
            return self._both("performance_improved", words, _percent(best[1], feedback, before))
        if worst[0] <= -1:
            words = {"aim": tr(worst[1].aim), **reference}
            return self._both("performance_worsened", words, _percent(worst[1], feedback, before))
        words = {"aim": tr(aims), **reference}
        return self._both("performance_same", words, _percent(worst[1], feedback, before))

    def _both(self, situation: str, words: dict[str, str], figures: dict[str, str]) -> list[str]:
        return [self._word(situation, **words), self._word(f"{situation}_figures", **words, **figures)]


def _graded(feedback: Feedback) -> str:
    """The situation of a result, by how far it lies from its goal."""
    degree = feedback.choice.degree
    return feedback.valence if feedback.valence == "neutral" or degree == "clear" else f"{feedback.valence}_{degree}"


def _before(feedback: Feedback, recalled: Attempts) -> list[AttemptEnded]:
    return [attempt for attempt in recalled.attempts if attempt.attempt < feedback.attempt]


def _alike(feedback: Feedback, recalled: Attempts) -> AttemptEnded | None:
    reach = math.inf if feedback.metric is None else ALIKE * abs(feedback.metric)
    return next(
        (
            attempt
            for attempt in reversed(_before(feedback, recalled))
            if attempt.metric is not None and abs(attempt.metric - (feedback.metric or 0.0)) <= reach
        ),
        None,
    )


def _percent(quality: Quality, feedback: Feedback, before: AttemptEnded) -> dict[str, str]:
    """How much a quality has changed, as a share of what it was."""
    now, then = feedback.qualities[quality.field], before.qualities[quality.field]
    share = abs(now - then) / abs(then) if then else float(now != then)
    return {"percent": f"{100 * share:.0f} %"}
