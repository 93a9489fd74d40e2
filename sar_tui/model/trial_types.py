"""Values that a task and the framework exchange: metric and target, stimulus, trial, result,
score.
"""

from bisect import bisect_right
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Literal

import msgspec

from sar_tui.model.frames import Frame as Frame  # noqa: PLC0414  tasks import it from here
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.tone import Tone as Tone  # noqa: PLC0414
from sar_tui.model.units import MS

Json = dict[str, str | int | float | bool | None]
"""Values that a task may add to a trial's row."""

DOUBTFUL = "disagree"
"""Flag of a trial whose measures are doubtful: it counts, but no change is reported from it."""

UNSURE = "unsure"
"""Flag of a trial of which it is not sure that it was a response: it is not scored, until a mark says
what it was.
"""

LONGEST_SHOW_MS = 10_000
"""Longest time for which an answer to a trial is shown."""


class Metric(msgspec.Struct, frozen=True):
    """The measure of an attempt.

    ``improved`` and ``worsened`` are the words for a change ("faster", "slower"); ``decimals`` is
    the number of decimals shown.
    """

    name: str
    unit: str
    better: Literal["lower", "higher"]
    improved: str = "better"
    worsened: str = "worse"
    decimals: int = 0

    @property
    def is_none(self) -> bool:
        """True for a task without a measure of its attempts."""
        return not self.name

    @property
    def label(self) -> str:
        """Name and unit, for display: "reaction time (ms)"."""
        name = self.name.replace("_", " ")
        return f"{name} ({self.unit})" if self.unit else name

    def is_better(self, value: float, than: float) -> bool:
        """Return True if ``value`` is strictly better."""
        return value < than if self.better == "lower" else value > than

    def show(self, value: float) -> str:
        """Return a value with its unit, for display."""
        return f"{value:.{self.decimals}f} {self.unit}".rstrip()


NO_METRIC = Metric("", "", "higher")
"""The metric of a task that declares None."""


class Target(msgspec.Struct, frozen=True):
    """The goal of an attempt, and the distance from it within which feedback is neutral; in the
    metric's unit.
    """

    threshold: float
    neutral_band: float


class Axis(msgspec.Struct, frozen=True):
    """The axis on which the difficulty of levels is measured: results worsen along it, in about a
    straight line.

    ``is_log2``: the axis holds logarithms to base 2, as of a number of choices; people are shown
    the number itself.
    """

    name: str = "level"
    unit: str = ""
    decimals: int = 1
    is_log2: bool = False

    def show(self, difficulty: float) -> str:
        """Return a place on the axis with its unit, for display: "10.4 keys"."""
        value = 2**difficulty if self.is_log2 else difficulty
        return f"{value:.{self.decimals}f} {self.unit}".rstrip()


class Quality(msgspec.Struct, frozen=True):
    """A measure of how a trial was done (knowledge of performance), taken from its details.

    Args:
        field: the field of ``Details``. Its mean over an attempt's correct trials is compared with
            that of the last comparable attempt.
        better: the direction of improvement.
        improved: the word for an improvement: "smoother".
        aim: the advice after a decline: "as smoothly as you can".
        margin: smaller differences are ignored, also where the person's own noise is less.
        praised: True if feedback is given on it; it is stored in any case.
    """

    field: str
    better: Literal["lower", "higher"]
    improved: str
    aim: str
    margin: float
    praised: bool = True


class Score(msgspec.Struct, frozen=True):
    """The score of an attempt. ``accuracy`` is None in a task without it.

    ``won``: in a race, the number of trials that this seat won.
    """

    metric: float | None
    accuracy: float | None
    correct: int
    trials: int
    won: int | None = None


class PastAttempt(msgspec.Struct, frozen=True):
    """A scored attempt of one seat. ``measures``: means of the task's qualities, and its
    ``measures``.
    """

    attempt: int
    practice: bool
    level: int
    score: Score
    measures: dict[str, float] = {}
    condition: str = ""


class Situation(msgspec.Struct, frozen=True):
    """The position of a prompt in the session, and what came before it.

    Args:
        attempt, trial: numbers, from 1.
        level: of the attempt.
        streams: the random streams of this trial.
        session: those that all trials share.
        results_by_seat: the results of this attempt's earlier trials, oldest first.
        history_by_seat: the scored attempts of this session, oldest first.
        condition: of the attempt (see `Task.condition`).
    """

    attempt: int
    trial: int
    level: int
    streams: RandomStreams
    session: RandomStreams
    results_by_seat: "tuple[Results, ...]" = ()
    history_by_seat: tuple[Mapping[str, PastAttempt], ...] = ()
    condition: str = ""

    @property
    def chance(self) -> RandomStreams:
        """Former name of ``streams``."""
        from warnings import warn

        warn("chance of a situation is now its streams.", DeprecationWarning, stacklevel=2)
        return self.streams

    @property
    def results(self) -> "tuple[Result, ...]":
        """Results of this attempt's earlier trials, oldest first; with several seats, of seat A."""
        return self.results_of("A")

    @property
    def history(self) -> tuple[PastAttempt, ...]:
        """Scored attempts of this session, oldest first, practice included; with several seats, of
        seat A.
        """
        return self.history_of("A")

    def results_of(self, seat: str) -> "tuple[Result, ...]":
        """Return the results of this attempt's earlier trials in which a seat took part, oldest
        first.
        """
        return tuple(results[seat] for results in self.results_by_seat if seat in results)

    def history_of(self, seat: str) -> tuple[PastAttempt, ...]:
        """Return the scored attempts of a seat in this session, oldest first, practice included."""
        return tuple(scored[seat] for scored in self.history_by_seat if seat in scored)


class Cue(msgspec.Struct, frozen=True):
    """A cue to a side before the prompt: the agent looks there, points there, or both."""

    side: Literal["left", "right"]
    lead_ms: int
    by: Literal["gaze", "gesture", "both"] = "gaze"


class Stimulus(msgspec.Struct, frozen=True):
    """The content of a prompt.

    Args:
        name: stored in ``trials.stimulus``.
        expected: the key or the typed text that answers it; empty if there is no single one.
        text: the plain-text line, one unbroken run of characters: "Press: f".
        glyph: shown very large; defaults to ``name``.
        hint: shown under the glyph.
        choices: the number of stimuli it was drawn from.
        signals: True if it asks for an immediate response, so that the time from its onset is a
            reaction time.
        seat: the seat that responds, in a task with several; empty for all of them.
        halves: the contents of the left and right half of the screen, instead of ``glyph``.
        cue: given before the prompt; nothing else then announces whose turn it is.
        timeout_ms: time for the response to this prompt; None: the parameter
            ``response_timeout_ms``.
        frames: shown one after the other instead of ``glyph`` and ``text``, each for its time.
        colour: of what is drawn large: a name of `prompt_colors.OKABE_ITO`; empty for the colour of
            texts.
        picture: a file in the task's folder, shown instead of ``glyph``: "pictures/cat.png".
        tone: sounds from the onset of the prompt on; with frames, each may have its own instead.
        data: kept with the trial and never shown, as JSON: lists, no tuples.
        expects: what answers it: a key, or text or digits that are typed and sent with Enter.
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
    timeout_ms: float | None = None
    frames: tuple[Frame, ...] = ()
    colour: str = ""
    picture: str = ""
    tone: Tone | None = None
    data: dict[str, Any] = {}
    expects: Literal["key", "text", "digits"] = "key"


class Trial(msgspec.Struct, frozen=True):
    """A trial whose prompt is shown: the stimulus, its onset (ns) and the percepts so far.

    ``started``: when the participant started the trial, if they do (ns). ``cued``: when the agent
    gave its cue (ns). ``frames``: onsets of the frames shown so far (ns), in a prompt that has
    some; ``onset`` is then that of the timed one, and if that is still to come, the time at which
    it is due. ``tones``: onsets of the tones that have begun (ns), of a repeated one the first.
    ``typed``: the text typed so far and not sent, if the prompt expects one.
    """

    situation: Situation
    stimulus: Stimulus
    onset: int
    percepts: tuple[Any, ...] = ()
    started: int | None = None
    cued: int | None = None
    frames: tuple[int, ...] = ()
    tones: tuple[int, ...] = ()
    typed: str = ""

    def frame_at(self, at: int) -> int:
        """Return the place of the frame that was on the screen at a time stamp, counted from 0; -1
        before the first.
        """
        return bisect_right(self.frames or (self.onset,), at) - 1

    def latency_ms(self, at: int) -> float:
        """Return the milliseconds from onset to a time stamp."""
        return (at - self.onset) / MS


class Show(msgspec.Struct, frozen=True):
    """An answer to a trial, shown after it: a sign, a number of points or a word, for a time in ms.

    Raises:
        ValueError: the text is not one line that can be printed, or the time is not above 0.
    """

    text: str
    ms: int = 600

    def __post_init__(self) -> None:
        if not (isinstance(self.text, str) and self.text.strip() and self.text.isprintable()):
            raise ValueError(
                f"what is shown after a trial is not one line of plain text: {self.text!r:.60}"
            )
        if type(self.ms) is not int:
            raise ValueError(
                "what is shown after a trial is shown for a whole number of ms, not "
                f"{self.ms!r:.60}"
            )
        if not 0 < self.ms <= LONGEST_SHOW_MS:
            raise ValueError(
                f"what is shown after a trial is shown for {self.ms} ms; 1 to {LONGEST_SHOW_MS} "
                "are possible"
            )


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """The outcome of a trial.

    Args:
        correct: True if the response was the right one.
        response: the response; None for a miss.
        response_at: its time stamp (ns); None for a miss.
        onset_at: for a response that lasts: the time stamp of its onset, while ``response_at`` is
            that of its end. It replaces the prompt's onset in the trial's row, and a reaction time
            is counted up to it.
        value: the trial's contribution to the attempt's metric; None for none.
        details: more to store with the trial, as the task's ``Details`` declare.
        flags: added to ``trials.timing``; the framework adds ``anticipation``. A trial with
            ``unsure`` is not scored.
        remark: said instead of the theme's phrase if the attempt fails for lack of correct trials:
            a sentence without numbers.
        correction: said after the feedback, however the attempt went: a sentence on how to move,
            without numbers. Of several in an attempt, the last is said.
        show: shown after the trial, before the next one begins.
    """

    correct: bool
    response: str | None = None
    response_at: int | None = None
    onset_at: int | None = None
    value: float | None = None
    details: Json = {}
    flags: tuple[str, ...] = ()
    remark: str = ""
    correction: str = ""
    show: Show | None = None

    @property
    def counts(self) -> bool:
        """True if the trial's value counts for the metric."""
        return (
            self.correct
            and self.value is not None
            and {"anticipation", UNSURE}.isdisjoint(self.flags)
        )


def complete(result: Result, declared: "type[Details]") -> Result:
    """Return a result as it is stored: None for an empty response, and all declared details if it
    has none at all.

    So a trial that timed out has the same columns as the others: each detail has its default, or
    else None.
    """
    if not isinstance(result, Result):
        raise TypeError(
            f"a trial ended with {result!r:.60}, which is no Result: look at perceived and "
            "timed_out"
        )
    if not (result.show is None or isinstance(result.show, Show)):
        raise TypeError(
            f"the show of a Result is a Show, such as Show('+10'), not {result.show!r:.60}"
        )
    details = result.details or {
        field.name: None if field.default is msgspec.NODEFAULT else field.default
        for field in msgspec.structs.fields(declared)
    }
    return msgspec.structs.replace(result, response=result.response or None, details=details)


Results = dict[str, Result]
"""Results of a trial by seat."""


class Mark(msgspec.Struct, frozen=True):
    """A therapist's mark on a trial, set with one key.

    ``counts``: True if the trial can still be correct. ``remark``: said to the participant if it
    cannot.
    """

    name: str
    key: str
    title: str
    counts: bool
    remark: str = ""

    def applied(self, result: Result) -> Result:
        """Return a result with this mark. It is sure, as somebody has seen it."""
        return msgspec.structs.replace(
            result,
            correct=result.correct and self.counts,
            flags=tuple(flag for flag in result.flags if flag != UNSURE),
            details={**result.details, "mark": self.name},
            remark=result.remark if self.counts else self.remark,
        )


class Again(msgspec.Struct, frozen=True):
    """A trial that could not be measured, through no fault of the participant: it is repeated under
    the same number.

    Args:
        reason: a word for the log: ``gap``.
        text: said to the participant.
    """

    reason: str
    text: str


class Performance:
    """A simulated participant's performance of one prompt.

    Args:
        reaction_ms: the reaction time drawn for this prompt.
        slips: True if the response is to be wrong.
        pace: the duration of a movement, as a multiple of a healthy person's; or what draws it, for
            a task that moves.
        unsteadiness: 0 for a hand that goes straight, 1 for one that halts and dwells.
    """

    def __init__(
        self,
        reaction_ms: float,
        slips: bool = False,
        pace: float | Callable[[], float] = 1.0,
        unsteadiness: float = 0.0,
    ) -> None:
        self.reaction_ms = reaction_ms
        self.slips = slips
        self.unsteadiness = unsteadiness
        self._pace = pace

    @cached_property
    def pace(self) -> float:
        """The duration of a movement, as a multiple of a healthy person's."""
        return self._pace() if callable(self._pace) else self._pace


Act = tuple[float, Any]
"""An act of a simulated participant: ms after the prompt, and the name of a key or a movement of
the hand.
"""


class Details(msgspec.Struct, frozen=True):
    """Base of the details stored with each trial. Declare their fields in a subclass, for the data
    dictionary.
    """
