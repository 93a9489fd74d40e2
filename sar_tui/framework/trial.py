"""The open trial: from the foreperiod to its row in the database."""

import math

import msgspec

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import CueGiven, Percept, Prompt, PromptVoided, Shown, Timing, TrialEnded
from sar_tui.framework.trial_types import Mark, Result, Situation, Stimulus, Trial


class OpenTrial:
    """State of a trial while it runs. A pause clears it, except for the number of presentations.

    Args:
        situation: its place in the session.
        stimulus: shown by its prompt.
        seats: of the task.
        presentation: number of times it has been shown.
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
        """Return the same trial, cleared, to be repeated."""
        return OpenTrial(self.situation, self.stimulus, self.seats, self.presentation)

    @property
    def turn(self) -> str:
        """The seat whose turn it is; empty for all seats, or if only a cue may reveal it."""
        return "" if self.stimulus.cue else self._seat

    @property
    def _seat(self) -> str:
        return self.seats[0] if len(self.seats) == 1 else ""

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

    def prompt(self, timeout: int) -> Prompt:
        """Begin the next presentation, and return its prompt. ``timeout``: for the response, in ns."""
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
        """Return True if ``shown`` is about this presentation."""
        return (shown.attempt, shown.trial, shown.presentation) == (
            self.situation.attempt,
            self.situation.trial,
            self.presentation,
        )

    def set_onset(self, shown: Shown) -> None:
        """Store the onset of the prompt."""
        self._onset, self._onset_source = shown.at, shown.source
        if shown.source == "refresh":
            self.flag("onset_refresh")

    def view(self) -> Trial:
        """Return the trial as the task sees it. Only after the onset."""
        assert self._onset is not None
        return Trial(self.situation, self.stimulus, self._onset, self._percepts, self.started, self.cued)

    def remember(self, percept: Percept) -> None:
        """Add a percept that was judged."""
        self._percepts = (*self._percepts, percept)

    def voided(self, reason: str) -> PromptVoided:
        """Return the message that cancels this presentation."""
        return PromptVoided(
            attempt=self.situation.attempt,
            trial=self.situation.trial,
            presentation=self.presentation,
            reason=reason,
        )

    def latency_ms(self, result: Result) -> float | None:
        """Return the reaction time: from the prompt's onset to the response, or to its onset if it lasts.

        Negative if the response came first; None for a miss, or if the prompt does not ask for a quick response.
        """
        at = result.response_at if result.onset_at is None else result.onset_at
        if self._onset is None or at is None or not self.stimulus.signals:
            return None
        return (at - self._onset) / MS

    def ended(self, result: Result, seat: str = "A") -> TrialEnded:
        """Return the trial's row for a seat.

        Raises:
            TypeError: the task's result cannot be stored: it has other types than declared, or is not finite.
        """
        row = self._row(result, seat)
        try:
            msgspec.convert(msgspec.to_builtins(row), TrialEnded)
        except (msgspec.ValidationError, TypeError) as error:
            raise TypeError(f"the result of a trial cannot be stored: {error}") from error
        numbers = [value for value in (row.value, *row.details.values()) if isinstance(value, float)]
        if not all(map(math.isfinite, numbers)):
            raise TypeError("the result of a trial cannot be stored: a number in it is not finite")
        return row

    def _judged(self, result: Result, seat: str) -> Percept | None:
        """Return the percept that led to the result: the last one, or with several seats the one of the response."""
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
