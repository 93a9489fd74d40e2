"""Analysis of one reach in a stretch of samples: all detectors and all measures, for storage beside
the raw data.
"""

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.model.trial_types import UNSURE
from sar_tui.motion.arrays import lengths
from sar_tui.motion.detection import DETECTORS, find
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.faults import turns_too_far
from sar_tui.motion.filters import TooSlow
from sar_tui.motion.fixed_threshold import FixedThresholdParameters
from sar_tui.motion.measures import MEASURES_VERSION, measure
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.reach import Bounds, Detected, Hand, Reach
from sar_tui.motion.rest import even
from sar_tui.motion.samples import Samples, recording
from sar_tui.motion.single_axis import SingleAxisParameters

Measured = dict[str, str | int | float | bool | None]

NS = 1e9
EARLY_NS = 500_000_000
"""A reach may begin this long before the participant starts the trial."""
HOLE_NS = 100_000_000
"""A longer time without samples is a hole."""
BESIDE_NS = 200_000_000
"""A hole this near to a reach may hide a part of it."""
SATURATED_NS = 300_000_000
"""Longest hole that is attributed to saturation, if the sensor reported saturation."""
_TIMES = {"reach_time_ms", "out_ms", "back_ms", "dwell_ms", "turn_after_ms"}
_ROUNDED = (
    "excursion_deg", "straightness", "return_error_deg", "inclination_rest_deg",
    "inclination_target_deg", "tremor_rest_hz", "tremor_rest_rad_s", "tremor_action_rad_s",
    "confidence",
)  # fmt: skip
DISAGREEMENT = 0.2
"""Difference of two detectors' times, as a share of the longer one, from which a reach's time is
doubtful.
"""
FEWEST = 10
"""Smallest number of samples that is analysed."""


class AnalysisParameters(msgspec.Struct, frozen=True, kw_only=True):
    """Settings of the analysis: the detector that counts, the hand, and each detector's parameters.

    ``least_confidence``: a reach of which the detector is less sure is flagged ``unsure``.
    """

    detector: DetectorName = "orientation"
    hand: Hand = "right"
    orientation: OrientationParameters = OrientationParameters()
    single_axis: SingleAxisParameters = SingleAxisParameters()
    fixed_threshold: FixedThresholdParameters = FixedThresholdParameters()
    least_confidence: float = 0.0

    @property
    def each(self) -> dict[DetectorName, msgspec.Struct]:
        """The parameters of every detector whose time is stored."""
        return {
            "orientation": self.orientation,
            "single-axis": self.single_axis,
            "fixed-threshold": self.fixed_threshold,
        }


class Window(msgspec.Struct, frozen=True, kw_only=True):
    """The stretch in which one reach is expected, in ns: samples in [from_ns, to_ns), the reach
    after started_ns.

    ``flags``: known faults of the samples (``saturated``, ``error``).
    """

    from_ns: int
    started_ns: int
    to_ns: int
    flags: tuple[str, ...] = ()


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """The reach found by the detector that counts. Without ``onset_ns`` there was no reach.

    ``invalid``: why there is no result: ``samples`` (too few), ``gap`` (samples are missing in the
    reach or beside it, not because of its speed), ``rate`` (too few per second), ``analysis`` (the
    detector that counts failed); otherwise empty.
    """

    onset_ns: int | None = None
    turn_ns: int | None = None
    end_ns: int | None = None
    details: Measured
    flags: tuple[str, ...] = ()
    invalid: str = ""


def analyse(samples: Samples, window: Window, parameters: AnalysisParameters) -> Finding:
    """Find the reach of a window by each detector, and measure it.

    If there are several, the fastest is taken and ``several`` is flagged; ``disagree`` if the time
    is doubtful, as the detectors of single axes and of orientations differ by more than 20 %;
    ``too_far`` if the hand would turn farther than it can. Quantities that the sensor could not
    measure
    are None.

    Args:
        samples: dtype SAMPLE, at least those of the window.
        window: where to look.
        parameters: the detectors' settings.
    """
    each = parameters.each
    at = samples["at"]
    is_inside = (at >= window.from_ns) & (at < window.to_ns)
    inside = samples if is_inside.all() else samples[is_inside]  # a copy of records is slow
    known: Measured = {
        "detector": parameters.detector,
        "detector_version": DETECTORS[parameters.detector].version,
        "detector_parameters": msgspec.json.encode(each[parameters.detector]).decode(),
        "hand": parameters.hand,
        "window_from_ns": window.from_ns,
        "window_started_ns": window.started_ns,
        "window_to_ns": window.to_ns,
        "samples": len(inside),
    }
    known["measures_version"] = MEASURES_VERSION
    if len(inside) < FEWEST:
        return Finding(details=known, invalid="samples", flags=window.flags)
    whole = recording(inside, window.from_ns, window.flags)
    known["rate_hz"] = round(whole.rate_hz, 3)
    grid = even(whole)
    reaches: tuple[Reach, ...] = ()
    times_ms: dict[DetectorName, float | None] = {}
    for name, its_parameters in each.items():
        try:
            found = find(whole, name, its_parameters, parameters.hand, grid)
        except Exception as error:  # whatever is wrong in a detector, the session goes on
            if name == parameters.detector:
                why = "rate" if isinstance(error, TooSlow) else "analysis"
                return Finding(details=known, invalid=why, flags=window.flags)
            times_ms[name] = known[f"{COLUMN_NAMES[name]}_reach_time_ms"] = None
            continue
        found = found._replace(
            reaches=tuple(bounds for bounds in found.reaches if _is_expected(bounds, window))
        )
        if name == parameters.detector:
            known["reaches"] = len(found.reaches)
        found = found._replace(reaches=_fastest(found))
        if name == parameters.detector:
            reaches = measure(found, whole)
        times_ms[name] = known[f"{COLUMN_NAMES[name]}_reach_time_ms"] = _reach_time_ms(found)
    too_far = turns_too_far(whole.time_s, whole.rate)
    reach = next(iter(reaches), None)
    holes = _holes(inside["at"], window)
    if reach is None:
        flags = (*window.flags, *(["too_far"] if too_far else []))
        return Finding(details=known, flags=flags, invalid="gap" if holes else "")
    warnings = {
        "several": known["reaches"] != 1,
        "disagree": _disagree(times_ms, parameters.detector),
        "too_far": too_far,
        UNSURE: reach.confidence is not None and reach.confidence < parameters.least_confidence,
    }
    flags = tuple(
        dict.fromkeys(
            (*window.flags, *reach.flags, *(name for name, holds in warnings.items() if holds))
        )
    )
    onset_ns, end_ns = _stamp(reach.onset_s, window), _stamp(reach.end_s, window)
    has_hole = any(
        first < end_ns + BESIDE_NS and last > onset_ns - BESIDE_NS for first, last in holes
    )
    return Finding(
        onset_ns=onset_ns,
        turn_ns=_stamp(reach.turn_s, window),
        end_ns=end_ns,
        details=known | measures(reach),
        flags=flags,
        invalid="gap" if has_hole else "",
    )


def measures(reach: Reach) -> Measured:
    """Return a reach as flat fields, times in ms. If the sensor was beyond its range, only the
    times are valid.
    """
    measured: Measured = {
        "reach_time_ms": round(reach.reach_time_s * 1000, 3),
        "out_ms": round(reach.out_s * 1000, 3),
        "back_ms": round(reach.back_s * 1000, 3),
        "dwell_ms": round(reach.dwell_s * 1000, 3),
        "turn_after_ms": round((reach.turn_s - reach.onset_s) * 1000, 3),
        "peak_extension_rad_s": reach.peak_extension_rad_s,
        "peak_return_rad_s": reach.peak_return_rad_s,
        "time_to_peak_ms": round(reach.time_to_peak_s * 1000, 3),
        "time_to_peak_share": round(reach.time_to_peak_s / reach.out_s, 4) if reach.out_s else None,
        "movement_units_out": reach.movement_units_out,
        "movement_units_back": reach.movement_units_back,
        "movement_units": reach.movement_units_out + reach.movement_units_back,
        "sparc_out": reach.sparc_out,
        "sparc_back": reach.sparc_back,
        "sparc": _mean(reach.sparc_out, reach.sparc_back),
        "ldlj_out": reach.ldlj_out,
        "ldlj_back": reach.ldlj_back,
        "tremor_index": reach.tremor_index,
    }
    values = {name: getattr(reach, name) for name in _ROUNDED}
    measured |= {name: None if value is None else round(value, 4) for name, value in values.items()}
    if not {"saturated", "clipped"}.isdisjoint(reach.flags):
        measured |= dict.fromkeys(measured.keys() - _TIMES)
    return measured


def _is_expected(bounds: Bounds, window: Window) -> bool:
    earliest_s = (window.started_ns - EARLY_NS - window.from_ns) / NS
    started_s = (window.started_ns - window.from_ns) / NS
    return bounds.onset_s >= earliest_s and bounds.end_s > started_s


def _fastest(found: Detected) -> tuple[Bounds, ...]:
    """Return the reach in which the hand turns fastest, about any axis; none if there is none."""
    if len(found.reaches) < 2:
        return found.reaches
    speed = lengths(found.rate)

    def peak(bounds: Bounds) -> float:
        first, last = np.searchsorted(found.time_s, (bounds.onset_s, bounds.end_s))
        return float(speed[first : last + 1].max(initial=0.0))

    return (max(found.reaches, key=peak),)


def _reach_time_ms(found: Detected) -> float | None:
    """Return the duration of the only reach; None without one."""
    return next(
        (round((bounds.end_s - bounds.onset_s) * 1000, 3) for bounds in found.reaches), None
    )


def _disagree(times_ms: dict[DetectorName, float | None], detector: DetectorName) -> bool:
    """Return True if the orientation and the single-axis detector differ by much in a reach that
    one of them scores.

    The fixed-threshold detector differs as it is defined, so it is not asked.
    """
    one, other = times_ms["orientation"], times_ms["single-axis"]
    if detector == "fixed-threshold" or one is None or other is None:
        return False
    return abs(one - other) > DISAGREEMENT * max(one, other)


def _holes(stamps: npt.NDArray[np.int64], window: Window) -> list[tuple[int, int]]:
    """Return the holes since the start of the reach, except those that saturation explains."""
    after = stamps[stamps >= window.started_ns - EARLY_NS]
    least = SATURATED_NS if "saturated" in window.flags else HOLE_NS
    return [
        (int(after[n]), int(after[n + 1])) for n in (after[1:] - after[:-1] > least).nonzero()[0]
    ]


def _stamp(seconds: float, window: Window) -> int:
    return window.from_ns + round(seconds * NS)


def _mean(one: float | None, other: float | None) -> float | None:
    known = [value for value in (one, other) if value is not None]
    return sum(known) / len(known) if known else None
