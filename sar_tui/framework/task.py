"""The contract of a task: one class that declares itself once, and judges what a person did.

A task is a pure description. It keeps no state between calls: what it needs is handed to it, so that a trial
can be repeated, resumed and replayed. The framework runs it: waits, shows, stamps, scores, adapts, answers.
"""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal

from sar_tui.framework.language import language
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.random_streams import RandomStreams
from sar_tui.framework.trial_types import (
    Act,
    Again,
    Details,
    Mark,
    Metric,
    Performance,
    Quality,
    Result,
    Results,
    Score,
    Situation,
    Stimulus,
    Target,
    Trial,
)

_FRAMEWORK = Path(__file__).parent


"""Where the translations of the framework's own words are."""


class Task(ABC):
    """A motor task.

    ``tr`` translates what people read into the session's language: ``self.tr("Reach {far} far.", far="15 cm")``. The
    translations stand beside the task in ``words.<language>.toml``, and cover what it declares too (``title``, marks).

    Subclass it in ``tasks/NAME/task.py``: declare the class variables, and say how a prompt is made
    (``stimulus``) and what a percept means (``perceived``). The rest has defaults.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    summary: ClassVar[str] = ""
    trials: ClassVar[str] = "Prompts"
    version: ClassVar[str] = "1"
    metric: ClassVar[Metric]
    Parameters: ClassVar[type[TaskParameters]] = TaskParameters
    Details: ClassVar[type[Details]] = Details
    sensors: ClassVar[tuple[Literal["imu"], ...]] = ()
    qualities: ClassVar[tuple[Quality, ...]] = ()
    marks: ClassVar[tuple[Mark, ...]] = ()
    seats: ClassVar[tuple[str, ...]] = ("A",)

    @classmethod
    def sensed(cls, parameters: TaskParameters) -> tuple[str, ...]:
        """The seats that wear a sensor, as the task is set: all of them, in a task that has ``sensors``."""
        return cls.seats if cls.sensors else ()

    def __init__(self, parameters: TaskParameters) -> None:
        self.parameters = parameters
        self.names: dict[str, str] = {}
        self.tr = language(parameters.language, _FRAMEWORK, Path(inspect.getfile(type(self))).parent)

    @property
    def levels(self) -> int:
        """How many levels there are."""
        return self.parameters.max_level

    @property
    def trials_per_attempt(self) -> int:
        """How many prompts an attempt has."""
        return 1

    @property
    def start_key(self) -> str:
        """The key with which the participant starts each trial; empty where trials come by themselves."""
        return ""

    @property
    def has_foreperiod(self) -> bool:
        """Whether a prompt is preceded by a random wait."""
        return True

    @property
    def feedback_on(self) -> Literal["results", "performance", "both"]:
        """What the agent answers: how well the goal was met, how it was done (the ``qualities``), or both."""
        return "results"

    @property
    def address(self) -> Literal["seat", "code"]:
        """How the agent calls the participants of a task with several seats: by their seat, or by their code."""
        return "seat"

    def seat_of(self, key: str) -> str:
        """Whose a key is, in a task with several seats; empty for nobody's, which is never a response."""
        return ""

    def seat_name(self, seat: str) -> str:
        """What a seat is called, in a task with several."""
        return self.tr({"A": "Left", "B": "Right"}.get(seat, seat))

    def called(self, seat: str) -> str:
        """What who sits there is called: as the recorded beginning of the session has it, else as the seat is."""
        return self.names.get(seat) or self.seat_name(seat)

    def nodes(self) -> tuple[Node, ...]:
        """More perception: nodes that make percepts of what its sensors tell. New ones at each call."""
        return ()

    def target(self, level: int) -> Target:
        """What an attempt at a level is held against."""
        return Target(self.parameters.threshold, self.parameters.neutral_band)

    @abstractmethod
    def instructions(self) -> str:
        """What to do, in the participant's words."""

    def goal(self, level: int) -> str:
        """The goal of an attempt, in the participant's words."""
        goal = self.metric.show(self.target(level).threshold)
        needed = f"{self.parameters.min_accuracy:.0%}" if self.parameters.min_accuracy else ""
        match self.metric.better, bool(needed):
            case "lower", True:
                return self.tr("Your goal: less than {goal}, with at least {needed} right.", goal=goal, needed=needed)
            case "lower", False:
                return self.tr("Your goal: less than {goal}.", goal=goal)
            case _, True:
                return self.tr("Your goal: more than {goal}, with at least {needed} right.", goal=goal, needed=needed)
        return self.tr("Your goal: more than {goal}.", goal=goal)

    def notice(self, level: int, before: int) -> str:
        """What the participant has to know when the level is another than before; empty where nothing."""
        return ""

    def start(self, level: int) -> str:
        """What the participant has to heed before starting a trial, where there is a ``start_key``."""
        return self.tr("Start when you are ready.")

    @abstractmethod
    def stimulus(self, situation: Situation) -> Stimulus:
        """What to show. Must depend on ``situation`` and the parameters alone."""

    @abstractmethod
    def perceived(self, trial: Trial, percept: Any) -> Result | Results | Again | None:
        """Judge a percept that came while the prompt is up; None to go on waiting.

        ``trial.percepts`` holds the earlier ones of this trial, so that a task need not remember them. Where several
        take part, each percept has its seat, and the trial is over for all of them at once: with a result for each, or
        one that is everybody's.
        """

    def timed_out(self, trial: Trial) -> Result | Results:
        """Judge a trial whose time is over. A miss, unless the task says otherwise."""
        return Result(correct=False)

    def score(self, results: Sequence[Result]) -> Score:
        """Score an attempt: the mean of the values of correct trials, and the share of correct ones."""
        values = [result.value for result in results if result.counts and result.value is not None]
        correct = sum(result.correct for result in results)
        return Score(
            metric=sum(values) / len(values) if values else None,
            accuracy=correct / len(results),
            correct=correct,
            trials=len(results),
        )

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """What else there is to tell of an attempt, by name: kept with its qualities."""
        return {}

    def rehearse(self, stimulus: Stimulus, performance: Performance, streams: RandomStreams) -> list[Act]:
        """What a simulated participant does for a prompt: (ms after onset, key or movement).

        Args:
            stimulus: what is shown; ``seat`` is that of this person.
            performance: how this person does it this time.
            chance: for whatever else is random.

        A task whose response is more than one key overrides this; a stimulus that is shown and answered by one
        key needs nothing.
        """
        return [(performance.reaction_ms, "wrong" if performance.slips else stimulus.expected)]
