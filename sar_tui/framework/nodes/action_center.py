"""The Action Center: decides how the agent says what is due (thesis 3.2.4)."""

import math

from sar_tui.framework.chance import Chance
from sar_tui.framework.messages import (
    AttemptEnded,
    Feedback,
    Proposal,
    Recall,
    SessionEnded,
    SessionStarted,
    Valence,
)
from sar_tui.framework.node import Node, on
from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme, face_for
from sar_tui.framework.topics import FEEDBACK, PROPOSED, RECALL, SESSION, SESSION_ENDED

ALIKE = 0.2
"""Results that differ by no more than this share are near enough for the ways they came about to be compared."""


class ActionCenter(Node):
    """Turns a feedback event into words and a face, after the form the Task Base asks for."""

    name = "action_center"
    emits = (PROPOSED,)
    asks = (RECALL,)

    def __init__(self, task: Task, theme: Theme, seed: int) -> None:
        super().__init__()
        self._task = task
        self._theme = theme
        self._chance = Chance(seed)
        self._count = 0
        self._last_wording: dict[str, str] = {}

    @on(SESSION)
    def greet(self, _: SessionStarted) -> None:
        self._propose("greeting", self._word("greeting"))

    @on(SESSION_ENDED)
    def say_goodbye(self, _: SessionEnded) -> None:
        self._propose("goodbye", self._word("goodbye"))

    @on(FEEDBACK)
    def answer(self, feedback: Feedback) -> None:
        form, about = self._task.parameters.feedback_form, self._task.feedback_on
        performance = self._performance(feedback) if about != "results" else ""
        failed = feedback.reason in ("accuracy", "empty")
        words = []
        if failed and feedback.remark:
            words.append(feedback.remark)
        elif not (performance and about == "performance"):
            words += [self._qualitative(feedback)] if form != "quantitative" else []
            words += [self._quantitative(feedback)] if form != "qualitative" else []
        words += [performance] if performance and not failed else []
        self._propose("feedback", " ".join(words), feedback.valence, feedback.attempt)

    def _qualitative(self, feedback: Feedback) -> str:
        situation = feedback.reason if feedback.reason in ("accuracy", "empty") else feedback.valence
        return self._word(situation)

    def _quantitative(self, feedback: Feedback) -> str:
        """Compare with the last attempt at that level; where there is none, give the result and the goal."""
        if feedback.reason in ("accuracy", "empty") or feedback.metric is None:
            situation = "empty" if feedback.reason == "empty" else "accuracy"
            return self._word(f"{situation}_figures", correct=str(feedback.correct), trials=str(feedback.trials))
        metric = self._task.metric
        value, goal = metric.show(feedback.metric), metric.show(feedback.goal)
        before = self._last(feedback)
        if before is None or before.metric is None:
            return self._word(f"{feedback.valence}_first", value=value, goal=goal)
        difference = metric.show(abs(feedback.metric - before.metric))
        if difference == metric.show(0):
            return self._word(f"{feedback.valence}_same", value=value, goal=goal)
        improved = metric.is_better(feedback.metric, before.metric)
        return self._word(
            f"{feedback.valence}_{'improved' if improved else 'worsened'}",
            value=value,
            goal=goal,
            difference=difference,
            change=metric.improved if improved else metric.worsened,
        )

    def _performance(self, feedback: Feedback) -> str:
        """What was better about *how* it was done than the last time it was done alike; else what to heed next.

        Alike is at the same level, and with nearly the same result: a slower movement has more of everything. Empty
        where nothing was measured.
        """
        measured = [quality for quality in self._task.qualities if quality.field in feedback.qualities]
        if not measured:
            return ""
        before = self._last(feedback, alike=True)
        changes = [
            (quality.change(feedback.qualities[quality.field], before.qualities[quality.field]), quality)
            for quality in measured
            if before and quality.field in before.qualities
        ]
        aim = self._chance.choice([quality.aim for quality in measured], "aim", self._count)
        if not changes:
            return self._word("performance_first", aim=aim)
        best, worst = max(changes, key=lambda change: change[0]), min(changes, key=lambda change: change[0])
        if best[0] >= 1:
            return self._word("performance_improved", change=best[1].improved)
        if worst[0] <= -1:
            return self._word("performance_worsened", aim=worst[1].aim)
        return self._word("performance_same", aim=aim)

    def _last(self, feedback: Feedback, *, alike: bool = False) -> AttemptEnded | None:
        """The last attempt before at that level that has a result; one alike, if asked for."""
        recalled = self.ask(RECALL, Recall(seat=feedback.seat, level=feedback.level)).attempts
        reach = math.inf if not alike or feedback.metric is None else ALIKE * abs(feedback.metric)
        return next(
            (
                attempt
                for attempt in reversed(recalled)
                if attempt.attempt < feedback.attempt
                and attempt.metric is not None
                and (feedback.metric is None or abs(attempt.metric - feedback.metric) <= reach)
            ),
            None,
        )

    def _word(self, situation: str, **slots: str) -> str:
        """A wording for a situation, not the same twice running, its slots filled."""
        wordings = self._theme.phrases[situation]
        fresh = [w for w in wordings if w != self._last_wording.get(situation)] or list(wordings)
        wording = self._chance.choice(fresh, "wording", situation, self._count)
        self._last_wording[situation] = wording
        return wording.format(**slots)

    def _propose(self, kind: str, text: str, valence: Valence | None = None, attempt: int = 0) -> None:
        self._count += 1
        self.emit(
            PROPOSED,
            Proposal(
                id=f"a{self._count}",
                kind=kind,  # type: ignore[arg-type]
                text=text,
                face=face_for(valence),
                valence=valence,
                attempt=attempt,
            ),
        )
