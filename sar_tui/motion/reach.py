"""A reach, out to a target and back, with its measures."""

from typing import Literal, NamedTuple

import msgspec

from sar_tui.motion.filters import Spectrum
from sar_tui.motion.samples import Floats


class Reach(msgspec.Struct, frozen=True, kw_only=True):
    """One reach. Times in s since the recording's origin, angular rates in rad/s about the reach's
    main axis.

    ``turn_s``: when the hand changes direction (the middle of the dwell). ``dwell_s``: rest at the
    target. ``peak_extension_rad_s`` is positive and ``peak_return_rad_s`` negative with the sensor
    placed as in the thesis' Figure 4.7. ``movement_units_*``: number of accelerations of each
    phase. ``sparc_*``, ``ldlj_*``: smoothness of each phase, nearer 0 is smoother; None if a phase
    is too short. ``tremor_index``: the share of 3-12 Hz in the reach's movement power, 0 to 1.
    ``flags``: warnings such as ``no_rest``, ``gap``, ``saturated``, ``cut``.

    ``confidence``, 0 to 1: how far the hand comes back, times how still it is before the reach and
    after; None from other detectors than ``orientation``.

    ``excursion_deg``: the largest angle from the orientation at the onset. ``straightness``: the
    angle between the orientations at onset and arrival as a share of the path between them, 0 to 1.
    ``return_error_deg``: the angle between those at onset and end; None without a way back.
    ``inclination_*_deg``: of the fingers above the horizontal, at rest before the reach and at the
    target; None without an accelerometer or that rest. ``tremor_rest_hz``: of the tremor found at
    rest, None without. ``tremor_rest_rad_s``, ``tremor_action_rad_s``: amplitude at 3-12 Hz in the
    second before the reach, and at 6-12 Hz in the reach; None if that is too short.
    """

    onset_s: float
    turn_s: float
    end_s: float
    reach_time_s: float
    out_s: float
    back_s: float
    dwell_s: float
    peak_extension_rad_s: float
    peak_return_rad_s: float
    time_to_peak_s: float
    movement_units_out: int
    movement_units_back: int
    sparc_out: float | None
    sparc_back: float | None
    ldlj_out: float | None
    ldlj_back: float | None
    tremor_index: float | None
    excursion_deg: float | None = None
    straightness: float | None = None
    return_error_deg: float | None = None
    inclination_rest_deg: float | None = None
    inclination_target_deg: float | None = None
    tremor_rest_hz: float | None = None
    tremor_rest_rad_s: float | None = None
    tremor_action_rad_s: float | None = None
    confidence: float | None = None
    flags: tuple[str, ...] = ()


Hand = Literal["left", "right"]
"""The hand with the sensor, whose z axis points out of the back of the hand."""

OUTWARDS: dict[Hand, float] = {"right": 1.0, "left": -1.0}
"""Sign of the rotation about z on the way out (the thesis' Figure 4.8 shows a right hand)."""


class Bounds(msgspec.Struct, frozen=True, kw_only=True):
    """The times of one reach, in s since the recording's origin.

    ``arrival_s`` and ``departure_s``: when the hand arrives at the target and leaves it; equal, or
    slightly reversed, if it does not rest there. ``axis``: unit vector in the sensor's axes;
    rotation about it is positive on the way out. ``confidence``, ``flags``: see Reach.
    """

    onset_s: float
    arrival_s: float
    departure_s: float
    end_s: float
    axis: tuple[float, float, float]
    confidence: float | None = None
    flags: tuple[str, ...] = ()


class Detected(NamedTuple):
    """A detector's result for a recording: the angular rate it used, and the reaches.

    ``time_s``: shape (n,), evenly spaced. ``rate``: shape (n, 3), rad/s, without the bias if the
    detector removes it. ``tremor_hz``: the tremor's frequency at rest; None without tremor, or if
    the detector does not look for it. ``by_norm``: the reaches turn about several axes, so peaks
    and smoothness are those of the norm of the rate. ``spectrum``: of the rate; None if the
    detector did not need it.
    """

    time_s: Floats
    rate: Floats
    rate_hz: float
    reaches: tuple[Bounds, ...]
    tremor_hz: float | None = None
    by_norm: bool = False
    spectrum: Spectrum | None = None
