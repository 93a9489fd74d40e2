"""The contract of a task: one class that declares the task, makes its prompts and judges responses.

A task is a pure description. It keeps no state between calls, so that a trial can be repeated,
resumed and replayed. The framework runs it: it waits, shows, stamps, scores, adapts and gives
feedback.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from sar_tui.model.measure import Measure
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import (
    NO_METRIC,
    Act,
    Again,
    Axis,
    Details,
    Mark,
    Metric,
    PastAttempt,
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
from sar_tui.plugin_calls import mark_methods

if TYPE_CHECKING:  # a task's module is imported in little more time than msgspec
    from sar_tui.loop.node import Node
    from sar_tui.model.step import Step
    from sar_tui.rules.parameters import TaskParameters


class _CommonSettings:
    """Default of `Task.Parameters`, imported when it is first asked for."""

    def __get__(self, task: object, kind: type) -> "type[TaskParameters]":
        from sar_tui.rules.parameters import TaskParameters

        return TaskParameters


class Task(ABC):
    """A motor task.

    Subclass it in ``tasks/NAME/task.py``: declare the class variables, and define ``instructions``,
    ``stimulus`` and ``perceived``. The rest has defaults.

    ``tr`` translates a text into the session's language: ``self.tr("Reach {far} far.", far="15
    cm")``. The translations are in ``words.<language>.toml`` beside the task; they cover its
    declared texts too (``title``, marks).

    Attributes:
        name: of its folder, and in the database.
        title, summary: for people.
        trains: what it trains, in a word or two, for the list of tasks: "Attention".
        trials: name of its trials on the screen.
        version: stored with each session; change it when results are no longer comparable.
        metric: the measure of an attempt; None (kept as `NO_METRIC`) in a task without one.
        Parameters: its settings.
        Details: fields stored with each trial.
        sensors: kinds of sensors it needs.
        qualities: measures for feedback on performance.
        measured: how the numbers of ``measures`` and ``learning`` are shown; others are stored
            only.
        marks: that a therapist can put on a trial.
        seats: places of participants.
        rules: version of the rules of this session, so that a task that has changed plays an
            earlier one as it was.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    summary: ClassVar[str] = ""
    trains: ClassVar[str] = ""
    trials: ClassVar[str] = "Prompts"
    version: ClassVar[str] = "1"
    metric: ClassVar[Metric]
    Parameters: "ClassVar[type[TaskParameters]]" = _CommonSettings()  # type: ignore[assignment]
    Details: ClassVar[type[Details]] = Details
    sensors: ClassVar[tuple[Literal["imu"], ...]] = ()
    qualities: ClassVar[tuple[Quality, ...]] = ()
    measured: ClassVar[tuple[Measure, ...]] = ()
    marks: ClassVar[tuple[Mark, ...]] = ()
    seats: ClassVar[tuple[str, ...]] = ("A",)

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        mark_methods(cls, "task")
        if vars(cls).get("metric", cls) is None:
            cls.metric = NO_METRIC

    @classmethod
    def sensor_seats(cls, parameters: "TaskParameters") -> tuple[str, ...]:
        """Return the seats with a sensor under these parameters; by default all, in a task that has
        ``sensors``.
        """
        return cls.seats if cls.sensors else ()

    def __init__(self, parameters: "TaskParameters") -> None:
        import inspect
        from pathlib import Path

        from sar_tui.model.language import language

        texts_of_the_loop = Path(__file__).parent
        self.parameters = parameters
        self.names: dict[str, str] = {}
        own_texts = Path(inspect.getfile(type(self))).parent
        self.tr = language(parameters.language, texts_of_the_loop, own_texts)

    @property
    def levels(self) -> int:
        """Number of levels."""
        return self.parameters.max_level

    def level_name(self, level: int) -> str:
        """Return what a level is, for the therapist: "asdfjkl;", "25 cm"; empty if its number says
        enough.
        """
        return ""

    @property
    def axis(self) -> Axis:
        """The axis of difficulty, on which progress over sessions is measured."""
        return Axis()

    def difficulty(self, level: int) -> float:
        """Return the place of a level on the axis of difficulty; by default the level itself."""
        return float(level)

    @property
    def trials_per_attempt(self) -> int:
        """Number of prompts in an attempt."""
        return 1

    def trials_at(self, level: int) -> int:
        """Return the number of prompts in an attempt at a level; by default the same at all."""
        return self.trials_per_attempt

    @property
    def continuous(self) -> bool:
        """True if an attempt begins by itself after the one before it, without Enter."""
        return False

    @property
    def restarts_attempts(self) -> bool:
        """True if an attempt that was interrupted begins again from its first prompt, rather than
        going on.
        """
        return False

    @property
    def steps(self) -> "tuple[Step, ...]":
        """Questions, screens to read, rests and calibrations between attempts; by default none."""
        return ()

    @property
    def start_key(self) -> str:
        """The key with which the participant starts each trial; empty if trials start by
        themselves.
        """
        return ""

    @property
    def switch_key(self) -> str:
        """The key that is the only one the participant needs within trials, so that one switch is
        enough; empty if several are needed.
        """
        return ""

    @property
    def has_foreperiod(self) -> bool:
        """True if a random wait precedes each prompt."""
        return True

    @property
    def feedback_on(self) -> Literal["results", "performance", "both"]:
        """Content of feedback: the result, how it was done (the ``qualities``), or both."""
        return "results"

    @property
    def address(self) -> Literal["seat", "code"]:
        """The name that the agent uses for the participants of a task with several seats: their
        seat or their code.
        """
        return "seat"

    def seat_of(self, key: str) -> str:
        """Return the seat of a key, in a task with several; empty if it belongs to no seat and is
        never a response.
        """
        return ""

    def seat_name(self, seat: str) -> str:
        """Return the name of a seat, in a task with several."""
        return self.tr({"A": "Left", "B": "Right"}.get(seat, seat))

    def display_name(self, seat: str) -> str:
        """Return the name of a seat's participant: as recorded at the start of the session, else
        the seat's name.
        """
        return self.names.get(seat) or self.seat_name(seat)

    def nodes(self) -> "tuple[Node, ...]":
        """Return new nodes that make percepts from the task's sensors."""
        return ()

    def target(self, level: int) -> Target | None:
        """Return the target of an attempt at a level, as it follows from the settings; None: it has
        no goal.

        Without a metric there is none in any case.
        """
        return Target(self.parameters.threshold, self.parameters.neutral_band)

    def target_at(self, level: int, goal: float) -> Target:
        """Return the target of an attempt at a level with a goal that a difficulty policy made."""
        own = self.target(level)
        return Target(goal, own.neutral_band if own else 0.0)

    def goal_value(self, level: int) -> float | None:
        """Return the goal of an attempt at a level, in the metric's unit; None if it has none."""
        target = None if self.metric.is_none else self.target(level)
        return None if target is None else target.threshold

    def with_goal(self, goal: float | None) -> Self:
        """Return the same task with this goal in its targets and words, whatever the level; None:
        its own.
        """
        if goal is None:
            return self
        from copy import copy

        aimed = copy(self)
        vars(aimed)["target"] = lambda level: self.target_at(level, goal)
        return aimed

    @abstractmethod
    def instructions(self) -> str:
        """Return the instructions for the participant."""

    def goal(self, level: int) -> str:
        """Return the goal of an attempt at a level, as a sentence for the participant; empty if it
        has none.

        Read it from ``target``, because a difficulty policy can set another than the settings do.
        """
        value = self.goal_value(level)
        if value is None:
            return ""
        from sar_tui.model.results_for_people import goal_text

        goal = goal_text(self.metric, value, self.tr)
        needed = f"{self.parameters.min_accuracy:.0%}" if self.parameters.min_accuracy else ""
        if self.parameters.min_accuracy == 1:
            return self._goal_with_all_right(goal)
        match self.metric.better, bool(needed):
            case "lower", True:
                return self.tr(
                    "Your goal: less than {goal}, with at least {needed} right.",
                    goal=goal,
                    needed=needed,
                )
            case "lower", False:
                return self.tr("Your goal: less than {goal}.", goal=goal)
            case _, True:
                return self.tr(
                    "Your goal: more than {goal}, with at least {needed} right.",
                    goal=goal,
                    needed=needed,
                )
        return self.tr("Your goal: more than {goal}.", goal=goal)

    def _goal_with_all_right(self, goal: str) -> str:
        if self.metric.better == "lower":
            return self.tr("Your goal: less than {goal}, with all right.", goal=goal)
        return self.tr("Your goal: more than {goal}, with all right.", goal=goal)

    def notice(self, level: int, before: int) -> str:
        """Return what the participant must know after a change of level; empty for nothing, as
        without one before.
        """
        return self.tr("Now level {level}.", level=level) if before else ""

    def start(self, level: int) -> str:
        """Return the text shown before the participant starts a trial, in a task with a
        ``start_key``.
        """
        return self.tr("Start when you are ready.")

    def when_to_respond(self) -> str:
        """Return the advice after an attempt whose prompts stayed unanswered: a sentence without
        numbers.
        """
        return self.tr("Respond as soon as you see the signal.")

    def condition(self, situation: Situation) -> str:
        """Return the condition of an attempt, from the situation of its first prompt; empty for
        none.

        It is kept with the attempt, which is compared with attempts in the same condition only.
        Like a prompt, it must depend on ``situation`` and the parameters alone.
        """
        return ""

    @abstractmethod
    def stimulus(self, situation: Situation) -> Stimulus:
        """Return the prompt. It must depend on ``situation`` and the parameters alone."""

    @abstractmethod
    def perceived(self, trial: Trial, percept: Any) -> Result | Results | Again | None:
        """Judge a percept received while the prompt is shown; None to keep waiting.

        ``trial.percepts`` holds the earlier percepts of this trial, so that the task need not
        remember them. In a task with several seats, each percept has its seat, and the trial ends
        for all of them at once: with one result for each seat, or one for all.
        """

    def timed_out(self, trial: Trial) -> Result | Results:
        """Judge a trial that timed out. Default: a miss."""
        return Result(correct=False)

    def score(self, results: Sequence[Result]) -> Score:
        """Score an attempt: the mean of the values of correct trials, and the share of correct
        ones.
        """
        values = [result.value for result in results if result.counts and result.value is not None]
        correct = sum(result.correct for result in results)
        return Score(
            metric=sum(values) / len(values) if values else None,
            accuracy=correct / len(results),
            correct=correct,
            trials=len(results),
        )

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return more measures of an attempt by name, stored with its qualities."""
        return {}

    def learning(self, attempt: PastAttempt, history: Sequence[PastAttempt]) -> dict[str, float]:
        """Return measures of an attempt that compare it with earlier ones (``history``), stored
        with the others.
        """
        return {}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Return the acts of a simulated participant on a prompt: (ms after onset, key or
        movement).

        By default it is the expected key, or another one in a slip; no key where none is expected.
        Override it if the response is more than one key press, or than the expected text (see
        `typed_text.typing`).

        Args:
            stimulus: the prompt; ``seat`` is that of this participant.
            performance: the participant's performance of this prompt.
            streams: for anything else that is random.
        """
        if stimulus.expects != "key":
            from sar_tui.rules.typed_text import typing

            return typing(stimulus.expected, performance)
        key = "wrong" if performance.slips else stimulus.expected
        return [(performance.reaction_ms, key)] if key else []
