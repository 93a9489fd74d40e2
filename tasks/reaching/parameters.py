"""Parameters of the reaching task, and the details stored with a trial."""

from itertools import pairwise
from typing import Annotated, Literal

import msgspec

from sar_tui.api.task import Details, DetectorName, Sentence, TaskParameters, meta

_FEW_CM, _MOST_CM = 1.0, 200.0


class ReachDetails(Details, frozen=True):
    """Time stamps are in ns of the session's clock, durations in ms. None: could not be
    measured.
    """

    marker_cm: Annotated[
        float | None, msgspec.Meta(description="Distance of the marker, in cm.")
    ] = None
    closed: Annotated[
        str | None, msgspec.Meta(description="The end of the reach: key, stillness or timeout.")
    ] = None
    turn_ns: Annotated[int | None, msgspec.Meta(description="Time stamp of the turn, ns.")] = None
    detector: Annotated[
        str | None, msgspec.Meta(description="The detector whose reach counts.")
    ] = None
    detector_version: Annotated[
        str | None, msgspec.Meta(description="Version of the detector.")
    ] = None
    detector_parameters: Annotated[
        str | None, msgspec.Meta(description="Parameters of the detector, as JSON.")
    ] = None
    measures_version: Annotated[
        int | None, msgspec.Meta(description="Version of the measures; none means 1.")
    ] = None
    hand: Annotated[str | None, msgspec.Meta(description="The hand that reached.")] = None
    window_from_ns: Annotated[
        int | None, msgspec.Meta(description="First time stamp of the samples analysed.")
    ] = None
    window_started_ns: Annotated[
        int | None, msgspec.Meta(description="Time stamp of the key that started the reach.")
    ] = None
    window_to_ns: Annotated[
        int | None, msgspec.Meta(description="End of the samples analysed, exclusive.")
    ] = None
    samples: Annotated[int | None, msgspec.Meta(description="Number of samples analysed.")] = None
    rate_hz: Annotated[
        float | None, msgspec.Meta(description="Rate of the samples, from the median step.")
    ] = None
    reaches: Annotated[
        int | None, msgspec.Meta(description="Number of reaches found; the largest counts.")
    ] = None
    orientation_reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="By the orientation detector.")
    ] = None
    single_axis_reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="By the single-axis detector.")
    ] = None
    fixed_threshold_reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="By the fixed-threshold detector.")
    ] = None
    confidence: Annotated[
        float | None,
        msgspec.Meta(description="How sure the orientation detector is that it was one, 0 to 1."),
    ] = None
    reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="From movement onset to its end.")
    ] = None
    out_ms: Annotated[float | None, msgspec.Meta(description="The way out.")] = None
    back_ms: Annotated[float | None, msgspec.Meta(description="The way back.")] = None
    dwell_ms: Annotated[float | None, msgspec.Meta(description="The rest at the marker.")] = None
    turn_after_ms: Annotated[float | None, msgspec.Meta(description="From onset to the turn.")] = (
        None
    )
    peak_extension_rad_s: Annotated[
        float | None, msgspec.Meta(description="Fastest turning on the way out.")
    ] = None
    peak_return_rad_s: Annotated[
        float | None, msgspec.Meta(description="On the way back; negative.")
    ] = None
    time_to_peak_ms: Annotated[
        float | None, msgspec.Meta(description="From onset to the peak of the way out.")
    ] = None
    time_to_peak_share: Annotated[
        float | None, msgspec.Meta(description="The same as a share of the way out.")
    ] = None
    movement_units_out: Annotated[
        int | None, msgspec.Meta(description="Speed peaks on the way out.")
    ] = None
    movement_units_back: Annotated[
        int | None, msgspec.Meta(description="Speed peaks on the way back.")
    ] = None
    movement_units: Annotated[int | None, msgspec.Meta(description="Speed peaks on both ways.")] = (
        None
    )
    sparc_out: Annotated[
        float | None, msgspec.Meta(description="Smoothness, spectral arc length; way out.")
    ] = None
    sparc_back: Annotated[
        float | None, msgspec.Meta(description="Smoothness, spectral arc length; way back.")
    ] = None
    sparc: Annotated[float | None, msgspec.Meta(description="The mean of both.")] = None
    ldlj_out: Annotated[
        float | None, msgspec.Meta(description="Smoothness, log dimensionless jerk; way out.")
    ] = None
    ldlj_back: Annotated[
        float | None, msgspec.Meta(description="Smoothness, log dimensionless jerk; way back.")
    ] = None
    tremor_index: Annotated[
        float | None, msgspec.Meta(description="The share of 3-12 Hz in the movement.")
    ] = None
    excursion_deg: Annotated[
        float | None, msgspec.Meta(description="Largest angle from the orientation at the onset.")
    ] = None
    straightness: Annotated[
        float | None,
        msgspec.Meta(description="Way out: angle between its ends as a share of its path, 0 to 1."),
    ] = None
    return_error_deg: Annotated[
        float | None, msgspec.Meta(description="Angle between the orientations at onset and end.")
    ] = None
    inclination_rest_deg: Annotated[
        float | None, msgspec.Meta(description="Fingers above the horizontal before the reach.")
    ] = None
    inclination_target_deg: Annotated[
        float | None, msgspec.Meta(description="The same at the marker.")
    ] = None
    trunk_excursion_deg: Annotated[
        float | None,
        msgspec.Meta(description="Largest angle of the trunk from its orientation at the onset."),
    ] = None
    compensation_share: Annotated[
        float | None,
        msgspec.Meta(description="The same over the sum of it and the hand's excursion, 0 to 1."),
    ] = None
    tremor_rest_hz: Annotated[
        float | None, msgspec.Meta(description="Frequency of the tremor found at rest.")
    ] = None
    tremor_rest_rad_s: Annotated[
        float | None,
        msgspec.Meta(description="Amplitude at 3-12 Hz in the second before the reach."),
    ] = None
    tremor_action_rad_s: Annotated[
        float | None, msgspec.Meta(description="Amplitude at 6-12 Hz in the reach.")
    ] = None
    mark: Annotated[
        str | None,
        msgspec.Meta(description="The therapist's mark: missed, compensated, assisted or whole."),
    ] = None


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
            help="phidget, phyphox://host, udp://:port, serial://port, simulated, recorded:FILE, "
            "or session:ID.",
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
            "A result this close to the goal, on either side, is called neither good nor bad.",
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
        meta("Detector", help="Finds the reach that counts. Results of all detectors are stored."),
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
    reach_ends: Annotated[
        Literal["still", "home"],
        meta(
            "A reach ends",
            help="When the hand is still again, or home: back at the start, but for 15 % of the "
            "way. By the orientation detector.",
        ),
    ] = "still"
    least_turn_deg: Annotated[
        float,
        meta(
            "Least turn",
            "deg",
            "Smallest turn of the hand on the way out, and on the way back.",
            ge=1,
            le=60,
            personal=True,
        ),
    ] = 7.0
    least_confidence: Annotated[
        float,
        meta(
            "Least confidence",
            help="A reach of which the detector is less sure is not scored, until somebody marks "
            "it. 0: all are scored.",
            ge=0,
            le=1,
        ),
    ] = 0.6
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
            help="The share of reaches that must be complete.",
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
            problems["marker_distances_cm"] = Sentence(
                "Markers are {few} to {most} cm away; name one or more.",
                few=f"{_FEW_CM:g}",
                most=f"{_MOST_CM:g}",
            )
        elif any(far <= near for near, far in pairwise(markers)):
            problems["marker_distances_cm"] = Sentence(
                "Give the distances from the nearest marker to the farthest."
            )
        if goals and len(goals) != len(markers):
            text = "There are {markers} markers, and {goals} goals."
            problems["goal_times_ms"] = Sentence(text, markers=len(markers), goals=len(goals))
        elif any(not 100 <= goal <= 60_000 for goal in goals):
            problems["goal_times_ms"] = Sentence("Each goal lies between 100 and 60000 ms.")
        if self.still_ms < self.thesis_still_ms + 200:
            problems["still_ms"] = Sentence(
                "Rest that ends a reach must be at least 200 ms longer than the rest of the "
                "fixed-threshold detector."
            )
        for name in ("start_level", "min_level"):
            if markers and getattr(self, name) > len(markers):
                problems[name] = Sentence(
                    "There are {markers} markers, so there is no level {level}.",
                    markers=len(markers),
                    level=getattr(self, name),
                )
        if self.trunk_limit_deg and not self.imu_trunk:
            problems["trunk_limit_deg"] = Sentence(
                "A trunk limit needs a trunk sensor: name it, or set the limit to 0."
            )
        return problems
