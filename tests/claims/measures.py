"""True measures of simulated reaches, from their trajectories."""

import numpy as np

from sar_tui.motion.measures import measure
from sar_tui.motion.quaternions import angle, conjugate, multiply, rotate
from sar_tui.motion.reach import Bounds, Detected
from sar_tui.motion.trajectories import SimulatedReaches

TRUTH_S = 0.002
"""Step in which the true orientation is followed."""
FINGERS = (0.0, 1.0, 0.0)


def true_measures(simulated: SimulatedReaches, ideal: SimulatedReaches) -> dict[str, float | None]:
    """Return the measures of a reach between its true boundaries: angles of its trajectory, in
    degrees, and smoothness in the recording of an ideal sensor.
    """
    (times,) = simulated.times
    time_s = np.arange(times.onset_s, times.end_s, TRUTH_S)
    orientation = simulated.movement.pose(simulated.site, time_s).orientation
    turned = np.degrees(angle(multiply(conjugate(orientation[0]), orientation)))
    arrival, departure = np.searchsorted(time_s, (times.arrival_s, times.departure_s)).tolist()
    path = np.degrees(
        angle(multiply(conjugate(orientation[:arrival]), orientation[1 : arrival + 1]))
    ).sum()
    up = rotate(orientation[[0, (arrival + departure) // 2]], np.array(FINGERS))[:, 2]
    at_rest, at_target = np.degrees(np.arcsin(up)).tolist()
    return {
        "excursion_deg": float(turned[:departure].max()),
        "straightness": float(turned[arrival] / path),
        "return_error_deg": float(turned[-1]),
        "inclination_rest_deg": at_rest,
        "inclination_target_deg": at_target,
        "sparc_out": true_sparc(ideal),
    }


def true_sparc(ideal: SimulatedReaches) -> float | None:
    """Return the smoothness of the way out by the norm of the angular rate as recorded, between
    its true boundaries.
    """
    (times,) = ideal.times
    recording = ideal.recording
    bounds = Bounds(**times._asdict(), axis=(0.0, 0.0, 1.0))
    detected = Detected(
        recording.time_s, recording.rate, recording.rate_hz, (bounds,), by_norm=True
    )
    (reach,) = measure(detected, recording)
    return reach.sparc_out
