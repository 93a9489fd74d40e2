"""Go/No-Go: a circle asks for a key, a square for none."""

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec

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

# The time for a response at each level (ms), easiest first.
TIMES = (1000, 900, 800, 700, 600)


class ExampleParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task; see those of `TaskParameters`, which are inherited."""

    prompts_per_attempt: Annotated[
        int, meta("Prompts per attempt", help="Number of prompts in an attempt.", ge=4, le=200)
    ] = 20
    no_go_share: Annotated[
        float, meta("Share without a response", help="Of all prompts, 0.1 to 0.5.", ge=0.1, le=0.5)
    ] = 0.25
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "The mean reaction time of an attempt must be below this.",
            ge=100,
            le=10_000,
        ),
    ] = 550.0


class ExampleDetails(Details, frozen=True):
    """Details stored with each trial."""

    go: Annotated[bool, msgspec.Meta(description="True if the prompt asked for a response.")]


class ExampleTask(Task):
    """The metric is the mean reaction time to circles. A key at a square is wrong, and so is none
    at a circle.
    """

    name = "example"  # the folder has the same name
    title = "Go or wait"
    summary = "Press the space bar for a circle, and nothing for a square."
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (Measure("commissions", "keys at a square", decimals=1),)
    Parameters = ExampleParameters
    Details = ExampleDetails
    parameters: ExampleParameters

    @property
    def levels(self) -> int:
        return len(TIMES)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        return (
            "Press the space bar when a circle appears, as fast as you can.\nPress nothing for "
            "a square."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        go = situation.streams.uniform("go") >= self.parameters.no_go_share
        return Stimulus(
            name="go" if go else "no go",
            expected="space" if go else "",  # no key answers a square
            text="A circle" if go else "A square",
            glyph="●" if go else "■",
            choices=2,
            timeout_ms=TIMES[situation.level - 1],
            data={"go": go},
        )

    def perceived(self, trial: Trial, percept: Any) -> Result:
        go = trial.stimulus.data["go"]
        return Result(
            correct=go and percept.key == "space",
            response=percept.key,
            response_at=percept.at,
            value=trial.latency_ms(percept.at) if go else None,
            details={"go": go},
        )

    def timed_out(self, trial: Trial) -> Result:
        """Judge a prompt without a response: right for a square."""
        go = trial.stimulus.data["go"]
        return Result(correct=not go, details={"go": go})

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        return {
            "commissions": sum(
                not result.details["go"] and not result.correct for result in results
            )
        }

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Respond to circles; in a slip, to a square as well, and not to a circle."""
        if stimulus.data["go"] == performance.slips:
            return []
        return [(performance.reaction_ms, "space")]
