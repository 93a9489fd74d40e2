"""The serial reaction time task: a square moves between four places, in an order that repeats
unannounced.

After Nissen & Bullemer (1987, Cogn Psychol 19:1-32), with a sequence of twelve places in which a
place follows from the two before it only (Reed & Johnson 1994, J Exp Psychol Learn Mem Cogn
20:585-594). Some attempts are in random order; what is learnt of the sequence is by how much they
are slower (Robertson 2007, J Neurosci 27:10073-10075). The next place follows at once, which keeps
the learning implicit (Destrebecqz & Cleeremans 2001, Psychon Bull Rev 8:343-350).
"""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from sar_tui.api.task import (
    Act,
    Measure,
    Metric,
    PastAttempt,
    Performance,
    RandomStreams,
    Result,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    meta,
)

SEQUENCE = (0, 1, 0, 2, 3, 1, 2, 0, 3, 2, 1, 3)
"""Each pair of places comes once, and so does each place after another, whatever the place is
called.
"""
RANDOM, REPEATING = "random", "sequence"
LEARNT_MS = 130.0
"""By how much the sequence makes simulated people faster in the end; chosen here."""
REPETITIONS = 20.0
"""Repetitions after which they have 63 % of it."""


class SerialParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the serial reaction time task."""

    prompts_per_attempt: Annotated[
        int,
        meta(
            "Squares per attempt",
            help="Best a multiple of 12, the length of the sequence.",
            ge=12,
            le=480,
        ),
    ] = 60
    random_every: Annotated[
        int,
        meta(
            "Random order every",
            "attempts",
            "So often an attempt is in random order; the others repeat.",
            ge=2,
            le=50,
        ),
    ] = 4
    keys: Annotated[
        Literal["dfjk", "1234"],
        meta("Keys", help="From left to right. dfjk: for two hands. 1234: for one hand."),
    ] = "dfjk"
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 8
    threshold: Annotated[
        float, meta("Goal", "ms", "The mean reaction time must be below this.", ge=100, le=10_000)
    ] = 900.0
    max_level: Annotated[
        int, meta("Highest level", help="All attempts are equally hard.", ge=1, le=1)
    ] = 1


class SerialTask(Task):
    """Press the key of the place where the square is. The metric is the mean reaction time."""

    name = "srtt"
    title = "Moving square"
    summary = "Press the key of the place where the square is, as fast as you can."
    trains = "Learning of movements"
    trials = "Squares"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (Measure("learning_ms", "slower in random order", unit="ms", decimals=0),)
    Parameters = SerialParameters
    parameters: SerialParameters

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    @property
    def has_foreperiod(self) -> bool:
        return False

    def instructions(self) -> str:
        keys = ", ".join(self.parameters.keys)
        return self.tr(
            "A square is in one of four places.\nThe keys {keys} are these places, from left to "
            "right.\n"
            "Press the key of the square. It then moves on.",
            keys=keys,
        )

    def condition(self, situation: Situation) -> str:
        return RANDOM if situation.attempt % self.parameters.random_every == 0 else REPEATING

    def stimulus(self, situation: Situation) -> Stimulus:
        order = self.condition(situation)
        place = (
            self._random_place(situation) if order == RANDOM else self._sequence_place(situation)
        )
        before = situation.attempt - 1
        seen = (
            (before - before // self.parameters.random_every) * self.trials_per_attempt
            + situation.trial
            - 1
        )
        key = self.parameters.keys[place]
        return Stimulus(
            name=key,
            expected=key,
            text=self.tr("Place {place} of 4", place=place + 1),
            glyph="".join("■" if each == place else "□" for each in range(4)),
            hint=self.tr("Keys: {keys}", keys=" ".join(self.parameters.keys)),
            choices=4,
            data={"place": place + 1, "order": order, "repetitions": seen // len(SEQUENCE)},
        )

    def _sequence_place(self, situation: Situation) -> int:
        """Return the place of a trial in this session's sequence, which begins anywhere with any
        place.
        """
        draw = situation.session.generator("sequence")
        places, start = draw.sample(range(4), 4), draw.randrange(len(SEQUENCE))
        return places[SEQUENCE[(start + situation.trial - 1) % len(SEQUENCE)]]

    def _random_place(self, situation: Situation) -> int:
        """Return the place of a trial in random order; none comes twice in a row, as in the
        sequence.
        """
        draw = situation.session.generator("random", situation.attempt)
        place = draw.randrange(4)
        for _ in range(situation.trial - 1):
            place = (place + draw.randrange(1, 4)) % 4
        return place

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        if percept.key.lower() not in self.parameters.keys:
            return None
        return Result(
            correct=percept.key.lower() == trial.stimulus.expected,
            response=percept.key.lower(),
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
        )

    def learning(self, attempt: PastAttempt, history: Sequence[PastAttempt]) -> dict[str, float]:
        """Return by how much an attempt in random order was slower than the last one with the
        sequence, ms.
        """
        times = [past.score.metric for past in history if past.condition == REPEATING]
        if (
            attempt.condition != RANDOM
            or attempt.score.metric is None
            or not times
            or times[-1] is None
        ):
            return {}
        return {"learning_ms": attempt.score.metric - times[-1]}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press the key, the earlier the more often the sequence has been repeated."""
        repetitions = stimulus.data["repetitions"] if stimulus.data["order"] == REPEATING else 0
        gained = LEARNT_MS * (1 - math.exp(-repetitions / REPETITIONS))
        others = [key for key in self.parameters.keys if key != stimulus.expected]
        key = streams.choice(others, "slip") if performance.slips else stimulus.expected
        return [(max(120.0, performance.reaction_ms - gained), key)]
