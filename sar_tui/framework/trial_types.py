"""The values that a task and the framework exchange about a trial and an attempt."""

from typing import Any, Literal

import msgspec

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import Json
from sar_tui.framework.random_streams import RandomStreams


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
    streams: RandomStreams
    session: RandomStreams


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
