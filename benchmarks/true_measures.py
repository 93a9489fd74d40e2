"""True measures of simulated reaches, from their trajectories, and measures between their true
boundaries.
"""

import numpy as np

from sar_tui.motion.body_model import Site
from sar_tui.motion.measures import measure
from sar_tui.motion.quaternions import angle, conjugate, multiply, rotate
from sar_tui.motion.reach import Bounds, Detected, Reach
from sar_tui.motion.rest import even, find_rest
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.synthesis import ReachShape
from sar_tui.motion.trajectories import SimulatedReaches

TRUTH_S = 0.002
"""Step in which the true orientation is followed."""
FINGERS = (0.0, 1.0, 0.0)
Z = (0.0, 0.0, 1.0)


def true_measures(simulated: SimulatedReaches, ideal: SimulatedReaches) -> dict[str, float | None]:
    """Return the measures of a reach between its true boundaries: angles of its trajectory, in
    degrees, and smoothness in the recording of an ideal sensor.
    """
    (times,) = simulated.times
    time_s = np.arange(times.onset_s, times.end_s, TRUTH_S)
    orientation = simulated.movement.pose(simulated.site, time_s).orientation
    turned = _turned_deg(orientation)
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
        "sparc_out": at_true_times(ideal).sparc_out,
    }


def at_true_times(simulated: SimulatedReaches) -> Reach:
    """Return the measures of a reach as recorded, between its true boundaries."""
    (times,) = simulated.times
    return measured_between(simulated.recording, Bounds(**times._asdict(), axis=Z))


def bounds_of(shape: ReachShape, onset_s: float = 2.0) -> Bounds:
    """Return the true boundaries of a reach about z."""
    arrival_s, end_s = onset_s + shape.out_s, onset_s + shape.duration_s
    departure_s = arrival_s + shape.dwell_s
    return Bounds(
        onset_s=onset_s, arrival_s=arrival_s, departure_s=departure_s, end_s=end_s, axis=Z
    )


def measured_between(recording: Recording, bounds: Bounds, *, by_norm: bool = True) -> Reach:
    """Return the measures of a reach between given boundaries, with bias and tremor from the
    rest.
    """
    grid = even(recording)
    rest = find_rest(grid.rate, grid.rate_hz, 1.0)
    found = Detected(
        grid.time_s, grid.rate - rest.bias, grid.rate_hz, (bounds,), rest.tremor_hz, by_norm
    )
    (reach,) = measure(found, recording)
    return reach


def true_trunk_excursion_deg(simulated: SimulatedReaches) -> float:
    """Return the largest angle of the sternum from its orientation at the true onset, up to the
    true end.
    """
    time_s = np.arange(*simulated.truth[0], TRUTH_S)
    return float(_turned_deg(simulated.movement.pose(Site("sternum"), time_s).orientation).max())


def _turned_deg(orientation: Floats) -> Floats:
    """Return the angle from the first orientation to each."""
    turned: Floats = np.degrees(angle(multiply(conjugate(orientation[:1]), orientation)))
    return turned
