"""Trunk excursion, beside the true orientation of a simulated sternum."""

import math

import numpy as np
import pytest

from sar_tui.motion.body_model import Site
from sar_tui.motion.quaternions import angle, conjugate, multiply
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.trajectories import PLACEMENTS, SimulatedReaches, simulate_reaches
from sar_tui.perception.reach import trunk_excursion_deg


def lean(seed: int, placement: int = 0) -> tuple[SimulatedReaches, Recording]:
    made = simulate_reaches("trunk-lean", seed, placement=placement, sternum=True)
    assert made.sternum is not None
    return made, made.sternum


def true_excursion_deg(made: SimulatedReaches) -> float:
    time_s = np.linspace(*made.truth[0], 1000)
    orientation: Floats = made.movement.pose(Site("sternum"), time_s).orientation
    return math.degrees(float(angle(multiply(conjugate(orientation[:1]), orientation)).max()))


@pytest.mark.parametrize("placement", range(len(PLACEMENTS)))
def test_a_lean_is_measured_within_two_degrees_wherever_the_sensor_sits(placement: int) -> None:
    for seed in range(5):
        made, sternum = lean(seed, placement)
        excursion = trunk_excursion_deg(sternum, *made.truth[0])
        assert excursion == pytest.approx(true_excursion_deg(made), abs=2.0)


def test_a_trunk_that_stays_upright_has_hardly_any_excursion() -> None:
    made = simulate_reaches("two-hand-push", 4, sternum=True)
    assert made.sternum is not None
    excursion = trunk_excursion_deg(made.sternum, *made.truth[0])
    assert excursion is not None
    assert excursion < 2.0


def cut(recording: Recording, keep: np.ndarray) -> Recording:
    return Recording(time_s=recording.time_s[keep], rate=recording.rate[keep])


def test_a_sensor_lost_within_the_reach_or_never_at_rest_gives_no_excursion() -> None:
    made, sternum = lean(4)
    onset, end = made.truth[0]
    time = sternum.time_s
    middle = (onset + end) / 2.0
    hole, restless = (
        (time < middle) | (time > middle + 0.3),
        abs(time - middle) < end - middle + 0.2,
    )
    for keep in (time < middle, time > middle, hole, time < 0.0, restless):
        assert trunk_excursion_deg(cut(sternum, keep), onset, end) is None
