"""Results of a detector: when a reach begins, turns and ends, and about which axis."""

from typing import Literal, NamedTuple

import msgspec

from sar_tui.motion.filters import Spectrum
from sar_tui.motion.samples import Floats

Hand = Literal["left", "right"]
"""The hand with the sensor, whose z axis points out of the back of the hand."""

OUTWARDS: dict[Hand, float] = {"right": 1.0, "left": -1.0}
"""Sign of the rotation about z on the way out (the thesis' Figure 4.8 shows a right hand)."""


class Bounds(msgspec.Struct, frozen=True, kw_only=True):
    """The times of one reach, in s since the recording's origin.

    ``arrival_s`` and ``departure_s``: when the hand arrives at the target and leaves it; equal, or
    slightly reversed, if it does not rest there. ``axis``: unit vector in the sensor's axes;
    rotation about it is positive on the way out. ``flags``: see Reach.
    """

    onset_s: float
    arrival_s: float
    departure_s: float
    end_s: float
    axis: tuple[float, float, float]
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
