"""The open trial: from the foreperiod to its row in the database, and the answer to it that is
shown. Checks what a task declares of a prompt.
"""

import math
from collections.abc import Sequence
from typing import Any

import msgspec

from sar_tui.model import frames, tone
from sar_tui.model.frames import Frame
from sar_tui.model.messages import (
    CueGiven,
    FrameDue,
    KeyPerceived,
    Percept,
    Prompt,
    PromptVoided,
    Shown,
    TextPerceived,
    Timing,
    ToneBegan,
    ToneDue,
    TrialEnded,
    TrialFeedback,
    Typed,
)
from sar_tui.model.tone import Tone
from sar_tui.model.trial_types import Mark, Result, Results, Show, Situation, Stimulus, Trial
from sar_tui.model.units import MS
from sar_tui.rules import typed_text
from sar_tui.rules.keys import repeats
from sar_tui.rules.typed_text import TypedText


class OpenTrial:
    """State of a trial while it runs. A pause clears it, except for the number of presentations.

    Args:
        situation: its place in the session.
        stimulus: shown by its prompt.
        seats: of the task.
        presentation: number of times it has been shown.

    Attributes:
        timeout_ms: time for the response to this presentation.
        is_drawing: True while a frame is on its way to the screen, so that keys wait for its onset.

    Raises:
        ValueError: the stimulus cannot be shown.
    """

    def __init__(
        self,
        situation: Situation,
        stimulus: Stimulus,
        seats: tuple[str, ...] = ("A",),
        presentation: int = 0,
    ) -> None:
        self.situation = situation
        if problem := stimulus_problem(stimulus):  # ends the session with this sentence
            raise ValueError(problem)
        self.stimulus = stimulus
        if stimulus.expects != "key" and len(seats) > 1:
            raise ValueError("Typed text can be expected only in a task with one participant.")
        self.seats = (stimulus.seat,) if stimulus.seat else seats
        self.presentation = presentation
        self.foreperiod = 0
        self.false_starts = 0
        self.lag = 0
        self.early: list[Percept] = []
        self.started: int | None = None
        self.cued: int | None = None
        self.mark: Mark | None = None
        self.timeout_ms = 0.0
        self.is_drawing = False
        self._frames = frames.complete(stimulus.frames)
        self._timed, self._awaited = frames.timed(self._frames), frames.awaited(self._frames)
        self._requested = 0
        self._onsets: tuple[int, ...] = ()
        self._onset_source = ""
        self._tone_onsets: dict[int, int] = {}
        self._tone_source = ""
        self._percepts: tuple[Percept, ...] = ()
        self._repeats: tuple[KeyPerceived, ...] = ()
        self._typed = TypedText()
        self._flags: list[str] = []

    def repeated(self) -> "OpenTrial":
        """Return the same trial, cleared, to be repeated."""
        return OpenTrial(self.situation, self.stimulus, self.seats, self.presentation)

    @property
    def turn(self) -> str:
        """The seat whose turn it is; empty for all seats, or if only a cue may reveal it."""
        return "" if self.stimulus.cue else self._seat

    @property
    def _seat(self) -> str:
        return self.seats[0] if len(self.seats) == 1 else ""

    @property
    def pictures(self) -> tuple[str, ...]:
        """Pictures of the prompt, and of its frames."""
        found = (self.stimulus.picture, *(frame.picture for frame in self.stimulus.frames))
        return tuple(filter(None, found))

    def draw_foreperiod(self, shortest_ms: int, longest_ms: int) -> int:
        """Draw the foreperiod, in ns: uniform between the bounds, the same for each repetition."""
        share = self.situation.streams.uniform("foreperiod")
        self.foreperiod = round((shortest_ms + share * (longest_ms - shortest_ms)) * MS)
        return self.foreperiod

    def cue(self, at: int) -> CueGiven:
        """Give the cue at ``at`` (ns)."""
        cue = self.stimulus.cue
        assert cue
        self.cued = at
        return CueGiven(
            seat="",
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation + 1,
            side=cue.side,
            gaze=cue.side if cue.by != "gesture" else "",
            gesture=f"point_{cue.side}" if cue.by != "gaze" else "",
        )

    def flag(self, flag: str) -> None:
        """Add a flag to the trial, once."""
        if flag not in self._flags:
            self._flags.append(flag)

    def prompt(self, timeout_ms: float, now: int) -> Prompt:
        """Begin the next presentation ``now`` (ns), and return its prompt.

        ``timeout_ms``: for the response, if the stimulus does not say.
        """
        self.presentation += 1
        self.is_drawing = True
        self._requested = now
        self.timeout_ms = (
            timeout_ms if self.stimulus.timeout_ms is None else self.stimulus.timeout_ms
        )
        return Prompt(
            seat=self._seat,
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            level=self.situation.level,
            stimulus=self.stimulus.name,
            expected=self.stimulus.expected,
            text=self.stimulus.text,
            glyph=self.stimulus.glyph or self.stimulus.name,
            hint=self.stimulus.hint,
            choices=self.stimulus.choices,
            timeout=frames.planned(self._frames, self._timed) + round(self.timeout_ms * MS),
            started=self.started,
            halves=self.stimulus.halves,
            cue=self.stimulus.cue.side if self.stimulus.cue else "",
            frames=self._frames,
            colour=self.stimulus.colour,
            picture=self.stimulus.picture,
            tone=self.stimulus.tone,
            data=self.stimulus.data,
            expects=self.stimulus.expects,
        )

    def frame(self) -> FrameDue:
        """Begin to draw the next frame."""
        due = self.next_onset_due
        assert due is not None
        self.is_drawing = True
        return FrameDue(
            seat=self._seat,
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            frame=len(self._onsets),
            at=due,
        )

    def is_shown_by(self, shown: Shown) -> bool:
        """Return True if ``shown`` is about what is being drawn of this presentation."""
        return self.is_drawing and (
            shown.attempt,
            shown.trial,
            shown.presentation,
            shown.frame,
        ) == (
            self.situation.attempt,
            self.situation.trial,
            self.presentation,
            len(self._onsets),
        )

    def set_onset(self, shown: Shown) -> None:
        """Store the onset of the prompt, or of one of its frames."""
        if (due := self.next_onset_due) is not None and shown.at - due > frames.LATE:
            self.flag("late_frame")
        if len(self._onsets) <= self._timed:
            self._onset_source = shown.source
        self._onsets = (*self._onsets, shown.at)
        self.is_drawing = False
        if shown.source == "refresh":
            self.flag("onset_refresh")
        if shown.picture == "none":
            self.flag("no_picture")

    @property
    def _onset(self) -> int | None:
        """Onset from which the reaction time counts; None before it."""
        return self._onsets[self._timed] if len(self._onsets) > self._timed else None

    @property
    def _counts_from(self) -> int:
        """Onset from which the reaction time counts, or the time at which it is due. Only after the
        first onset.
        """
        due = self._onsets[0] + frames.planned(self._frames, self._timed)
        return due if self._onset is None else self._onset

    @property
    def next_onset_due(self) -> int | None:
        """Time (ns) at which the next frame must be seen; None after the last one.

        It is reckoned from the onset of the first frame, so that delays do not add up.
        """
        if not self._onsets or len(self._onsets) == len(self._frames) or not self._frames:
            return None
        return self._onsets[0] + frames.planned(self._frames, len(self._onsets))

    @property
    def tones(self) -> tuple[Tone, ...]:
        """The tones of the prompt, each once."""
        tones = (self.stimulus.tone, *(frame.tone for frame in self._frames))
        return tuple(dict.fromkeys(filter(None, tones)))

    def next_tone(self) -> ToneDue | None:
        """Return the tone of the frame that comes next, and when it is to sound; None if that has
        none.

        The tone of a later frame is requested when the frame before it is shown, so that it can be
        prepared.
        """
        place = len(self._onsets)
        wanted = self._frames[place].tone if place < len(self._frames) else None
        if place == 0:
            wanted = wanted or self.stimulus.tone
        if wanted is None:
            return None
        due = self.next_onset_due
        return ToneDue(
            seat=self._seat,
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            frame=place,
            tone=wanted,
            at=self._requested if due is None else due,
        )

    def tone_began(self, began: ToneBegan) -> None:
        """Store the onset of a tone of this presentation, or that it failed."""
        if (began.attempt, began.trial, began.presentation) != (
            self.situation.attempt,
            self.situation.trial,
            self.presentation,
        ):
            return
        if began.source == "failed":
            self.flag("tone_failed")
        else:
            self._tone_onsets[began.frame] = began.at
            self._tone_source = began.source

    @property
    def timeout_at(self) -> int | None:
        """Time (ns) at which the time for the response is over, as soon as that is known."""
        return None if self._onset is None else self._onset + round(self.timeout_ms * MS)

    def is_awaited(self, at: int) -> bool:
        """Return True if a response at a time stamp is awaited: not before the frame that the
        stimulus names.
        """
        return self._awaited == 0 or (
            len(self._onsets) > self._awaited and at >= self._onsets[self._awaited]
        )

    def view(self) -> Trial:
        """Return the trial as the task sees it. Only after the onset."""
        assert self._onsets
        return Trial(
            self.situation,
            self.stimulus,
            onset=self._counts_from,
            percepts=self._percepts,
            started=self.started,
            cued=self.cued,
            frames=self._onsets if self._frames else (),
            tones=tuple(self._tone_onsets.values()),
            typed=self._typed.text,
        )

    @property
    def expects_text(self) -> bool:
        """True if the prompt is answered by typing."""
        return self.stimulus.expects != "key"

    def type(self, key: KeyPerceived) -> TextPerceived | None:
        """Take a key of the typed text. Returns the text if the key is Enter, which sends it; None
        for any other.
        """
        written = self._typed
        if key.key != "enter":
            self._typed = written.pressed(key.key, key.at, self.stimulus.expects)
            return None
        self._typed = TypedText()
        return TextPerceived(
            seat=key.seat,
            at=key.at,
            delay=key.delay,
            loop_lag=key.loop_lag,
            text=written.text,
            began=written.began,
            keys=written.keys,
            corrections=written.corrections,
        )

    def typed(self) -> Typed:
        """Return the text typed so far, to be shown."""
        return Typed(
            seat=self._seat,
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            text=self._typed.text,
        )

    def remember(self, percept: Percept) -> None:
        """Add a percept that was judged."""
        self._percepts = (*self._percepts, percept)

    def remember_repeat(self, press: KeyPerceived) -> None:
        """Forget presses that turn out to be repeats of a held key: the first ones, which come more
        slowly.
        """
        self._repeats = (*self._repeats, press)
        mine = [
            one for one in self._percepts if isinstance(one, KeyPerceived) and _is_same(one, press)
        ]
        held = repeats(sorted(one.at for one in (*mine, *self._repeats) if _is_same(one, press)))
        self._percepts = tuple(
            one for one in self._percepts if one not in mine or one.at not in held
        )

    def voided(self, reason: str) -> PromptVoided:
        """Return the message that cancels this presentation."""
        return PromptVoided(
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            reason=reason,
        )

    def latency_ms(self, result: Result) -> float | None:
        """Return the reaction time: from the prompt's onset to the response, or to its onset if it
        lasts.

        Negative if the response came first; None for a miss, or if the prompt does not ask for a
        quick response.
        """
        at = result.response_at if result.onset_at is None else result.onset_at
        if not self._onsets or at is None or not self.stimulus.signals:
            return None
        return (at - self._counts_from) / MS

    def ended(self, result: Result, seat: str = "A") -> TrialEnded:
        """Return the trial's row for a seat.

        Raises:
            TypeError: the task's result cannot be stored: it has other types than declared, or is
                not finite.
        """
        row = self._row(result, seat)
        try:
            msgspec.convert(msgspec.to_builtins(row), TrialEnded)
        except (msgspec.ValidationError, TypeError) as error:
            raise TypeError(f"the result of a trial cannot be stored: {error}") from error
        numbers = [
            value for value in (row.value, *row.details.values()) if isinstance(value, float)
        ]
        if not all(map(math.isfinite, numbers)):
            raise TypeError("the result of a trial cannot be stored: a number in it is not finite")
        return row

    def _judged(self, result: Result, seat: str) -> Percept | None:
        """Return the percept that led to the result: the last one, or with several seats the one of
        the response.
        """
        mine = [percept for percept in self._percepts if percept.seat == seat]
        if len(self.seats) > 1:
            mine = [
                one for one in mine if result.response_at in (one.at, getattr(one, "onset", None))
            ]
        return mine[-1] if mine else None

    def _row(self, result: Result, seat: str) -> TrialEnded:
        latency = self.latency_ms(result)
        last = self._judged(result, seat)
        return TrialEnded(
            seat=seat,
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            stimulus=self.stimulus.name,
            response=result.response,
            correct=result.correct,
            onset=self._onset if result.onset_at is None else result.onset_at,
            response_at=result.response_at,
            reaction_time_ms=latency if latency is not None and latency >= 0 else None,
            value=result.value if result.counts else None,
            timing=Timing(
                onset_source=self._onset_source,
                handler_delay_ms=last.delay / MS if last else None,
                loop_lag_ms=max(self.lag, last.loop_lag if last else 0) / MS,
                false_starts=self.false_starts,
                presentation=self.presentation,
                foreperiod_ms=self.foreperiod / MS,
                flags=(*self._flags, *result.flags),
                frame_onsets_ns=self._onsets if self._frames else (),
                tone_onsets_ns=tuple(self._tone_onsets.values()),
                tone_source=self._tone_source,
            ),
            details=result.details,
            data=self.stimulus.data,
        )


def _is_same(one: KeyPerceived, other: KeyPerceived) -> bool:
    """Return True for two presses of a key at one seat."""
    return (one.key, one.seat) == (other.key, other.seat)


def stimulus_problem(stimulus: Stimulus) -> str:
    """Return a sentence that says why a prompt cannot be shown, timed and stored as declared; empty
    if it can.
    """
    if not isinstance(stimulus, Stimulus):
        return f"stimulus() returned {stimulus!r:.60}, not a Stimulus."
    if type(stimulus.choices) is not int:
        return f"The choices of a prompt are a whole number, not {stimulus.choices!r:.60}."
    time = stimulus.timeout_ms
    if time is not None and not (isinstance(time, int | float) and 0 < time < math.inf):
        return f"The timeout_ms of a prompt is {time!r:.80}; it is a time above 0, or None."
    if stimulus.tone is not None and (problem := tone.problem(stimulus.tone)):
        return problem
    return (
        frames.problem(stimulus.frames)
        or problem_of_texts(stimulus)
        or problem_of_data(stimulus.data)
        or typed_text.problem(stimulus)
    )


# --- what a prompt may be


_OF_BOTH = ("text", "glyph", "hint", "colour", "picture")
_OF_PROMPT = ("name", "expected", "seat", *_OF_BOTH)


def problem_of_texts(stimulus: Stimulus) -> str:
    """Return a sentence that names what should be a text and is none; empty if all are texts."""
    if found := _problem_of("prompt", stimulus, _OF_PROMPT):
        return found
    return next(
        filter(None, (_problem_of("frame", frame, _OF_BOTH) for frame in stimulus.frames)), ""
    )


def _problem_of(what: str, shown: Stimulus | Frame, names: tuple[str, ...]) -> str:
    for name in names:
        if not isinstance(value := getattr(shown, name), str):
            return f"The {name} of a {what} is a text, not {value!r:.80}."
    halves = shown.halves
    if (
        isinstance(halves, tuple)
        and len(halves) in (0, 2)
        and all(isinstance(half, str) for half in halves)
    ):
        return ""
    return f"The halves of a {what} are a pair of texts, not {halves!r:.80}."


LONGEST_DATA = 10_000
"""Most bytes that the data of one prompt take as JSON."""


def problem_of_data(data: dict[str, Any]) -> str:
    """Return a sentence that says why the data of a prompt cannot be stored as they are; empty if
    they can.
    """
    if not isinstance(data, dict):
        return f"The data of a prompt are a dictionary, not {data!r:.60}."
    try:
        stored = msgspec.json.encode(data)
    except (TypeError, ValueError, RecursionError) as error:
        return f"The data of a prompt cannot be stored as JSON: {error}."
    if msgspec.json.decode(stored) != data:
        return (
            f"The data of a prompt would change in JSON: {data!r:.60}. Its keys are texts, its "
            "values texts, finite "
            "numbers, lists and dictionaries."
        )
    if len(stored) > LONGEST_DATA:
        return (
            f"The data of a prompt take {len(stored)} bytes as JSON; {LONGEST_DATA} are possible."
        )
    return ""


# --- the answer to a trial


RIGHT, WRONG = "✓", "✗"
_UNJUDGED = ("skipped", "unmeasured")
"""Flags of results that say nothing about the participant."""


def trial_feedback(
    situation: Situation, results: Results, seats: Sequence[str], sign_ms: int
) -> TrialFeedback | None:
    """Return the feedback on a trial; None if nothing is shown.

    Args:
        situation: of the trial.
        results: of the trial, by seat.
        seats: of the task: the first one sees its answer on the left if answers differ.
        sign_ms: how long a tick or a cross is shown for a result of which the task shows nothing;
            0: it is not.
    """
    shows = {seat: show for seat, result in results.items() if (show := _show(result, sign_ms))}
    if not shows:
        return None
    texts = [shows[seat].text if seat in shows else "" for seat in seats]
    differ = len(results) > 1 and len(set(texts)) > 1
    return TrialFeedback(
        seat=next(iter(results)) if len(results) == 1 else "",
        attempt=situation.attempt,
        trial=situation.trial,
        text=" ".join(filter(None, texts)) if differ else next(iter(shows.values())).text,
        halves=tuple(texts) if differ else (),
        duration=max(show.ms for show in shows.values()) * MS,
    )


def _show(result: Result, sign_ms: int) -> Show | None:
    if result.show or not sign_ms or set(_UNJUDGED) & set(result.flags):
        return result.show
    return Show(RIGHT if result.correct else WRONG, sign_ms)
