"""Posner's cueing task: the agent looks to a side, then a star appears on that side or on the
other.

After Posner (1980, Q J Exp Psychol 32:3-25), with a gaze as the cue (Friesen & Kingstone 1998,
Psychon Bull Rev 5:490-495): responses are faster on the side that was looked at, even if the gaze
says nothing about where the star will be. So half of the cues are valid by default; in Posner's own
task, most are. Unlike the faces of these studies, the agent is not where the participant looks, but
below on the left.
"""

from collections.abc import Sequence
from typing import Annotated, Any

from sar_tui.api.task import (
    Act,
    Cue,
    Details,
    Measure,
    Metric,
    Performance,
    RandomStreams,
    Result,
    Sentence,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    meta,
)

OTHER = {"left": "right", "right": "left"}
CUEING_MS = 20.0
"""By how much simulated people are slower on the other side."""
CUEING_SD_MS = 8.0
"""Standard deviation of it from trial to trial."""


class PosnerParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of Posner's cueing task."""

    prompts_per_attempt: Annotated[
        int, meta("Stars per attempt", help="Number of stars in an attempt.", ge=4, le=200)
    ] = 20
    valid: Annotated[
        float,
        meta(
            "Valid cues",
            help="Share of looks to the side of the star. Half: they tell nothing.",
            ge=0,
            le=1,
        ),
    ] = 0.5
    cue_lead_ms: Annotated[
        int,
        meta(
            "Cue lead",
            "ms",
            "The agent looks to a side this long before the star.",
            ge=100,
            le=2000,
        ),
    ] = 300
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    threshold: Annotated[
        float, meta("Goal", "ms", "The mean reaction time must be below this.", ge=100, le=10_000)
    ] = 800.0
    max_level: Annotated[
        int, meta("Highest level", help="All stars are equally hard.", ge=1, le=1)
    ] = 1

    def problems(self) -> dict[str, str]:
        problems = super().problems()
        if self.cue_lead_ms > self.foreperiod_min_ms:
            lead, wait = self.cue_lead_ms, self.foreperiod_min_ms
            problems["cue_lead_ms"] = Sentence(
                "Cue lead ({lead} ms) is longer than the shortest wait ({wait} ms).",
                lead=lead,
                wait=wait,
            )
        return problems


class PosnerDetails(Details, frozen=True):
    """Details of a star."""

    valid: Annotated[bool | None, "True if the agent looked to its side."] = None
    lead_ms: Annotated[float | None, "From the agent's look to the star."] = None


class PosnerTask(Task):
    """Press the arrow key of the side where the star appears. The metric is the mean reaction
    time.
    """

    name = "posner"
    title = "Star left or right"
    summary = "Press the arrow key of the side where a star appears, wherever the agent looks."
    trains = "Attention"
    trials = "Stars"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (Measure("cueing_ms", "slower where the agent did not look", unit="ms", decimals=0),)
    Parameters = PosnerParameters
    Details = PosnerDetails
    parameters: PosnerParameters

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        return self.tr(
            "A star appears on the left or on the right.\n"
            "Press the left or the right arrow key: the side of the star.\n"
            "The figure looks to a side before. It may be the wrong one."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        side = situation.streams.choice(("left", "right"), "side")
        is_valid = situation.streams.uniform("valid") < self.parameters.valid
        return Stimulus(
            name=side,
            expected=side,
            text=self.tr("Star: left") if side == "left" else self.tr("Star: right"),
            halves=("*", "") if side == "left" else ("", "*"),
            cue=Cue(
                "left" if (side == "left") is is_valid else "right", self.parameters.cue_lead_ms
            ),
            choices=2,
            data={"valid": is_valid},
        )

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        if percept.key not in OTHER:
            return None
        return Result(
            correct=percept.key == trial.stimulus.expected,
            response=percept.key,
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
            details=self._details(trial),
        )

    def timed_out(self, trial: Trial) -> Result:
        return Result(correct=False, details=self._details(trial))

    def _details(self, trial: Trial) -> dict[str, Any]:
        lead = None if trial.cued is None else -trial.latency_ms(trial.cued)
        return {"valid": trial.stimulus.data["valid"], "lead_ms": lead}

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return by how much responses were slower where the agent did not look, ms."""
        times: dict[bool, list[float]] = {True: [], False: []}
        for result in results:
            if result.counts and result.value is not None:
                times[bool(result.details["valid"])].append(result.value)
        if not all(times.values()):
            return {}
        valid, other = (sum(found) / len(found) for found in (times[True], times[False]))
        return {"cueing_ms": other - valid}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press the key, later if the agent looked to the other side."""
        varied = max(0.0, streams.generator("cueing").gauss(CUEING_MS, CUEING_SD_MS))
        late = 0.0 if stimulus.data["valid"] else varied
        key = OTHER[stimulus.expected] if performance.slips else stimulus.expected
        return [(performance.reaction_ms + late, key)]
