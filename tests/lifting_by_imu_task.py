"""Reaching with a motion sensor on the hand: out and back at a signal, as fast as possible."""

from typing import Annotated, Any

import msgspec

from sar_tui.api.task import (
    Act,
    Again,
    Details,
    Metric,
    Node,
    Performance,
    RandomStreams,
    ReachPerceived,
    Result,
    Situation,
    Stimulus,
    Target,
    Task,
    TaskParameters,
    Trial,
    meta,
)

# The goal of each level, as a share of the first level's.
GOALS = (1.0, 0.97, 0.94, 0.91, 0.88)


class LiftingParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task; see those of `TaskParameters`, which are inherited."""

    imu: Annotated[
        str,
        meta(
            "Motion sensor",
            help="phidget, phidget://host:port, simulated, or recorded:FILE.",
            min_length=1,
        ),
    ] = "phidget"
    prompts_per_attempt: Annotated[
        int, meta("Reaches", help="Number of reaches in an attempt.", ge=1, le=50)
    ] = 3
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "At level 1, the mean time of a reach must be below this.",
            ge=100,
            le=10_000,
        ),
    ] = 1500.0


class LiftingDetails(Details, frozen=True):
    """Details stored with each trial; other fields of `ReachPerceived.details` can be added."""

    reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="From movement onset to the end of the reach.")
    ]
    sparc: Annotated[float | None, msgspec.Meta(description="Smoothness of the reach (SPARC).")]


class LiftingTask(Task):
    """One trial is one reach. The metric is the time from movement onset to the end of the movement
    back.
    """

    name = "lifting"  # the folder has the same name
    title = "Reaching out"
    summary = "Reach out and back when the dot appears, as fast as you can."
    metric = Metric("reach_time", unit="ms", better="lower", improved="faster", worsened="slower")
    sensors = ("imu",)  # each session has a motion sensor, and stores all its samples
    Parameters = LiftingParameters
    Details = LiftingDetails
    parameters: LiftingParameters

    @property
    def levels(self) -> int:
        return len(GOALS)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def nodes(self) -> tuple[Node, ...]:
        """Return the node that finds reaches in the samples: the only place where a task may keep
        state.
        """
        # loads numpy, which other tasks do not need
        from sar_tui.api.task import AnalysisParameters, ReachPerception

        return (ReachPerception(AnalysisParameters(), 850),)  # ms of rest that end a reach

    def target(self, level: int) -> Target:
        return Target(self.parameters.threshold * GOALS[level - 1], self.parameters.neutral_band)

    def instructions(self) -> str:
        return (
            "Rest your hand on the table.\nWhen the dot appears, reach out and back as fast as "
            "you can."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        return Stimulus(name="reach", expected="", text="Reach out and back", glyph="●")

    def perceived(self, trial: Trial, percept: Any) -> Result | Again | None:
        """Judge a reach; keys are ignored."""
        if not isinstance(percept, ReachPerceived):
            return None
        if percept.invalid:
            return Again(
                percept.invalid, self.tr("The sensor missed a part of that. Please reach again.")
            )
        kept = {
            "reach_time_ms": percept.details.get("reach_time_ms"),
            "sparc": percept.details.get("sparc"),
        }
        if percept.onset is None or percept.end is None:
            return Result(correct=False, details=kept, flags=percept.flags)
        return Result(
            correct=True,
            response="reach",
            onset_at=percept.onset,
            response_at=percept.end,
            value=(percept.end - percept.onset) / 1e6,
            details=kept,
            flags=percept.flags,
        )

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Return a simulated reach, 1.1 s in a healthy adult. A slip is only a twitch."""
        from sar_tui.api.task import ReachShape

        if performance.slips:
            return [
                (
                    performance.reaction_ms,
                    ReachShape(out_s=0.15, back_s=0.15, peak_out=3.0, peak_back=-3.0),
                )
            ]
        out, back = 0.56 * performance.pace, 0.51 * performance.pace
        shape = ReachShape(
            out_s=out,
            back_s=back,
            dwell_s=0.3 * performance.unsteadiness * streams.uniform("dwell"),
            peak_out=0.94 / out,
            peak_back=-0.94 / back,
            seed=int(streams.uniform("shape") * 2**31),
        )
        return [(performance.reaction_ms, shape)]
