"""The contract of a task: one class that declares itself once, and judges what a person did.

A task is a pure description. It keeps no state between calls: what it needs is handed to it, so that a trial
can be repeated, resumed and replayed. The framework runs it: waits, shows, stamps, scores, adapts, answers.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import msgspec

from sar_tui.framework.chance import Chance
from sar_tui.framework.clock import MS
from sar_tui.framework.messages import Json
from sar_tui.framework.parameters import TaskParameters


class Metric(msgspec.Struct, frozen=True):
    """What an attempt is measured by.

    ``improved`` and ``worsened`` are the words for a change ("faster", "slower"); ``decimals`` how many are
    shown to people.
    """

    name: str
    unit: str
    better: Literal["lower", "higher"]
    improved: str = "better"
    worsened: str = "worse"
    decimals: int = 0

    @property
    def label(self) -> str:
        """Its name and unit, for people: "reaction time (ms)"."""
        name = self.name.replace("_", " ")
        return f"{name} ({self.unit})" if self.unit else name

    def is_better(self, value: float, than: float) -> bool:
        """Whether ``value`` is strictly better."""
        return value < than if self.better == "lower" else value > than

    def show(self, value: float) -> str:
        """A value with its unit, for people."""
        return f"{value:.{self.decimals}f} {self.unit}".rstrip()


class Situation(msgspec.Struct, frozen=True):
    """Where in a session a prompt stands. ``chance`` belongs to this trial alone, ``session`` to all of them."""

    attempt: int
    trial: int
    level: int
    chance: Chance
    session: Chance


class Stimulus(msgspec.Struct, frozen=True):
    """What a prompt shows.

    Args:
        name: what is stored in ``trials.stimulus``.
        expected: the key that answers it, empty where no single key does.
        text: the plain-text line, one unbroken run of characters: "Press: f".
        glyph: what stands very large on the screen; defaults to ``name``.
        hint: a word of help under it.
        choices: among how many stimuli it was drawn.
    """

    name: str
    expected: str
    text: str
    glyph: str = ""
    hint: str = ""
    choices: int = 1


class Trial(msgspec.Struct, frozen=True):
    """A prompt that is up: what was shown, since when (ns), and what was perceived so far."""

    situation: Situation
    stimulus: Stimulus
    onset: int
    percepts: tuple[Any, ...] = ()

    def latency_ms(self, at: int) -> float:
        """Milliseconds from onset to a stamp."""
        return (at - self.onset) / MS


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """How a trial ended.

    Args:
        correct: whether the response was the right one.
        response: what was done; None for a miss.
        response_at: its stamp in ns; None for a miss.
        value: what the trial adds to the attempt's metric; None where it adds nothing.
        details: more to keep with the trial, as the task's ``Details`` declare.
        flags: marks for ``trials.timing``; the framework adds ``anticipation``.
    """

    correct: bool
    response: str | None = None
    response_at: int | None = None
    value: float | None = None
    details: Json = {}
    flags: tuple[str, ...] = ()

    @property
    def counts(self) -> bool:
        """Whether the trial's value belongs in the metric."""
        return self.correct and self.value is not None and "anticipation" not in self.flags


class Score(msgspec.Struct, frozen=True):
    """An attempt's result. ``accuracy`` is None where a task has none."""

    metric: float | None
    accuracy: float | None
    correct: int
    trials: int


class Details(msgspec.Struct, frozen=True):
    """The base of what a task keeps with each trial: declare the fields, for the data dictionary."""


class Task(ABC):
    """A motor task.

    Subclass it in ``tasks/NAME/task.py``: declare the class variables, and say how a prompt is made
    (``stimulus``) and what a percept means (``perceived``). The rest has defaults.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    summary: ClassVar[str] = ""
    version: ClassVar[str] = "1"
    metric: ClassVar[Metric]
    Parameters: ClassVar[type[TaskParameters]] = TaskParameters
    Details: ClassVar[type[Details]] = Details

    def __init__(self, parameters: TaskParameters) -> None:
        self.parameters = parameters

    @property
    def levels(self) -> int:
        """How many levels there are."""
        return self.parameters.max_level

    @property
    def trials_per_attempt(self) -> int:
        """How many prompts an attempt has."""
        return 1

    @abstractmethod
    def instructions(self) -> str:
        """What to do, in the participant's words."""

    def goal(self, level: int) -> str:
        """The goal of an attempt, in the participant's words."""
        than = "less" if self.metric.better == "lower" else "more"
        goal = f"Your goal: {than} than {self.metric.show(self.parameters.threshold)}"
        needed = self.parameters.min_accuracy
        return f"{goal}, with at least {needed:.0%} right." if needed else f"{goal}."

    @abstractmethod
    def stimulus(self, situation: Situation) -> Stimulus:
        """What to show. Must depend on ``situation`` and the parameters alone."""

    @abstractmethod
    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        """Judge a percept that came while the prompt is up; None to go on waiting.

        ``trial.percepts`` holds the earlier ones of this trial, so that a task need not remember them.
        """

    def timed_out(self, trial: Trial) -> Result:
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

    def rehearse(self, stimulus: Stimulus, reaction_ms: float, slip: bool, chance: Chance) -> list[tuple[float, str]]:
        """The keys a simulated participant presses for a prompt: (ms after onset, key).

        Args:
            stimulus: what is shown.
            reaction_ms: the reaction time drawn for this person, prompt and moment.
            slip: whether this person gets it wrong this time.
            chance: for whatever else is random.

        A task whose response is more than one key overrides this; a stimulus that is shown and answered by one
        key needs nothing.
        """
        return [(reaction_ms, "wrong" if slip else stimulus.expected)]
