"""The trial in hand: from the quiet before its prompt to its row in the table."""

import math

import msgspec

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import CueGiven, Percept, Prompt, PromptVoided, Shown, Timing, TrialEnded
from sar_tui.framework.trial_types import Mark, Result, Situation, Stimulus, Trial


class OpenTrial:
    """What is known of one trial while it runs. A pause clears it, but for the count of its presentations.

    Args:
        situation: where in the session it stands.
        stimulus: what it shows.
        seats: who takes part in the task.
    """

    def __init__(
        self, situation: Situation, stimulus: Stimulus, seats: tuple[str, ...] = ("A",), presentation: int = 0
    ) -> None:
        self.situation = situation
        self.stimulus = stimulus
        self.seats = (stimulus.seat,) if stimulus.seat else seats
        self.presentation = presentation
        self.foreperiod = 0
        self.false_starts = 0
        self.lag = 0
        self.early: list[Percept] = []
        self.started: int | None = None
        self.cued: int | None = None
        self.mark: Mark | None = None
        self._onset: int | None = None
        self._onset_source = ""
        self._percepts: tuple[Percept, ...] = ()
        self._flags: list[str] = []

    def repeated(self) -> "OpenTrial":
        """The same trial, to be repeated."""
        return OpenTrial(self.situation, self.stimulus, self.seats, self.presentation)

    @property
    def turn(self) -> str:
        """Whose turn it is, as far as that is told before the prompt; empty: everybody's, or not to be known."""
        return "" if self.stimulus.cue else self._seat

    @property
    def _seat(self) -> str:
        return self.seats[0] if len(self.seats) == 1 else ""

    def draw_foreperiod(self, shortest_ms: int, longest_ms: int) -> int:
        """Choose the wait before the prompt, in ns: uniform between the bounds, the same at each repetition."""
        share = self.situation.streams.uniform("foreperiod")
        self.foreperiod = round((shortest_ms + share * (longest_ms - shortest_ms)) * MS)
        return self.foreperiod

    def cue(self, at: int) -> CueGiven:
        """The agent looks or points to a side, at ``at`` (ns)."""
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
        """Mark the trial, once."""
        if flag not in self._flags:
            self._flags.append(flag)

    def prompt(self, timeout: int) -> Prompt:
        """Present it once more."""
        self.presentation += 1
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
            timeout=timeout,
            started=self.started,
            halves=self.stimulus.halves,
            cue=self.stimulus.cue.side if self.stimulus.cue else "",
        )

    def is_shown_by(self, shown: Shown) -> bool:
        """Whether ``shown`` speaks of this presentation."""
        return (shown.attempt, shown.trial, shown.presentation) == (
            self.situation.attempt,
            self.situation.trial,
            self.presentation,
        )

    def set_onset(self, shown: Shown) -> None:
        """The prompt reached the screen."""
        self._onset, self._onset_source = shown.at, shown.source
        if shown.source == "refresh":
            self.flag("onset_refresh")

    def view(self) -> Trial:
        """What a task is given to judge by. Only once shown."""
        assert self._onset is not None
        return Trial(self.situation, self.stimulus, self._onset, self._percepts, self.started, self.cued)

    def remember(self, percept: Percept) -> None:
        """Keep a percept that has been judged."""
        self._percepts = (*self._percepts, percept)

    def voided(self, reason: str) -> PromptVoided:
        """It is broken off."""
        return PromptVoided(
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            reason=reason,
        )

    def latency_ms(self, result: Result) -> float | None:
        """The reaction time: from the prompt's onset to the response, or to the beginning of one that lasts.

        Negative for a response that came first; None for a miss, or where the prompt does not signal.
        """
        at = result.response_at if result.onset_at is None else result.onset_at
        if self._onset is None or at is None or not self.stimulus.signals:
            return None
        return (at - self._onset) / MS

    def ended(self, result: Result, seat: str = "A") -> TrialEnded:
        """Its row, for one of those who took part.

        Raises:
            TypeError: the task's result is not of the types it declares, or not finite, so that it cannot be kept.
        """
        row = self._row(result, seat)
        try:
            msgspec.convert(msgspec.to_builtins(row), TrialEnded)
        except (msgspec.ValidationError, TypeError) as error:
            raise TypeError(f"the result of a trial cannot be kept: {error}") from error
        numbers = [value for value in (row.value, *row.details.values()) if isinstance(value, float)]
        if not all(map(math.isfinite, numbers)):
            raise TypeError("the result of a trial cannot be kept: a number in it is not finite")
        return row

    def _judged(self, result: Result, seat: str) -> Percept | None:
        """The percept that a result came of: the last, or where several take part the one that was the response."""
        mine = [percept for percept in self._percepts if percept.seat == seat]
        if len(self.seats) > 1:
            mine = [one for one in mine if result.response_at in (one.at, getattr(one, "onset", None))]
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
            ),
            details=result.details,
        )
