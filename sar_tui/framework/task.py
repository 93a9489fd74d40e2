"""The contract of a task: one class that declares itself once, and judges what a person did.

A task is a pure description. It keeps no state between calls: what it needs is handed to it, so that a trial
can be repeated, resumed and replayed. The framework runs it: waits, shows, stamps, scores, adapts, answers.
"""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal

import msgspec

from sar_tui.framework.chance import Chance
from sar_tui.framework.clock import MS
from sar_tui.framework.language import language
from sar_tui.framework.messages import Json
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import TaskParameters

_FRAMEWORK = Path(__file__).parent
"""Where the translations of the framework's own words are."""


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


class Target(msgspec.Struct, frozen=True):
    """What the metric of an attempt is held against, and how near to it is neutral; in the metric's unit."""

    threshold: float
    neutral_band: float


class Quality(msgspec.Struct, frozen=True):
    """Something about *how* a trial was done (knowledge of performance), kept in its details.

    Args:
        field: the field of ``Details``; its mean over an attempt's correct trials is compared with that of the last
            attempt alike.
        better: which way is better.
        improved: what is said of one that is better than before: "smoother".
        aim: what is asked for otherwise: "as smoothly as you can".
        margin: a smaller difference is not worth telling.
    """

    field: str
    better: Literal["lower", "higher"]
    improved: str
    aim: str
    margin: float

    def change(self, value: float, before: float) -> float:
        """How much better than before, in margins; negative where it is worse."""
        difference = before - value if self.better == "lower" else value - before
        return difference / self.margin


class Situation(msgspec.Struct, frozen=True):
    """Where in a session a prompt stands. ``chance`` belongs to this trial alone, ``session`` to all of them."""

    attempt: int
    trial: int
    level: int
    chance: Chance
    session: Chance


class Cue(msgspec.Struct, frozen=True):
    """What the agent does before a prompt to draw the eye to a side: it looks there, points there, or both."""

    side: Literal["left", "right"]
    lead_ms: int
    by: Literal["gaze", "gesture", "both"] = "gaze"


class Stimulus(msgspec.Struct, frozen=True):
    """What a prompt shows.

    Args:
        name: what is stored in ``trials.stimulus``.
        expected: the key that answers it, empty where no single key does.
        text: the plain-text line, one unbroken run of characters: "Press: f".
        glyph: what stands very large on the screen; defaults to ``name``.
        hint: a word of help under it.
        choices: among how many stimuli it was drawn.
        signals: whether it asks for a response at once, so that the time from its onset is a reaction time.
        seat: whose it is, in a task with several seats; empty: everybody's.
        halves: what stands in the left and in the right half of the screen, in place of ``glyph``.
        cue: what the agent does before it. Whose turn it is, is then not told before.
    """

    name: str
    expected: str
    text: str
    glyph: str = ""
    hint: str = ""
    choices: int = 1
    signals: bool = True
    seat: str = ""
    halves: tuple[str, ...] = ()
    cue: Cue | None = None


class Trial(msgspec.Struct, frozen=True):
    """A prompt that is up: what was shown, since when (ns), and what was perceived so far.

    ``started``: when the participant started the trial, where that is theirs to do. ``cued``: when the agent gave its
    cue.
    """

    situation: Situation
    stimulus: Stimulus
    onset: int
    percepts: tuple[Any, ...] = ()
    started: int | None = None
    cued: int | None = None

    def latency_ms(self, at: int) -> float:
        """Milliseconds from onset to a stamp."""
        return (at - self.onset) / MS


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """How a trial ended.

    Args:
        correct: whether the response was the right one.
        response: what was done; None for a miss.
        response_at: its stamp in ns; None for a miss.
        onset_at: where a response lasts: the stamp of its beginning, as ``response_at`` is that of its end. It
            takes the place of the prompt's onset in the trial's row, and a reaction time is counted up to it.
        value: what the trial adds to the attempt's metric; None where it adds nothing.
        details: more to keep with the trial, as the task's ``Details`` declare.
        flags: marks for ``trials.timing``; the framework adds ``anticipation``.
        remark: what the participant should hear of it, where an attempt failed for want of right trials: a sentence
            without numbers, instead of the theme's.
    """

    correct: bool
    response: str | None = None
    response_at: int | None = None
    onset_at: int | None = None
    value: float | None = None
    details: Json = {}
    flags: tuple[str, ...] = ()
    remark: str = ""

    @property
    def counts(self) -> bool:
        """Whether the trial's value belongs in the metric."""
        return self.correct and self.value is not None and "anticipation" not in self.flags


Results = dict[str, Result]
"""How a trial ended for each of those who took part, by their seat."""


class Mark(msgspec.Struct, frozen=True):
    """What a therapist can say of a trial with one key.

    ``counts``: whether it can be correct all the same; ``remark``: what the participant hears where it cannot.
    """

    name: str
    key: str
    title: str
    counts: bool
    remark: str = ""

    def applied(self, result: Result) -> Result:
        """A result with this mark."""
        return msgspec.structs.replace(
            result,
            correct=result.correct and self.counts,
            details={**result.details, "mark": self.name},
            remark=result.remark if self.counts else self.remark,
        )


class Again(msgspec.Struct, frozen=True):
    """Nothing can be said of a trial, through no fault of the participant's: it is repeated under the same number.

    Args:
        reason: a word for the log: ``gap``.
        words: what the participant is told.
    """

    reason: str
    words: str


class Score(msgspec.Struct, frozen=True):
    """An attempt's result. ``accuracy`` is None where a task has none.

    ``won``: in how many trials this seat was the first, where they race.
    """

    metric: float | None
    accuracy: float | None
    correct: int
    trials: int
    won: int | None = None


class Performance(msgspec.Struct, frozen=True):
    """How a simulated participant does one prompt.

    Args:
        reaction_ms: the reaction time drawn for this person, prompt and moment.
        slips: whether this person gets it wrong this time.
        pace: how long a movement takes this person this time, as a share of what it takes a healthy one.
        unsteadiness: 0 for a hand that goes straight, 1 for one that halts and dwells.
    """

    reaction_ms: float
    slips: bool = False
    pace: float = 1.0
    unsteadiness: float = 0.0


Act = tuple[float, Any]
"""What a simulated participant does: when (ms after the prompt), and a key's name or a movement of the hand."""


class Details(msgspec.Struct, frozen=True):
    """The base of what a task keeps with each trial: declare the fields, for the data dictionary."""


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

    def rehearse(self, stimulus: Stimulus, performance: Performance, chance: Chance) -> list[Act]:
        """What a simulated participant does for a prompt: (ms after onset, key or movement).

        Args:
            stimulus: what is shown; ``seat`` is that of this person.
            performance: how this person does it this time.
            chance: for whatever else is random.

        A task whose response is more than one key overrides this; a stimulus that is shown and answered by one
        key needs nothing.
        """
        return [(performance.reaction_ms, "wrong" if performance.slips else stimulus.expected)]
