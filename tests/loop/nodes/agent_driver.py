"""Drives memory and action center with scored attempts; and a theme whose phrases spell out their
keys and slots.
"""

import re
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.nodes.action_center import ActionCenter
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.phrase_keys import PHRASE_KEYS
from sar_tui.loop.task import Task
from sar_tui.loop.topics import ATTEMPT_ENDED, FEEDBACK, PROPOSED, SESSION
from sar_tui.model.messages import AttemptEnded, Feedback, Message, Proposal, SessionStarted, Spread
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Score
from sar_tui.rules import feedback_choice, judgement
from sar_tui.rules.feedback import History
from sar_tui.rules.parameters import build


class Done(Message, frozen=True, kw_only=True):
    """An attempt that has just ended. ``sums_up``: number of attempts that the feedback
    summarises.
    """

    attempt: int
    level: int
    metric: float | None
    correct: int = 20
    trials: int = 20
    practice: bool = False
    qualities: dict[str, float] = {}
    spreads: dict[str, Spread] = {}
    remark: str = ""
    advice: str = ""
    sums_up: int = 1
    reached: int = 0
    condition: str = ""


DONE = Topic("test/done", Done, origin="input")


class Judge(Node):
    """Stub of the event handler: publishes the attempt, then the feedback on it."""

    name = "judge"
    emits = (ATTEMPT_ENDED, FEEDBACK)

    def __init__(self, task: Task) -> None:
        super().__init__()
        self.task = task

    @on(DONE)
    def done(self, done: Done) -> None:
        accuracy = done.correct / done.trials
        score = Score(done.metric, accuracy, done.correct, done.trials)
        target = self.task.target(done.level)
        verdict = judgement.judge(score, self.task.metric, target, 0.0 if done.sums_up > 1 else 0.8)
        judged = judgement.JudgedAttempt(score, target, verdict)
        choice = feedback_choice.choose(
            History(since=1), judged, self.task.parameters, self.task.feedback_on
        )
        choice = msgspec.structs.replace(choice, attempts=done.sums_up)
        facts: dict[str, Any] = {
            "attempt": done.attempt,
            "level": done.level,
            "metric": done.metric,
            "accuracy": accuracy,
            "correct": done.correct,
            "trials": done.trials,
            "qualities": done.qualities,
            "choice": choice,
            "goal": target.threshold,
            "condition": done.condition,
        }
        self.emit(
            ATTEMPT_ENDED,
            AttemptEnded(
                **facts,
                practice=done.practice,
                spreads=done.spreads,
                metric_unit=self.task.metric.unit,
                outcome=verdict.outcome,
                feedback=verdict.valence,
                started=0,
                ended=0,
            ),
        )
        message = Feedback(
            **facts,
            valence=verdict.valence,
            reason=verdict.reason,
            remark=done.remark,
            advice=done.advice,
            reached=done.reached,
        )
        self.emit(FEEDBACK, message)


class Agent:
    """Memory and action center that receive one attempt after the other.

    Args:
        task, theme, seed: whose words are said, and which of them.
        form: of the answers.
        best: of earlier sessions, by level.
        parameters: of the task.
    """

    def __init__(
        self,
        task: type[Task],
        theme: Theme,
        form: str = "quantitative",
        seed: int = 1,
        best: dict[str, float] | None = None,
        **parameters: object,
    ) -> None:
        self.task = task(
            build(
                task.Parameters, {"feedback_form": form, "language": theme.language, **parameters}
            )
        )
        self.bus = Bus(VirtualClock())
        self.count = 0
        self.said: list[Proposal] = []
        for node in (Memory(), Judge(self.task), ActionCenter(self.task, theme, seed)):
            node.attach(self.bus)
        self.bus.publish(
            SESSION,
            SessionStarted(run=1, task=task.name, theme=theme.name, seed=seed, best=best or {}),
        )
        self.bus.subscribe(PROPOSED, self.said.append)

    def feedback_on(self, metric: float | None, level: int = 1, **fields: Any) -> str:
        """Publish an attempt and return the feedback text. Keyword arguments: fields of `Done`, and
        qualities.
        """
        self.count += 1
        known = {name: fields.pop(name) for name in list(fields) if name in Done.__struct_fields__}
        self.bus.publish(
            DONE, Done(attempt=self.count, level=level, metric=metric, qualities=fields, **known)
        )
        return self.said[-1].text


class Spelled(NamedTuple):
    """Phrase key of a text, and the values of its slots."""

    situation: str
    slots: dict[str, str]


def spelling(theme: Theme) -> Theme:
    """Return a theme with one phrase per key, which names the key and all its slots: read them with
    ``spelled``.
    """
    phrases = {
        situation: (
            "".join((f"<{situation}", *(f";{slot}={{{slot}}}" for slot in sorted(slots)), ">")),
        )
        for situation, slots in PHRASE_KEYS.items()
    }
    return msgspec.structs.replace(theme, phrases=phrases)


def spelled(said: str) -> list[Spelled]:
    """Return the keys and slots of a text of a ``spelling`` theme."""
    parts = [found.split(";") for found in re.findall(r"<([^<>]*)>", said)]
    return [Spelled(name, dict(slot.split("=", 1) for slot in slots)) for name, *slots in parts]
