"""The finger tapping test: one key, as fast as possible, for ten seconds.

After the test of the Halstead-Reitan battery, which counts the taps of the index finger in ten
seconds, five times. Its rate and regularity tell disorders of the cerebellum, the basal ganglia and
the cerebrum from healthy movement (Shimoyama, Ninchoji & Uemura 1990, Arch Neurol 47:681-684). A
terminal reports presses alone: how long a key is held is not known.
"""

from collections.abc import Sequence
from itertools import pairwise
from statistics import fmean, stdev
from typing import Annotated, Any

from sar_tui.api.task import (
    MS,
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
INTERVAL_MS = 160.0
"""Mean time between two taps of a healthy adult whose pace is 1."""
INTERVAL_SD = 0.07
"""Standard deviation of it, as a share."""
REACTION_MS = 350.0


class TappingParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the tapping task."""

    seconds: Annotated[
        float, meta("Duration", "s", "How long the taps are counted.", ge=2, le=60)
    ] = 10.0
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 5
    threshold: Annotated[
        float, meta("Goal", "taps", "The number of taps must be above this.", ge=1, le=1000)
    ] = 30.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "taps",
            "A result this close to the goal, on either side, is called neither good nor bad.",
            ge=0,
            le=100,
        ),
    ] = 1.0
    max_level: Annotated[
        int, meta("Highest level", help="All attempts are equally hard.", ge=1, le=1)
    ] = 1


class TappingDetails(Details, frozen=True):
    """Details of ten seconds of taps."""

    taps: Annotated[int | None, "Number of taps."] = None
    interval_ms: Annotated[float | None, "Mean time between two taps."] = None
    variation: Annotated[
        float | None, "Standard deviation of that time as a share of the mean."
    ] = None
    first_ms: Annotated[float | None, "From the signal to the first tap."] = None


class TappingTask(Task):
    """Tap the space bar. The metric is the number of taps."""

    name = "tapping"
    title = "Tapping"
    summary = "Tap the space bar as fast as you can, for ten seconds."
    trains = "Speed of movement"
    trials = "Rounds"
    metric = Metric(
        "taps", unit="", better="higher", improved="faster", worsened="slower", decimals=0
    )
    measured = (Measure("variation", "irregularity of the taps", unit="%", decimals=1),)
    Parameters = TappingParameters
    Details = TappingDetails
    parameters: TappingParameters

    @property
    def levels(self) -> int:
        return 1

    @property
    def switch_key(self) -> str:
        return KEY

    def instructions(self) -> str:
        seconds = f"{self.parameters.seconds:g}"
        return self.tr(
            "Put one finger on the space bar.\nWhen you see TAP, tap as fast as you can.\n"
            "Go on until it disappears, after {seconds} seconds.",
            seconds=seconds,
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        text = self.tr("Tap the space bar")
        return Stimulus(
            "tap", "", text, glyph=self.tr("TAP"), timeout_ms=self.parameters.seconds * 1000
        )

    def perceived(self, trial: Trial, percept: Any) -> None:
        """Wait for the end: the taps are counted then."""

    def timed_out(self, trial: Trial) -> Result:
        """Count the taps."""
        taps = [percept.at for percept in trial.percepts if percept.key == KEY]
        if not taps:
            return Result(correct=False, details={"taps": 0})
        between = [(later - earlier) / MS for earlier, later in pairwise(taps)]
        mean = fmean(between) if between else None
        return Result(
            correct=True,
            response=KEY,
            response_at=taps[-1],
            value=float(len(taps)),
            details={
                "taps": len(taps),
                "interval_ms": mean,
                "variation": stdev(between) / mean if mean and len(between) > 1 else None,
                "first_ms": trial.latency_ms(taps[0]),
            },
        )

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return the mean variation of the time between taps, in percent."""
        found = [
            float(value)
            for result in results
            if (value := result.details.get("variation")) is not None
        ]
        return {"variation": 100 * fmean(found)} if found else {}

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Tap until the end."""
        generator = streams.generator("taps")
        mean_ms, at = INTERVAL_MS * performance.pace, REACTION_MS
        acts: list[Act] = []
        while at < self.parameters.seconds * 1000:
            acts.append((at, KEY))
            at += max(80.0, generator.gauss(mean_ms, INTERVAL_SD * mean_ms))
        return acts
