"""No part of a recording belongs to two reaches."""

from sar_tui.motion.detection import apart
from sar_tui.motion.reach import Bounds


def reach(onset_s: float, end_s: float) -> Bounds:
    middle_s = (onset_s + end_s) / 2
    return Bounds(
        onset_s=onset_s, arrival_s=middle_s, departure_s=middle_s, end_s=end_s, axis=(0.0, 0.0, 1.0)
    )


def times(*reaches: Bounds, since_s: float = 0.0) -> list[tuple[float, float]]:
    return [(bounds.onset_s, bounds.end_s) for bounds in apart(reaches, since_s)]


def test_reaches_with_a_rest_between_them_stay_as_they_are_in_order_of_time() -> None:
    assert times(reach(3.0, 4.0), reach(1.0, 2.0)) == [(1.0, 2.0), (3.0, 4.0)]


def test_estimated_boundaries_meet() -> None:
    assert times(reach(1.0, 2.0), reach(1.96, 3.0)) == [(1.0, 2.0), (2.0, 3.0)]


def test_the_same_movement_found_again_is_left_out() -> None:
    again = (reach(1.0, 2.0), reach(1.2, 3.0))
    assert times(reach(1.0, 2.0), *again, reach(3.5, 4.0)) == [(1.0, 2.0), (3.5, 4.0)]
    assert times(reach(1.0, 2.0), reach(1.95, 2.04)) == [(1.0, 2.0)]


def test_nothing_begins_before_the_end_of_what_was_found_already() -> None:
    assert times(reach(1.0, 2.0), reach(2.5, 3.0), since_s=1.5) == [(2.5, 3.0)]
    assert times(reach(1.0, 2.0), since_s=1.05) == [(1.05, 2.0)]
