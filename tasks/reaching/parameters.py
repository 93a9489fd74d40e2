"""Parameters of the reaching task."""

from itertools import pairwise
from typing import Annotated, Literal

from sar_tui.api.task import DetectorName, TaskParameters, meta

_FEW_CM, _MOST_CM = 1.0, 200.0


class ReachingParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the reaching task."""

    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 20
    reaches_per_attempt: Annotated[
        int, meta("Reaches per attempt", help="Number of reaches in an attempt.", ge=1, le=50)
    ] = 1
    imu: Annotated[
        str,
        meta(
            "Motion sensor",
            help="phidget, phidget://host:port, simulated, recorded:FILE, or session:ID.",
            min_length=1,
            personal=True,
        ),
    ] = "phidget"
    imu_trunk: Annotated[
        str,
        meta(
            "Trunk sensor",
            help="A second sensor, on the breastbone: named like the motion sensor. Empty: none.",
            personal=True,
        ),
    ] = ""
    trunk_limit_deg: Annotated[
        float,
        meta(
            "Trunk limit",
            "deg",
            "A reach in which the trunk turns farther is marked as compensated. 0: never.",
            ge=0,
            le=90,
        ),
    ] = 0.0
    hand: Annotated[
        Literal["right", "left"],
        meta("Hand", help="The hand that reaches, with the sensor on it.", personal=True),
    ] = "right"
    marker_distances_cm: Annotated[
        tuple[float, ...],
        meta(
            "Markers",
            "cm",
            "Distance of each marker from the start, nearest first. Each marker is a level.",
            personal=True,
        ),
    ] = (15.0, 20.0, 25.0, 30.0, 35.0, 40.0)
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "The mean reach time to the nearest marker must be below this; farther markers get "
            "more time.",
            ge=100,
            le=60_000,
        ),
    ] = 1200.0
    goal_times_ms: Annotated[
        tuple[float, ...],
        meta(
            "Own goals",
            "ms",
            "A goal for each marker, nearest first. Empty: made from Goal and the distances.",
        ),
    ] = ()
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "% of the goal",
            "Feedback is neutral within this distance of the goal.",
            ge=0,
            le=50,
        ),
    ] = 2.0
    feedback_on: Annotated[
        Literal["results", "performance", "both"],
        meta("Feedback on", help="The time (results), how the hand moved (performance), or both."),
    ] = "results"
    detector: Annotated[
        DetectorName,
        meta(
            "Detector",
            help="Finds the reach that counts. Results of all detectors are stored.",
        ),
    ] = "orientation"
    go_signal: Annotated[
        bool,
        meta(
            "Go signal",
            help="After Space a random wait, then a go signal. Measures reaction times.",
        ),
    ] = False
    still_ms: Annotated[
        int,
        meta(
            "Rest that ends a reach",
            "ms",
            "A reach followed by a rest this long needs no second press.",
            ge=1000,
            le=60_000,
        ),
    ] = 2500
    least_turn_deg: Annotated[
        float,
        meta(
            "Least turn",
            "deg",
            "Smallest turn of the hand on the way out, and on the way back.",
            ge=1,
            le=60,
        ),
    ] = 7.0
    thesis_threshold_rad_s: Annotated[
        float,
        meta(
            "Fixed threshold",
            "rad/s",
            "Rotation about z that is faster than this is movement.",
            ge=0.01,
            le=5,
        ),
    ] = 0.1
    thesis_still_ms: Annotated[
        int,
        meta(
            "Fixed threshold: rest",
            "ms",
            "Movement ends where a rest this long begins.",
            ge=50,
            le=5000,
        ),
    ] = 800
    min_accuracy: Annotated[
        float,
        meta(
            "Minimum accuracy",
            help="The share of reaches that must be complete, 0 to 1.",
            ge=0,
            le=1,
        ),
    ] = 0.8
    response_timeout_ms: Annotated[
        int,
        meta(
            "Reach time-out",
            "ms",
            "A reach without an end is over after this time.",
            ge=1000,
            le=600_000,
        ),
    ] = 20_000
    max_level: Annotated[
        int,
        meta(
            "Highest level",
            help="The level never rises above this or the last marker.",
            ge=1,
            le=100,
        ),
    ] = 10

    def problems(self) -> dict[str, str]:
        problems = super().problems()
        markers, goals = self.marker_distances_cm, self.goal_times_ms
        if not markers or any(not _FEW_CM <= marker <= _MOST_CM for marker in markers):
            problems["marker_distances_cm"] = (
                f"Markers are {_FEW_CM:g} to {_MOST_CM:g} cm away; name one or more."
            )
        elif any(far <= near for near, far in pairwise(markers)):
            problems["marker_distances_cm"] = (
                "Give the distances from the nearest marker to the farthest."
            )
        if goals and len(goals) != len(markers):
            problems["goal_times_ms"] = f"There are {len(markers)} markers, and {len(goals)} goals."
        elif any(not 100 <= goal <= 60_000 for goal in goals):
            problems["goal_times_ms"] = "Each goal lies between 100 and 60000 ms."
        if self.still_ms < self.thesis_still_ms + 200:
            problems["still_ms"] = (
                "Rest that ends a reach must be at least 200 ms longer than the rest of the "
                "fixed-threshold detector."
            )
        for name in ("start_level", "min_level"):
            if markers and getattr(self, name) > len(markers):
                problems[name] = (
                    f"There are {len(markers)} markers, so there is no level {getattr(self, name)}."
                )
        if self.trunk_limit_deg and not self.imu_trunk:
            problems["trunk_limit_deg"] = (
                "A trunk limit needs a trunk sensor: name it, or set the limit to 0."
            )
        return problems
