"""Text of feedback on an attempt: results and performance, in words and in figures."""

from typing import NamedTuple, Protocol

from sar_tui.loop.feedback_comparison import (
    QualityChange,
    attempts_before,
    comparable_attempts,
    judge_result,
    quality_changes,
    quality_evidence,
    result_evidence,
    worst_decline,
)
from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Degree, Feedback, Form, RecalledAttempts, Valence
from sar_tui.model.results_for_people import decimals_for, difference_text, goal_text, result_text
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Quality
from sar_tui.rules.judgement import RACED

_VOCABULARY = {
    "last attempt": "last_attempt",
    "best attempt": "best_attempt",
    "session's mean": "session_mean",
    "goal": "goal",
}


class Wordings(Protocol):
    """Source of wordings: returns one for a situation, with its slots filled."""

    def __call__(self, situation: str, **slots: str) -> str: ...

    def beside(self, text: str, situation: str, **slots: str) -> str:
        """Return a wording for a situation that repeats little of ``text``, which is said with
        it.
        """
        ...

    def vocabulary(self, name: str) -> str:
        """Return a word of the theme's vocabulary."""
        ...


class WrittenFeedback(NamedTuple):
    """Text of feedback, and the valence and degree that choose its face and gesture.

    ``evidence``: the changes that the text reports, each beside its MDC95; not for the participant.
    """

    text: str
    valence: Valence
    degree: Degree
    evidence: str = ""


class _Pair(NamedTuple):
    """A sentence in words, and its equivalent in figures."""

    words: str
    figures: str


class _PerformanceText(NamedTuple):
    """Knowledge of performance in words and in figures, its valence, and the change that it
    reports.
    """

    words: str
    figures: str
    valence: Valence
    evidence: str = ""

    def text(self, form: Form) -> str:
        """Return the sentence in a form; the figures include the words."""
        return self.words if form == "qualitative" else self.figures


class FeedbackText:
    """Writes the text of feedback.

    Args:
        task: has the metric and the qualities.
        word: returns a wording for a situation.
    """

    def __init__(self, task: Task, word: Wordings) -> None:
        self._task = task
        self._word = word

    def write(self, feedback: Feedback, recalled: RecalledAttempts) -> WrittenFeedback:
        """Return the text of feedback, with the form and content of its choice, and the task's
        correction after it.
        """
        written = self._written(feedback, recalled)
        is_said = not feedback.correction or feedback.correction in written.text
        return (
            written if is_said else written._replace(text=f"{written.text} {feedback.correction}")
        )

    def _written(self, feedback: Feedback, recalled: RecalledAttempts) -> WrittenFeedback:
        choice = feedback.choice
        if choice.attempts > 1:
            summary = self._in_form(self._summary(feedback), choice.form)
            return WrittenFeedback(summary, feedback.valence, choice.degree)
        failed = feedback.reason in ("accuracy", "empty")
        performance = (
            self._performance(feedback, recalled)
            if choice.content != "results" and not failed
            else None
        )
        if performance and choice.content == "performance":
            degree: Degree = "clear" if performance.valence == "positive" else "slight"
            return WrittenFeedback(
                performance.text(choice.form), performance.valence, degree, performance.evidence
            )
        results = self._results(feedback, recalled)
        if failed and feedback.remark:
            results = _Pair(feedback.remark, results.figures)
        elif failed and feedback.advice:
            results = _Pair(self._word("unanswered", advice=feedback.advice), results.figures)
        is_advice = failed and feedback.advice and not feedback.remark and choice.form == "both"
        # a count of misses would sound like a reproach
        form: Form = "qualitative" if is_advice else choice.form
        texts = [
            self._in_form(results, form),
            *([performance.text(choice.form)] if performance else []),
        ]
        evidence = [self._evidence(feedback, recalled), performance.evidence if performance else ""]
        return WrittenFeedback(
            " ".join(texts), feedback.valence, choice.degree, "; ".join(filter(None, evidence))
        )

    def _in_form(self, pair: "_Pair", form: Form) -> str:
        """Return the words, the figures or both."""
        return {
            "qualitative": pair.words,
            "quantitative": pair.figures,
            "both": f"{pair.words} {pair.figures}",
        }[form]

    # --- knowledge of results

    def _results(self, feedback: Feedback, recalled: RecalledAttempts) -> "_Pair":
        is_reason = feedback.reason in ("accuracy", "empty", *RACED)
        situation = feedback.reason if is_reason else _graded(feedback)
        figures = self._figures(feedback, recalled)
        beside = figures if feedback.choice.form == "both" else ""
        return _Pair(self._word.beside(beside, situation), figures)

    def _figures(self, feedback: Feedback, recalled: RecalledAttempts) -> str:
        """Compare with the chosen reference; without one, or if the change may be chance, give
        result and goal.
        """
        if feedback.reason in RACED:
            return self._word(
                "race_figures", reached=str(feedback.won), trials=str(feedback.trials)
            )
        if feedback.reason in ("accuracy", "empty") or feedback.metric is None:
            situation = "empty" if feedback.reason == "empty" else "accuracy"
            return self._word(
                f"{situation}_figures", correct=str(feedback.correct), trials=str(feedback.trials)
            )
        tr, metric = self._task.tr, self._task.metric
        decimals = decimals_for(metric, feedback.metric, feedback.goal)
        slots = _value_and_goal(self._task, feedback.metric, feedback.goal)
        before = self._reference(feedback, recalled)
        if before is None:
            return self._word(f"{feedback.valence}_first", **slots)
        reference = self._reference_name(feedback, recalled)
        difference = difference_text(metric, feedback.metric, before, tr, decimals)
        if not difference:
            return self._word(f"{feedback.valence}_same", **slots, reference=reference)
        if not self._is_real(feedback, recalled, before):
            return self._word(f"{feedback.valence}_first", **slots)
        improved = metric.is_better(feedback.metric, before)
        return self._word(
            f"{feedback.valence}_{'improved' if improved else 'worsened'}",
            **slots,
            difference=difference,
            change=tr(metric.improved if improved else metric.worsened),
            reference=reference,
        )

    def _is_real(self, feedback: Feedback, recalled: RecalledAttempts, before: float) -> bool:
        """Return True if a difference may be reported: from the goal always, from other attempts if
        it is no chance.
        """
        if feedback.choice.compared_with == "goal":
            return True
        change = judge_result(self._task, feedback, recalled, before)
        return change is not None and change.verdict != "chance"

    def _evidence(self, feedback: Feedback, recalled: RecalledAttempts) -> str:
        """Return the change of the result that the figures report; empty if they report none."""
        choice, before = feedback.choice, self._reference(feedback, recalled)
        is_told = choice.form != "qualitative" and choice.compared_with != "goal"
        is_told &= feedback.reason not in ("accuracy", "empty", *RACED)
        if not is_told or before is None:
            return ""
        change = judge_result(self._task, feedback, recalled, before)
        return (
            result_evidence(self._task.metric, change)
            if change and change.verdict != "chance"
            else ""
        )

    def _reference_name(self, feedback: Feedback, recalled: RecalledAttempts) -> str:
        """Return the name of the reference: "last at this level" if the last attempt was at another
        level.
        """
        name = _VOCABULARY[feedback.choice.compared_with]
        if name == "last_attempt" and feedback.attempt - 1 not in {
            attempt.attempt for attempt in recalled.attempts if attempt.metric is not None
        }:
            name = "last_at_level"
        return self._word.vocabulary(name)

    def _reference(self, feedback: Feedback, recalled: RecalledAttempts) -> float | None:
        """Return the value that the result is compared with: from the same level, or the goal."""
        if feedback.choice.compared_with == "goal":
            return feedback.goal
        earlier = [
            attempt for attempt in attempts_before(feedback, recalled) if attempt.metric is not None
        ]
        before = [attempt.metric for attempt in earlier if attempt.metric is not None]
        if feedback.choice.compared_with == "best attempt":
            enough = self._task.parameters.min_accuracy
            accurate = [
                a.metric
                for a in earlier
                if a.metric is not None and (a.accuracy is None or a.accuracy >= enough)
            ]
            known = [
                *accurate,
                *([recalled.earlier_best] if recalled.earlier_best is not None else []),
            ]
            best = min if self._task.metric.better == "lower" else max
            return best(known) if known else None
        if feedback.choice.compared_with == "last attempt":
            return before[-1] if before else None
        return sum(before) / len(before) if before else None

    def _summary(self, feedback: Feedback) -> "_Pair":
        counts = {"reached": str(feedback.reached), "attempts": str(feedback.choice.attempts)}
        if feedback.metric is None:
            figures = self._word("summary_empty_figures", **counts)
        else:
            figures = self._word(
                "summary_figures",
                **counts,
                **_value_and_goal(self._task, feedback.metric, feedback.goal),
            )
        beside = figures if feedback.choice.form == "both" else ""
        return _Pair(self._word.beside(beside, f"summary_{feedback.valence}"), figures)

    # --- knowledge of performance

    def _performance(
        self, feedback: Feedback, recalled: RecalledAttempts
    ) -> "_PerformanceText | None":
        """Return what got worse beyond the person's noise, else what improved since the last
        comparable attempt.

        The task's own correction takes the place of what got worse. None if nothing changed:
        feedback is then on the result.
        """
        found = self._change(feedback, recalled)
        if found and feedback.correction and found.valence != "positive":
            return found._replace(words=feedback.correction, figures=feedback.correction)
        return found

    def _change(self, feedback: Feedback, recalled: RecalledAttempts) -> "_PerformanceText | None":
        """Return what got worse or improved, if it is more than the person's noise.

        Comparable attempts have the same level and nearly the same result: the qualities depend on
        speed.
        """
        if feedback.metric is None:
            return None
        tr = self._task.tr
        worst = worst_decline(self._task, feedback, recalled)
        if worst:
            words = {
                "aim": tr(worst.quality.aim),
                "reference": self._word.vocabulary("session_mean"),
            }
            share = abs(worst.decline.by / worst.decline.usual) if worst.decline.usual else None
            text = self._performance_text(
                feedback, recalled, "negative", "performance_worsened", words, share
            )
            return text._replace(evidence=quality_evidence(*worst))
        before = next(reversed(comparable_attempts(feedback, recalled)), None)
        changes = quality_changes(self._task, feedback, recalled, before) if before else []
        best = max(
            (each for each in changes if each.is_real), key=lambda change: change.size, default=None
        )
        if before is None or best is None or best.size <= 0:
            return None
        words = {"change": tr(best.quality.improved), "reference": self._last(feedback, before)}
        share = _share(best.quality, feedback, before)
        text = self._performance_text(
            feedback, recalled, "positive", "performance_improved", words, share
        )
        return text._replace(evidence=_evidence_of(best))

    def _last(self, feedback: Feedback, before: AttemptEnded) -> str:
        """Return the words for the attempt that is compared with."""
        latest = before.attempt == feedback.attempt - 1
        return self._word.vocabulary("last_attempt" if latest else "last_at_level")

    def _performance_text(
        self,
        feedback: Feedback,
        recalled: RecalledAttempts,
        valence: Valence,
        situation: str,
        words: dict[str, str],
        share: float | None = None,
    ) -> "_PerformanceText":
        """Return the text in words and in figures: the change as a percentage up to 100 %, else the
        result.
        """
        said = self._word(situation, **words)
        if share is not None and share <= 1:
            figures = self._word(f"{situation}_figures", **words, percent=f"{100 * share:.0f} %")
        elif feedback.choice.content == "both":  # the results give the figures already
            figures = said
        else:
            figures = f"{said} {self._figures(feedback, recalled)}"
        return _PerformanceText(said, figures, valence)


def result_phrases(feedback: Feedback, task: Task, theme: Theme) -> tuple[str, ...]:
    """Return the phrases of a theme that tell the result of an attempt, and at most whether it
    reached its goal. Empty without a result.
    """
    if feedback.metric is None:
        return ()
    slots = _value_and_goal(task, feedback.metric, feedback.goal)
    return tuple(wording.format(**slots) for wording in theme.phrases[f"{feedback.valence}_first"])


def _value_and_goal(task: Task, value: float, goal: float) -> dict[str, str]:
    metric, tr = task.metric, task.tr
    shown = result_text(metric, value, tr, decimals_for(metric, value, goal))
    return {"value": shown, "goal": goal_text(metric, goal, tr)}


def _graded(feedback: Feedback) -> str:
    """Return the situation of a result, by its distance from the goal."""
    degree = feedback.choice.degree
    return (
        feedback.valence
        if feedback.valence == "neutral" or degree == "clear"
        else f"{feedback.valence}_{degree}"
    )


def _evidence_of(change: QualityChange) -> str:
    return quality_evidence(change.quality, change.judged) if change.judged else ""


def _share(quality: Quality, feedback: Feedback, before: AttemptEnded) -> float | None:
    """Return the relative change of a quality; None if it was 0 before."""
    now, then = feedback.qualities[quality.field], before.qualities[quality.field]
    return abs(now - then) / abs(then) if then else None
