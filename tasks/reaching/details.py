"""Details stored with a reach."""

from typing import Annotated

import msgspec

from sar_tui.api.task import Details


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
    robust_reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="By the single-axis detector.")
    ] = None
    thesis_reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="By the fixed-threshold detector.")
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
        msgspec.Meta(description="The therapist's mark: missed, compensated or assisted."),
    ] = None
