"""Measures of reaches whose start and end are known, as those that were corrected by hand."""

from collections.abc import Sequence

import msgspec
import numpy as np

from sar_tui.motion.detection import CONTEXT_S, DETECTORS
from sar_tui.motion.labels import Label
from sar_tui.motion.measures import measure
from sar_tui.motion.quaternions import angle, conjugate, integrate, multiply, to_rotation
from sar_tui.motion.reach import Bounds, Detected, Hand, Reach
from sar_tui.motion.rest import even
from sar_tui.motion.samples import Samples, recording

SAME_S = 1e-6
"""Times that differ by less are the same."""
MOST = 0.5
"""A reach that was found gives the rest at the target of the labelled one if they share this much
of its time.
"""
_OF_OTHER_EDGES = {"gap", "cut", "timed_out", "endless"}
"""Flags that hold only between the edges which the detector has found."""


def measured(
    labels: Sequence[Label],
    found: Sequence[Reach],
    samples: Samples,
    detector: str = "orientation",
    hand: Hand = "right",
) -> tuple[Reach, ...]:
    """Return the labelled reaches with their measures, without those that were dropped.

    One that was found with the same edges has the measures that it has there. Others are measured
    in the samples around them, between the edges that they were given.

    Args:
        labels: in order of time.
        found: the reaches that the detector finds in the same samples.
        samples: of the recording.
        detector: its name in `detection.DETECTORS`.
        hand: the hand with the sensor.
    """
    known = {round(reach.onset_s / SAME_S): reach for reach in found}
    reaches = []
    for label in labels:
        if not label.counts:
            continue
        reach = known.get(round(label.start_s / SAME_S))
        if reach is None or abs(reach.end_s - label.end_s) > SAME_S:
            reach = measured_by_hand(label, samples, detector, hand)
        reaches.append(reach)
    return tuple(reaches)


def measured_by_hand(
    label: Label, samples: Samples, detector: str = "orientation", hand: Hand = "right"
) -> Reach:
    """Return one labelled reach with its measures. Raises ValueError if there are no samples."""
    at = samples["at"]
    times_s = (label.start_s - CONTEXT_S, label.start_s, label.end_s, label.end_s + CONTEXT_S)
    first, start, end, last = np.searchsorted(at, [round(time_s * 1e9) for time_s in times_s])
    if end - start < 2:
        raise _no_samples(label)
    origin_ns = int(at[first])
    origin_s = origin_ns / 1e9
    start_s, end_s = label.start_s - origin_s, label.end_s - origin_s
    window = recording(samples[first:last], origin_ns)
    grid = even(window)
    detected = DETECTORS[detector].find(window, None, hand, grid)
    bounds = _bounds(start_s, end_s, detected)
    if bounds is None:
        raise _no_samples(label)
    flags = tuple(flag for flag in bounds.flags if flag not in _OF_OTHER_EDGES)
    if grid.has_hole(start_s, end_s):
        flags += ("gap",)
    bounds = msgspec.structs.replace(bounds, confidence=label.confidence, flags=flags)
    (reach,) = measure(detected._replace(reaches=(bounds,)), window)
    return msgspec.structs.replace(
        reach, onset_s=label.start_s, turn_s=reach.turn_s + origin_s, end_s=label.end_s
    )


def _no_samples(label: Label) -> ValueError:
    return ValueError(
        f"A reach is labelled from {label.start_s:.2f} to {label.end_s:.2f} s, where there are no "
        "samples, so it cannot be measured: drop it (--correct)."
    )


def _bounds(start_s: float, end_s: float, detected: Detected) -> Bounds | None:
    """Return a reach between two times: with the target of the one that was found there, else with
    its turn where the hand is farthest from its start. None if there are no samples.
    """

    def shared_s(bounds: Bounds) -> float:
        return min(end_s, bounds.end_s) - max(start_s, bounds.onset_s)

    likely = max(detected.reaches, key=shared_s, default=None)
    if (
        likely
        and shared_s(likely) >= MOST * (end_s - start_s)
        and start_s < likely.arrival_s <= likely.departure_s < end_s
    ):
        return msgspec.structs.replace(likely, onset_s=start_s, end_s=end_s)
    first, last = np.searchsorted(detected.time_s, (start_s, end_s)).tolist()
    if first + 2 > len(detected.time_s):
        return None
    part = slice(first, max(last, first + 2))
    course = integrate(detected.rate[part], 1.0 / detected.rate_hz)
    turned = multiply(conjugate(course[0]), course)
    far = angle(turned)
    top = int(far.argmax())
    axis = to_rotation(turned[top]) / far[top] if far[top] > 0 else np.array((0.0, 0.0, 1.0))
    x, y, z = axis.tolist()
    turn_s = min(max(float(detected.time_s[part][top]), start_s), end_s)
    return Bounds(
        onset_s=start_s, arrival_s=turn_s, departure_s=turn_s, end_s=end_s, axis=(x, y, z)
    )
