"""The default detector finds hardly any reach in simulated daily life, where nobody reaches.

Trips, which are reaches by their shape, are no false reaches.
"""

from collections.abc import Sequence
from itertools import pairwise

import pytest

from sar_tui.motion.detection import detect
from sar_tui.motion.reach import Reach
from sar_tui.motion.trajectories import simulate_reaches
from tests.examples import first, first_rows
from tests.motion.daily_life import KINDS, MINUTES, simulate
from tests.motion.wrist_motion import Trip

SHARED = 0.5
"""A find is a trip if what they share is at least this part of either."""


@pytest.mark.parametrize(("people", "minutes"), first_rows(1, [(1, 3.0), (3, MINUTES)]))
@pytest.mark.parametrize("kind", KINDS)
def test_less_than_seven_false_reaches_in_ten_minutes_are_found_and_none_overlap(
    kind: str, people: int, minutes: float
) -> None:
    false = 0
    for seed in range(1, people + 1):
        life = simulate(kind, seed, minutes=minutes)
        found = detect(life.recording)
        false += len(found) - len(trips_among(found, life.trips))
        assert all(after.onset_s >= before.end_s for before, after in pairwise(found))
    assert false < 0.7 * people * minutes


@pytest.mark.parametrize("rest_s", first(1, [0.5, 1.0, 2.0]))
@pytest.mark.parametrize(
    "kind", first(1, ["from-the-side", "cross-arm", "forearm-rotation", "two-hand-push"])
)
def test_every_reach_of_many_in_a_row_is_found(kind: str, rest_s: float) -> None:
    made = simulate_reaches(kind, 4, count=12, rest_s=rest_s)
    found = detect(made.recording)
    assert len(found) == len(trips_among(found, [Trip(*times) for times in made.truth])) == 12


def trips_among(reaches: Sequence[Reach], trips: Sequence[Trip]) -> list[Reach]:
    return [reach for reach in reaches if any(is_same(reach, trip) for trip in trips)]


def is_same(reach: Reach, trip: Trip) -> bool:
    shared_s = min(reach.end_s, trip.to_s) - max(reach.onset_s, trip.from_s)
    return shared_s >= SHARED * max(reach.reach_time_s, trip.to_s - trip.from_s)
