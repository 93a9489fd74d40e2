"""The stop-signal task: press the key of the arrow, unless a cross takes its place.

After Logan & Cowan (1984, Psychol Rev 91:295-327), by the recommendations of Verbruggen et al.
(2019, eLife 8:e46323): the cross comes 50 ms later after a stop and 50 ms sooner after a response,
so that half of the responses are stopped. They ask for 50 crosses or more: an attempt's time to
stop is a rough one, so pool the trials of a session.
"""

from collections.abc import Sequence
from math import ceil
from statistics import fmean
from typing import Annotated, Any

from sar_tui.api.task import (
    MS,
    Act,
    Details,
    Frame,
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
STOP_MS, STOP_SD_MS = 220.0, 25.0
"""Time that simulated people need to stop a response, and its standard deviation."""
FIRST_MS, STEP_MS, LAST_MS = 250.0, 50.0, 1000.0
"""Delays of the cross: the first one, a step, and the longest."""


class StopSignalParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the stop-signal task."""

    prompts_per_attempt: Annotated[
        int, meta("Arrows per attempt", help="Number of arrows in an attempt.", ge=8, le=200)
    ] = 32
    crosses: Annotated[
        float, meta("Crosses", help="Share of arrows with a cross, 0.1 to 0.5.", ge=0.1, le=0.5)
    ] = 0.25
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    response_timeout_ms: Annotated[
        int, meta("Time for an arrow", "ms", "Time to respond to an arrow.", ge=1200, le=5000)
    ] = 1500
    threshold: Annotated[
        float, meta("Goal", "ms", "The mean reaction time must be below this.", ge=100, le=10_000)
    ] = 800.0
    min_accuracy: Annotated[
        float,
        meta(
            "Right responses",
            help="Share of trials that must be right. Half of the stops fail.",
            ge=0,
            le=1,
        ),
    ] = 0.7
    max_level: Annotated[
        int, meta("Highest level", help="The delay of the cross adapts instead.", ge=1, le=1)
    ] = 1


class StopSignalDetails(Details, frozen=True):
    """Details of an arrow."""

    stop: Annotated[bool | None, "True if a cross was to follow the arrow."] = None
    delay_ms: Annotated[
        float | None, "From the arrow to the cross: as shown, or as planned if a key was sooner."
    ] = None


class StopSignalTask(Task):
    """Press the arrow key, or stop. The metric is the mean reaction time to arrows without a
    cross.
    """

    name = "stop_signal"
    title = "Stop in time"
    summary = "Press the arrow key of the arrow, but stop if a cross takes its place."
    trains = "Inhibition"
    trials = "Arrows"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    measured = (
        Measure("ssrt_ms", "time to stop", unit="ms", decimals=0),
        Measure("despite_cross", "pressed despite a cross", unit="%", decimals=0),
        Measure("next_delay_ms", "next delay of the cross", unit="ms", decimals=0),
    )
    Parameters = StopSignalParameters
    Details = StopSignalDetails
    parameters: StopSignalParameters

    @property
    def levels(self) -> int:
        return 1

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        return self.tr(
            "Press the left or the right arrow key, as the arrow points, as soon as you see it.\n"
            "If a cross takes its place, do not press.\nOften it comes too late. That is all "
            "right: do not wait for it."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        side = situation.streams.choice(("left", "right"), "side")
        text = self.tr("Press")
        if situation.streams.uniform("cross") >= self.parameters.crosses:
            return Stimulus(side, side, text, glyph=ARROWS[side], choices=2, data={"stop": False})
        before = [
            past.measures["next_delay_ms"]
            for past in situation.history
            if "next_delay_ms" in past.measures
        ]
        delay = next_delay_ms(situation.results) or (before[-1] if before else FIRST_MS)
        frames = (Frame(ARROWS[side], delay, text=text), Frame("✗", text=self.tr("Do not press")))
        data = {"stop": True, "side": side, "delay_ms": delay}
        return Stimulus(f"stop {side}", "", text, choices=2, frames=frames, data=data)

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        if percept.key not in ARROWS:
            return None
        return Result(
            correct=percept.key == trial.stimulus.expected,
            response=percept.key,
            response_at=percept.at,
            value=None if trial.stimulus.data["stop"] else trial.latency_ms(percept.at),
            details=_details(trial),
        )

    def timed_out(self, trial: Trial) -> Result:
        return Result(correct=trial.stimulus.data["stop"], details=_details(trial))

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return the time to stop (ms), the share of keys despite a cross (%), and the delay to go
        on with (ms).
        """
        pressed = [result.response is not None for result in results if result.details["stop"]]
        found = {"ssrt_ms": stop_signal_rt(results), "next_delay_ms": next_delay_ms(results)}
        found["despite_cross"] = 100 * fmean(pressed) if pressed else None
        return {name: value for name, value in found.items() if value is not None}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press the key, unless stopping ends sooner, which begins with the cross (Logan & Cowan
        1984).
        """
        if not stimulus.data["stop"]:
            return [
                (
                    performance.reaction_ms,
                    OTHER[stimulus.expected] if performance.slips else stimulus.expected,
                )
            ]
        stopped = stimulus.data["delay_ms"] + streams.generator("stop").gauss(STOP_MS, STOP_SD_MS)
        return (
            []
            if stopped < performance.reaction_ms
            else [(performance.reaction_ms, stimulus.data["side"])]
        )


def _details(trial: Trial) -> dict[str, Any]:
    delay = trial.stimulus.data.get("delay_ms")
    if len(trial.frames) > 1:
        delay = (trial.frames[1] - trial.frames[0]) / MS
    return {"stop": trial.stimulus.data["stop"], "delay_ms": delay}


def next_delay_ms(results: Sequence[Any]) -> float | None:
    """Return the delay of the next cross, from the last one and what became of it; None if there
    was no cross.
    """
    last = next((result for result in reversed(results) if result.details["stop"]), None)
    if last is None:
        return None
    step = STEP_MS if last.response is None else -STEP_MS
    return min(
        max(round(float(last.details["delay_ms"]) / STEP_MS) * STEP_MS + step, STEP_MS), LAST_MS
    )


def stop_signal_rt(results: Sequence[Any]) -> float | None:
    """Return the stop-signal reaction time, ms: by integration, with omissions as the slowest
    responses.

    Of all responses to arrows, as large a share comes before it as there are responses despite a
    cross; then the mean delay of crosses is taken off. A key before the cross counts as a response
    despite it. It is None if that share is not between 0.25 and 0.75, where it cannot be estimated
    well (Verbruggen et al. 2019).
    """
    crosses = [result for result in results if result.details["stop"]]
    arrows = [result for result in results if result.details["stop"] is False]
    found = [result.value for result in arrows if result.value is not None]
    share = fmean(result.response is not None for result in crosses) if crosses else 0.0
    if not found or not 0.25 <= share <= 0.75:
        return None
    times = sorted([*found, *[max(found)] * (len(arrows) - len(found))])
    return float(
        times[ceil(share * len(times)) - 1]
        - fmean(result.details["delay_ms"] for result in crosses)
    )
