"""Parameters of the task, and what is stored with each row of beats."""

from typing import Annotated

from sar_tui.api.task import Details, TaskParameters, meta


class TrackingTempoParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task."""

    imu: Annotated[
        str,
        meta(
            "Motion sensor",
            help="phidget, phidget://host:port, simulated, recorded:FILE, or session:ID.",
            min_length=1,
            personal=True,
        ),
    ] = "phidget"
    beats: Annotated[
        int,
        meta(
            "Beats", help="Number of beats in a row. The first three are heard only.", ge=8, le=60
        ),
    ] = 14
    prompts_per_attempt: Annotated[
        int, meta("Rows", help="Number of rows of beats in an attempt.", ge=1, le=20)
    ] = 2
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "%",
            "The variation about the beat must be below this share of its interval.",
            ge=1,
            le=50,
        ),
    ] = 7.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "%",
            "Feedback is neutral within this distance of the goal.",
            ge=0,
            le=20,
        ),
    ] = 0.2
    max_level: Annotated[
        int, meta("Highest level", help="Each level has a faster beat.", ge=1, le=6)
    ] = 6


class TrackingTempoDetails(Details, frozen=True):
    """Details of a row of beats."""

    asynchrony_ms: Annotated[
        float | None, "Mean time from a beat to the turn at it; negative: ahead of it."
    ] = None
    variation_ms: Annotated[float | None, "Standard deviation of these times."] = None
    followed: Annotated[float | None, "Share of beats with one turn near them, 0 to 1."] = None
    beat_ms: Annotated[float | None, "From beat to beat."] = None
