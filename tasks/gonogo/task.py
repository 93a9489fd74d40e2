"""The Go/No-Go task: a circle asks for a key, a square for none.

After Donders' c-reaction (1868, translated in Acta Psychol 30:412-431). Squares are rare and
circles come fast, so that a press is ready before it is known that none is wanted (Wessel 2018,
Psychophysiology 55:e12871); a key at a square is a commission error. Sensitivity d' is that of
signal detection, with rates corrected as by Hautus (1995, Behav Res Methods Instrum Comput
27:46-51).
"""

from collections.abc import Sequence
from statistics import NormalDist
from typing import Annotated, Any

from sar_tui.api.task import (
    Act,
    Details,
    Measure,
    Metric,
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

KEY = "space"
COMMISSIONS = 0.15
"""Share of squares at which simulated people press the key."""
HASTE = 0.85
"""Reaction time of such a press, as a share of one to a circle."""


class GoNoGoParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the Go/No-Go task."""

    prompts_per_attempt: Annotated[
        int, meta("Shapes per attempt", help="Number of shapes in an attempt.", ge=4, le=200)
    ] = 20
    squares: Annotated[
        float, meta("Squares", help="Share of shapes that are squares, 0.1 to 0.5.", ge=0.1, le=0.5)
    ] = 0.25
    time_ms: Annotated[
        int, meta("Time for a shape", "ms", "How long each shape stands.", ge=300, le=5000)
    ] = 1200
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    threshold: Annotated[
        float, meta("Goal", "ms", "The mean reaction time must be below this.", ge=100, le=10_000)
    ] = 700.0
    max_level: Annotated[
        int, meta("Highest level", help="All shapes are equally hard.", ge=1, le=1)
    ] = 1


class GoNoGoDetails(Details, frozen=True):
    """Details of a shape."""

    go: Annotated[bool | None, "True for a circle, which asks for the key."] = None


class GoNoGoTask(Task):
    """Press the key for a circle and not for a square. The metric is the mean reaction time to
    circles.
    """

    name = "gonogo"
    title = "Press or wait"
    summary = "Press the space bar for a circle; do not press it for a square."
    trains = "Inhibition"
    trials = "Shapes"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (
        Measure("commissions", "squares at which the key was pressed", unit="%", decimals=0),
        Measure("d_prime", "circles told from squares (d')", decimals=2),
    )
    Parameters = GoNoGoParameters
    Details = GoNoGoDetails
    parameters: GoNoGoParameters

    @property
    def levels(self) -> int:
        return 1

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    @property
    def switch_key(self) -> str:
        return KEY

    def instructions(self) -> str:
        return self.tr(
            "Press the space bar when you see a circle.\nWhen you see a square, wait: press "
            "nothing."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        go = situation.streams.uniform("go") >= self.parameters.squares
        return Stimulus(
            name="go" if go else "no go",
            expected=KEY if go else "",
            text=self.tr("A circle: press") if go else self.tr("A square: wait"),
            glyph="●" if go else "■",
            choices=2,
            timeout_ms=self.parameters.time_ms,
            data={"go": go},
        )

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        if percept.key != KEY:
            return None
        go = trial.stimulus.data["go"]
        return Result(
            correct=go,
            response=KEY,
            response_at=percept.at,
            value=trial.latency_ms(percept.at) if go else None,
            details={"go": go},
        )

    def timed_out(self, trial: Trial) -> Result:
        """Judge a shape without a key: right for a square."""
        go = trial.stimulus.data["go"]
        return Result(correct=not go, details={"go": go})

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return commission errors in percent, and d'; nothing without a circle and a square."""
        pressed: dict[bool, list[bool]] = {True: [], False: []}
        for result in results:
            if (go := result.details.get("go")) is not None:
                pressed[bool(go)].append(result.response is not None)
        circles, squares = pressed[True], pressed[False]
        if not circles or not squares:
            return {}
        hits, alarms = ((sum(found) + 0.5) / (len(found) + 1) for found in (circles, squares))
        z = NormalDist().inv_cdf
        return {"commissions": 100 * sum(squares) / len(squares), "d_prime": z(hits) - z(alarms)}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press at circles, and at some squares: quickly, before it is known that none is
        wanted.
        """
        if stimulus.data["go"]:
            return [] if performance.slips else [(performance.reaction_ms, KEY)]
        if streams.uniform("commission") < COMMISSIONS:
            return [(HASTE * performance.reaction_ms, KEY)]
        return []
