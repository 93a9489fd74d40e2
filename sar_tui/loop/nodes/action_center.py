"""The Action Center: decides how the agent says something (thesis 3.2.4)."""

from typing import NamedTuple

from sar_tui.loop.feedback_text import FeedbackText
from sar_tui.loop.node import Node, on
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    FEEDBACK,
    FILLER_DUE,
    PROPOSED,
    RECALL,
    SESSION,
    SESSION_ENDED,
    THEME,
    WAITING,
)
from sar_tui.model.messages import (
    Feedback,
    FillerDue,
    Kind,
    Policy,
    Proposal,
    Recall,
    SessionEnded,
    SessionStarted,
    ThemeApplied,
    Waiting,
)
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.step import spoken
from sar_tui.model.theme import Theme
from sar_tui.rules import repetition as encouragement
from sar_tui.rules.repetition import least_repeating


class _Rule(NamedTuple):
    """Priority and queue policy of a kind of action."""

    priority: int
    policy: Policy


RULES: dict[Kind, _Rule] = {
    "greeting": _Rule(30, "queue"),
    "instruction": _Rule(20, "drop"),
    "feedback": _Rule(40, "interrupt"),
    "encouragement": _Rule(20, "drop"),
    "rest": _Rule(10, "drop"),
    "goodbye": _Rule(10, "queue"),
    "filler": _Rule(45, "drop"),
}
"""Feedback interrupts actions of lower priority, but not a filler. Instructions, encouragement and
reminders of rest are dropped if they are late. The goodbye comes last.
"""


_TOWARDS = {"A": "left", "B": "right"}
"""Side to which the agent looks when it speaks to one of two participants."""


class ActionCenter(Node):
    """Turns events into proposals: text, face and gesture, with a priority."""

    name = "action_center"
    emits = (PROPOSED,)
    asks = (RECALL,)

    def __init__(self, task: Task, theme: Theme, seed: int) -> None:
        super().__init__()
        self._task = task
        self._phrases = _Phrases(theme, RandomStreams(seed))
        self._feedback_text = FeedbackText(task, self._phrases)
        self._instructed = False
        self._asked = 0
        self._considered = (0, 0)
        self._prepared = 0
        self._rested = 0
        self._last_feedback = 0

    @on(THEME)
    def theme_applied(self, applied: ThemeApplied) -> None:
        """Use the theme from here on."""
        self._phrases.theme = applied.theme

    @on(SESSION)
    def greet(self, session: SessionStarted) -> None:
        self._instructed = False
        self._task.names = session.names
        self._propose("greeting", self._to_all("greeting" if session.run == 1 else "welcome_back"))

    @on(SESSION_ENDED)
    def say_goodbye(self, ended: SessionEnded) -> None:
        """Say goodbye; don't wave if the session was aborted, and thank nobody for work who did not
        agree to begin.
        """
        if ended.status == "refused":
            return
        how = "goodbye" if ended.status == "completed" else "goodbye_early"
        self._propose("goodbye", self._to_all(how), how)

    @on(FEEDBACK)
    def feedback_due(self, feedback: Feedback) -> None:
        recalled = self.ask(
            RECALL, Recall(seat=feedback.seat, level=feedback.level, condition=feedback.condition)
        )
        content = self._feedback_text.write(feedback, recalled)
        self._phrases.said(content.text)
        plain = content.valence == "neutral" or content.degree == "clear"
        follows = self._last_feedback == feedback.attempt and feedback.seat != self._task.seats[0]
        self._last_feedback = feedback.attempt
        self._propose(
            "feedback",
            self._to(feedback.seat, content.text),
            content.valence if plain else f"{content.valence}_{content.degree}",
            seat=feedback.seat,
            valence=content.valence,
            degree=content.degree,
            attempt=feedback.attempt,
            due=feedback.due,
            evidence=content.evidence,
            joins=follows,
            policy="queue" if follows else None,
        )

    def _to(self, seat: str, text: str) -> str:
        """Address a participant by name if there are several."""
        if len(self._task.seats) == 1:
            return text
        who = self._task.display_name(seat)
        return self._task.tr("{who}: {words}", who=who, words=text)

    def _to_all(self, situation: str) -> str:
        """Return a phrase for all participants."""
        return self._phrases(situation if len(self._task.seats) == 1 else f"{situation}_both")

    @on(FILLER_DUE)
    def filler_due(self, due: FillerDue) -> None:
        """Propose a filler while feedback is awaited."""
        self._propose("filler", self._phrases("filler"), seat=due.seat)

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        """Propose instructions, and between attempts questions, encouragement or a rest: once for
        each.
        """
        if waiting.stage == "instructions" and not self._instructed:
            self._instructed = True
            self._propose("instruction", "", spoken=self._task.instructions())
        if waiting.step and waiting.step.number != self._asked:
            self._asked = waiting.step.number
            self._propose("instruction", "", spoken=spoken(waiting.step.step))
        if waiting.stage == "rest" and waiting.attempt != self._rested:
            self._rested = waiting.attempt
            self._propose(
                "rest", self._task.tr("Now a rest. Put your hands down for a while."), joins=True
            )
        if waiting.stage == "attempt" and waiting.attempt > 1 and self._is_new(waiting):
            self._considered = (waiting.attempt, waiting.level)
            self._before_attempt(waiting)

    def _is_new(self, waiting: Waiting) -> bool:
        """Return True if nothing is proposed yet for an attempt, and its level was not considered
        before.

        An operator may decide on its level after the session began to wait for it.
        """
        attempt, level = self._considered
        if waiting.attempt == attempt:
            return waiting.level != level and waiting.attempt != self._prepared
        return waiting.attempt > attempt

    def _before_attempt(self, waiting: Waiting) -> None:
        parameters = self._task.parameters
        attempts = self.ask(RECALL, Recall(seat=self._task.seats[0])).attempts
        if waiting.attempt == self._rested:
            self._prepared = waiting.attempt
            self._propose(
                "rest",
                self._task.tr("Start when you are ready."),
                "rested",
                attempt=waiting.attempt,
            )
            return
        if attempts and attempts[-1].attempt < waiting.attempt - 1:
            return  # the last attempt was skipped: nothing has just happened that this could fit
        if encouragement.rest_due(len(attempts), parameters.rest_every):
            kind: Kind = "rest"
            situation = "rest"
        elif parameters.encouragement and (why := encouragement.why_hard(attempts, waiting.level)):
            kind = "encouragement"
            is_new_level = why == "new level"
            situation = "encouragement_new_level" if is_new_level else "encouragement"
        else:
            return
        self._prepared = waiting.attempt
        self._propose(kind, self._to_all(situation), attempt=waiting.attempt, joins=True)

    def _propose(
        self,
        kind: Kind,
        text: str,
        manner: str = "",
        *,
        seat: str = "A",
        spoken: str | None = None,
        valence: str | None = None,
        degree: str | None = None,
        attempt: int = 0,
        due: int = 0,
        evidence: str = "",
        joins: bool = False,
        policy: Policy | None = None,
    ) -> None:
        self._phrases.count += 1
        theme = self._phrases.theme
        how = theme.manner(manner or kind)
        self.emit(
            PROPOSED,
            Proposal(
                seat=seat,
                id=f"a{self._phrases.count}",
                kind=kind,
                text=text,
                spoken=theme.spoken(text if spoken is None else spoken),
                face=how.face,
                gesture=how.gesture,
                gaze=_TOWARDS[seat]
                if kind == "feedback" and len(self._task.seats) > 1
                else how.gaze,
                tone=how.tone,
                valence=valence,  # type: ignore[arg-type]
                degree=degree,  # type: ignore[arg-type]
                attempt=attempt,
                joins=joins,
                priority=RULES[kind].priority,
                policy=policy or RULES[kind].policy,
                due=due,
                evidence=evidence,
            ),
        )


class _Phrases:
    """Phrases of a theme, chosen at random among those that repeat least of what has just been
    said.

    The same wording is never used twice in a row.
    """

    def __init__(self, theme: Theme, streams: RandomStreams) -> None:
        self._feedback = ""
        self.theme = theme
        self.count = 0
        self._streams = streams
        self._last: dict[str, str] = {}

    def __call__(self, situation: str, **slots: str) -> str:
        return self.beside("", situation, **slots)

    def said(self, feedback: str) -> None:
        """Remember the last feedback, which the next should not repeat."""
        self._feedback = feedback

    def beside(self, text: str, situation: str, **slots: str) -> str:
        """Return a wording that repeats little of ``text``, which is said with it, and then of the
        last feedback.
        """
        wordings = self.theme.phrases[situation]
        fresh = [wording for wording in wordings if wording != self._last.get(situation)] or list(
            wordings
        )
        fresh = least_repeating(
            {wording: wording.format(**slots) for wording in fresh}, text, self._feedback
        )
        wording = self._streams.choice(fresh, "wording", situation, self.count)
        self._last[situation] = wording
        return wording.format(**slots)

    def vocabulary(self, name: str) -> str:
        return self.theme.vocabulary[name]
