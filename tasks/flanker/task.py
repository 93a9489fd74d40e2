"""The flanker task: the middle arrow counts, and those beside it agree with it or not.

After Eriksen & Eriksen (1974, Percept Psychophys 16:143-149), with the arrows of the Attention
Network Test (Fan et al. 2002, J Cogn Neurosci 14:340-347). Responses to incongruent rows are slower
and less accurate: the conflict effect.
"""

from collections.abc import Sequence
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

ARROWS = {"left": "←", "right": "→"}
OTHER = {"left": "right", "right": "left"}
CONFLICT_MS = 84.0
"""By how much simulated people are slower if the arrows disagree: the mean of the 40 adults of Fan
et al. (2002).
"""
CONFLICT_SD_MS = 25.0
"""Standard deviation of it between them."""


class FlankerParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the flanker task."""

    prompts_per_attempt: Annotated[
        int, meta("Rows per attempt", help="Number of rows of arrows in an attempt.", ge=4, le=200)
    ] = 20
    incongruent: Annotated[
        float, meta("Incongruent", help="Share of rows whose arrows disagree.", ge=0, le=1)
    ] = 0.5
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    threshold: Annotated[
        float, meta("Goal", "ms", "The mean reaction time must be below this.", ge=100, le=10_000)
    ] = 800.0
    max_level: Annotated[
        int, meta("Highest level", help="All rows are equally hard.", ge=1, le=1)
    ] = 1


class FlankerDetails(Details, frozen=True):
    """Details of a row."""

    congruent: Annotated[bool | None, "True if all arrows point the same way."] = None


class FlankerTask(Task):
    """Press the arrow key of the arrow in the middle. The metric is the mean reaction time."""

    name = "flanker"
    title = "Arrow in the middle"
    summary = (
        "Press the arrow key of the arrow in the middle; those beside it may point the other way."
    )
    trains = "Attention"
    trials = "Rows"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (Measure("conflict_ms", "slower with arrows that disagree", unit="ms", decimals=0),)
    Parameters = FlankerParameters
    Details = FlankerDetails
    parameters: FlankerParameters

    @property
    def levels(self) -> int:
        return 1

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        return self.tr(
            "Look at the arrow in the middle.\nPress the left or the right arrow key, as it "
            "points.\n"
            "The arrows beside it may point the other way."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        side = situation.streams.choice(("left", "right"), "side")
        congruent = situation.streams.uniform("congruent") >= self.parameters.incongruent
        beside = ARROWS[side if congruent else OTHER[side]] * 2
        row = f"{beside}{ARROWS[side]}{beside}"
        text = self.tr("Middle: {row}", row=row)
        return Stimulus(row, side, text, choices=2, data={"congruent": congruent})

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        if percept.key not in ARROWS:
            return None
        return Result(
            correct=percept.key == trial.stimulus.expected,
            response=percept.key,
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
            details={"congruent": trial.stimulus.data["congruent"]},
        )

    def timed_out(self, trial: Trial) -> Result:
        return Result(correct=False, details={"congruent": trial.stimulus.data["congruent"]})

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return by how much responses were slower to incongruent rows than to congruent ones,
        ms.
        """
        times: dict[bool, list[float]] = {True: [], False: []}
        for result in results:
            if result.counts and result.value is not None:
                times[bool(result.details["congruent"])].append(result.value)
        if not all(times.values()):
            return {}
        same, other = (sum(found) / len(found) for found in (times[True], times[False]))
        return {"conflict_ms": other - same}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press the key, later if the arrows disagree."""
        varied = streams.generator("conflict").gauss(CONFLICT_MS, CONFLICT_SD_MS)
        late = 0.0 if stimulus.data["congruent"] else max(0.0, varied)
        key = OTHER[stimulus.expected] if performance.slips else stimulus.expected
        return [(performance.reaction_ms + late, key)]
