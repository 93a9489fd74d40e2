"""Detection and measurement of the reaches in a recording."""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import msgspec

from sar_tui.motion import fixed_threshold, one_way, orientation, single_axis
from sar_tui.motion.detector_names import current_name
from sar_tui.motion.grid import Grid
from sar_tui.motion.measures import measure
from sar_tui.motion.plausibility import plausible
from sar_tui.motion.reach import Bounds, Detected, Hand, Reach
from sar_tui.motion.samples import Recording


class Detector(NamedTuple):
    """A way to find reaches.

    ``version`` changes whenever its results may change. ``is_quiet``: True if `detect` leaves out
    what it finds in daily life (`plausibility.plausible`).
    """

    version: str
    parameters: type[msgspec.Struct]
    find: Callable[[Recording, Any, Hand, Grid | None], Detected]
    is_quiet: bool = False


DETECTORS: dict[str, Detector] = {
    "orientation": Detector(
        "1", orientation.OrientationParameters, orientation.find, is_quiet=True
    ),
    "single-axis": Detector("1", single_axis.SingleAxisParameters, single_axis.find),
    "fixed-threshold": Detector(
        "1", fixed_threshold.FixedThresholdParameters, fixed_threshold.find
    ),
}


def detect(
    recording: Recording,
    detector: str = "orientation",
    parameters: msgspec.Struct | None = None,
    hand: Hand = "right",
    since_s: float = -math.inf,
) -> tuple[Reach, ...]:
    """Return the reaches in a recording of any content, in order of time. They do not overlap.

    A window of a session, in which a reach was asked for, is analysed by `analysis.analyse`, which
    judges less.

    Args:
        recording: the samples; best with at least a second of rest before the reach.
        detector: a name in ``DETECTORS``, or one of its earlier names.
        parameters: of that detector's type; its defaults if None.
        hand: the hand with the sensor.
        since_s: reaches that begin earlier are left out, as they were found in an earlier part.

    Raises ValueError for an unknown detector, another detector's parameters, or too low a sample
    rate.
    """
    found = find(recording, detector, parameters, hand)
    is_quiet = DETECTORS[current_name(detector)].is_quiet
    likely = plausible(found) if is_quiet else found
    return measure(likely._replace(reaches=apart(likely.reaches, since_s)), recording)


def detect_one_way(recording: Recording, since_s: float = -math.inf) -> tuple[Reach, ...]:
    """Return the movements in a recording from rest to rest without a way back (`one_way.find`), as
    `detect`.
    """
    found = one_way.find(recording)
    return measure(found._replace(reaches=apart(found.reaches, since_s)), recording)


def find(
    recording: Recording,
    detector: str = "orientation",
    parameters: msgspec.Struct | None = None,
    hand: Hand = "right",
    grid: Grid | None = None,
) -> Detected:
    """Return the boundaries of all excursions that may be a reach, without measuring them: much
    faster.

    Arguments and errors are those of `detect`.

    ``grid``: the recording's even grid (`grid.even`), if it is known.
    """
    chosen = DETECTORS.get(current_name(detector))
    if chosen is None:
        raise ValueError(
            f"There is no detector named {detector!r}; there are: {', '.join(DETECTORS)}."
        )
    if parameters is not None and not isinstance(parameters, chosen.parameters):
        raise ValueError(
            f"The detector {detector!r} takes {chosen.parameters.__name__}, not "
            f"{type(parameters).__name__}."
        )
    return chosen.find(recording, parameters, hand, grid)


MEET_S = 0.1
"""Two reaches without a rest between them overlap by less than this, as either's boundary is an
estimate.
"""


def apart(reaches: Iterable[Bounds], since_s: float = -math.inf) -> tuple[Bounds, ...]:
    """Return reaches in order of time, such that each begins at the end of the one before, or
    later.

    One that begins a little too early begins at that end instead. One that begins much earlier is
    the same movement found again, and is left out.

    Args:
        reaches: in any order.
        since_s: end of the last reach before them, in s.
    """
    kept: list[Bounds] = []
    for bounds in sorted(reaches, key=lambda bounds: bounds.onset_s):
        if bounds.onset_s < since_s - MEET_S or bounds.arrival_s <= since_s:
            continue
        kept.append(msgspec.structs.replace(bounds, onset_s=max(bounds.onset_s, since_s)))
        since_s = max(since_s, bounds.end_s)
    return tuple(kept)
