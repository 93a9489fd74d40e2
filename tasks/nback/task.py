"""The n-back task: press the space bar if a letter is the same as n letters ago. The level is n.

After Owen et al. (2005, Hum Brain Mapp 25:46-59); half a second for a letter and 2.5 s from one to
the next, and hits minus false alarms as the score, after Jaeggi et al. (2010, Memory 18:394-412).
The more letters have to be kept in mind, the less is found and the longer it takes: hardly anything
is missed at n = 1, outside the focus of attention more is (Bopp & Verhaeghen 2020, J Gerontol B
75:229-240).
"""

from collections.abc import Sequence
from statistics import NormalDist
from typing import Annotated, Any

from msgspec.structs import replace

from sar_tui.api.task import (
    Act,
    Frame,
    Measure,
    Metric,
    Performance,
    RandomStreams,
    Result,
    Score,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    meta,
)

KEY = "space"
LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
LETTER_MS = 500.0
FORGOTTEN = (0.02, 0.12, 0.25, 0.35)
"""Share of targets that simulated people miss at each n."""
FALSE_ALARMS = 0.3
"""Share of other letters at which they press, as a part of that."""
LATER_MS = 100.0
"""By how much later they press for each letter more that is kept in mind."""


class NbackParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the n-back task."""

    letters: Annotated[
        int,
        meta(
            "Letters per attempt",
            help="Besides the first ones, which nothing comes before.",
            ge=10,
            le=200,
        ),
    ] = 20
    targets: Annotated[
        float, meta("Same letters", help="Share of letters that are the same.", ge=0.1, le=0.5)
    ] = 0.3
    interval_ms: Annotated[
        int, meta("Interval", "ms", "From one letter to the next.", ge=1000, le=10_000)
    ] = 2500
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 8
    threshold: Annotated[
        float, meta("Goal", "%", "Hits minus false alarms must be above this.", ge=0, le=99)
    ] = 70.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "%",
            "A result this close to the goal, on either side, is called neither good nor bad.",
            ge=0,
            le=50,
        ),
    ] = 5.0
    max_level: Annotated[
        int, meta("Highest level", help="The most letters to keep in mind.", ge=1, le=4)
    ] = 3


class NbackTask(Task):
    """Press if the letter is the same as n letters ago. The metric is the share found, minus that
    of false alarms.
    """

    name = "nback"
    title = "Letters again"
    summary = "Press the space bar if a letter is the same as one, two or three letters ago."
    trains = "Memory"
    trials = "Letters"
    metric = Metric("found", unit="%", better="higher", improved="better", worsened="worse")
    measured = (Measure("d_prime", "d′", decimals=2),)
    Parameters = NbackParameters
    parameters: NbackParameters

    def level_name(self, level: int) -> str:
        return f"n = {level}"

    def trials_at(self, level: int) -> int:
        return self.parameters.letters + level

    @property
    def trials_per_attempt(self) -> int:
        return self.trials_at(1)

    @property
    def has_foreperiod(self) -> bool:
        return False

    @property
    def restarts_attempts(self) -> bool:
        return True

    @property
    def switch_key(self) -> str:
        return KEY

    def instructions(self) -> str:
        return self.tr(
            "Letters appear one after the other.\nPress the space bar if the letter is the same "
            "as before.\n"
            "How far back counts is written under it. Otherwise, just wait."
        )

    def notice(self, level: int, before: int) -> str:
        return self._rule(level) if before else ""

    def _rule(self, level: int) -> str:
        return self.tr(
            "Same as {count} letters ago?" if level > 1 else "Same as the last letter?", count=level
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        letter, is_target = self._letters(situation)[situation.trial - 1]
        text, hint = self.tr("Letter: {letter}", letter=letter), self._rule(situation.level)
        return Stimulus(
            name=letter,
            expected=KEY if is_target else "",
            text=text,
            choices=2,
            frames=(Frame(letter, LETTER_MS, text=text, hint=hint), Frame(text="·", hint=hint)),
            timeout_ms=float(self.parameters.interval_ms),
            data={"n": situation.level, "target": is_target},
        )

    def _letters(self, situation: Situation) -> list[tuple[str, bool]]:
        """Return the letters of an attempt, and for each if it is the same as n letters before."""
        n, count = situation.level, self.parameters.letters
        draw = situation.session.generator("letters", situation.attempt)
        same = set(draw.sample(range(n, n + count), round(self.parameters.targets * count)))
        made: list[tuple[str, bool]] = []
        for place in range(n + count):
            before = made[place - n][0] if place >= n else ""
            other = draw.choice(LETTERS.replace(before, "") if before else LETTERS)
            made.append((before, True) if place in same else (other, False))
        return made

    def perceived(self, trial: Trial, percept: Any) -> None:
        """Wait for the next letter: it comes at its time, whatever is pressed."""

    def timed_out(self, trial: Trial) -> Result:
        at = next((percept.at for percept in trial.percepts if percept.key == KEY), None)
        is_right = (at is not None) is trial.stimulus.data["target"]
        return Result(correct=is_right, response=at and KEY, response_at=at)

    def score(self, results: Sequence[Result]) -> Score:
        (hits, targets), (alarms, others) = _pressed(results, True), _pressed(results, False)
        found = 100 * (hits / targets - alarms / others) if targets and others else None
        return replace(super().score(results), metric=found)

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return d′ with half a response added to each count (Hautus 1995)."""
        (hits, targets), (alarms, others) = _pressed(results, True), _pressed(results, False)
        z = NormalDist().inv_cdf
        return {"d_prime": z((hits + 0.5) / (targets + 1)) - z((alarms + 0.5) / (others + 1))}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press for the same letters, less often and later the more have to be kept in mind."""
        n, is_target = stimulus.data["n"], stimulus.data["target"]
        wrong = FORGOTTEN[n - 1] * (1.0 if is_target else FALSE_ALARMS)
        presses = is_target is not (streams.uniform("memory") < wrong)
        return [(performance.reaction_ms + LATER_MS * (n - 1), KEY)] if presses else []


def _pressed(results: Sequence[Result], is_target: bool) -> tuple[int, int]:
    """Return how often the key was pressed at same or at other letters, and how many there were."""
    pressed = [result.response is not None for result in results]
    asked = [
        press
        for press, result in zip(pressed, results, strict=True)
        if (press is result.correct) is is_target
    ]
    return sum(asked), len(asked)
