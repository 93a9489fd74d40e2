"""Reaches are kept at whatever pace; movements that do not return, halves of rhythms and twitches
are not.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
import pytest

from sar_tui.motion.plausibility import plausible
from sar_tui.motion.reach import Bounds, Detected
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.rest import even, find_rest
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import scenarios
from sar_tui.motion.trajectories import simulate_reaches
from tests.examples import first
from tests.motion.wrist_motion import Angles, WristMotion


def _found(recording: Recording, times: Sequence[tuple[float, float]]) -> Detected:
    """Return what a detector would find that knows the true times."""
    grid = even(recording)
    rest = find_rest(grid.rate, grid.rate_hz, 1.0)
    z = (0.0, 0.0, 1.0)
    reaches = tuple(
        Bounds(onset_s=onset, arrival_s=onset, departure_s=end, end_s=end, axis=z)
        for onset, end in times
    )
    return Detected(grid.time_s, grid.rate - rest.bias, grid.rate_hz, reaches, rest.tremor_hz)


def _kept(recording: Recording, times: Sequence[tuple[float, float]]) -> int:
    return len(plausible(_found(recording, times)).reaches)


@pytest.mark.parametrize("seed", first(2, range(30)))
@pytest.mark.parametrize("kind", KINDS)
def test_a_reach_about_many_axes_is_kept(kind: str, seed: int) -> None:
    made = simulate_reaches(kind, seed, placement=seed % 4, arm="left" if seed % 2 else "right")
    assert _kept(made.recording, made.truth) == 1


@pytest.mark.parametrize("seed", first(1, range(10)))
def test_a_reach_under_any_difficulty_is_kept(seed: int) -> None:
    for scenario in scenarios():
        made = scenario.make(seed)
        assert _kept(made.recording, made.truth) == 1, scenario.name


@pytest.mark.parametrize("rest_s", [0.5, pytest.param(1.0, marks=pytest.mark.slow), 2.0])
@pytest.mark.parametrize("kind", first(2, KINDS))
def test_reaches_in_a_row_at_an_even_pace_are_kept(kind: str, rest_s: float) -> None:
    made = simulate_reaches(kind, 52, count=15, rest_s=rest_s)
    assert _kept(made.recording, made.truth) >= 14


@pytest.fixture
def motion() -> WristMotion:
    return WristMotion(12.0, 100.0, np.random.default_rng(7))


def test_a_movement_that_does_not_return_is_none(motion: WristMotion) -> None:
    motion.shift(4.0, (40.0, 0.0, 0.0), 1.0)
    motion.shift(5.5, (-15.0, 0.0, 0.0), 1.0)
    assert _kept(motion.measured(), [(4.0, 6.5)]) == 0


def test_a_reach_whose_onset_was_found_too_early_is_kept(motion: WristMotion) -> None:
    _out_and_back(motion, 3.0, (0.0, 40.0, 0.0))
    _out_and_back(motion, 6.0, (0.0, 40.0, 0.0))
    assert _kept(motion.measured(), [(3.0, 5.0), (5.0, 8.0)]) == 2


@pytest.mark.parametrize(("pause_s", "kept"), [(0.8, 1), (3.0, 0)])
def test_a_hand_may_set_something_down_before_it_comes_back(
    motion: WristMotion, pause_s: float, kept: int
) -> None:
    motion.shift(3.0, (60.0, 0.0, 0.0), 1.0)
    motion.shift(4.0, (-35.0, 0.0, 0.0), 1.0)
    motion.shift(5.0 + pause_s, (-25.0, 0.0, 0.0), 0.8)
    assert _kept(motion.measured(), [(3.0, 5.0)]) == kept


@pytest.mark.parametrize(("degrees", "kept"), [(8.0, 0), (12.0, 1)])
def test_a_small_gesture_is_none(motion: WristMotion, degrees: float, kept: int) -> None:
    _out_and_back(motion, 4.0, (0.0, degrees, 0.0))
    assert _kept(motion.measured(), [(4.0, 6.0)]) == kept


@pytest.mark.parametrize(("between", "kept"), [(0.7, 0), (0.3, 1)])
def test_two_excursions_are_not_one(motion: WristMotion, between: float, kept: int) -> None:
    motion.shift(4.0, (40.0, 0.0, 0.0), 1.0)
    motion.shift(5.0, (-40.0 * between, 0.0, 0.0), 0.8)
    motion.shift(5.8, (40.0 * between, 0.0, 0.0), 0.8)
    motion.shift(6.6, (-40.0, 0.0, 0.0), 1.0)
    assert _kept(motion.measured(), [(4.0, 7.6)]) == kept


def test_a_bout_of_a_rhythm_somewhere_else_and_a_swing_of_it_are_none(motion: WristMotion) -> None:
    motion.shift(3.0, (60.0, 0.0, 0.0), 1.0)
    motion.rhythm(3.5, 8.5, 1.0, (0.0, 25.0, 20.0), lags=(0.0, 0.0, 0.25))
    motion.shift(8.0, (-60.0, 0.0, 0.0), 1.0)
    assert _kept(motion.measured(), [(3.0, 9.0)]) == 0

    swinging = WristMotion(12.0, 100.0, np.random.default_rng(7))
    swinging.rhythm(3.0, 9.0, 0.5, (0.0, 25.0, 5.0))
    assert _kept(swinging.measured(), [(3.0, 4.0), (4.0, 5.0), (5.0, 6.0)]) == 0


@pytest.mark.parametrize("flag", ["cut", "gap"])
def test_a_reach_that_was_not_measured_whole_is_not_judged(motion: WristMotion, flag: str) -> None:
    motion.shift(4.0, (40.0, 0.0, 0.0), 1.0)
    found = _found(motion.measured(), [(4.0, 5.0)])
    assert plausible(found).reaches == ()
    (bounds,) = found.reaches
    flagged = found._replace(reaches=(msgspec.structs.replace(bounds, flags=(flag,)),))
    assert plausible(flagged) == flagged
    nothing = found._replace(reaches=())
    assert plausible(nothing) == nothing


def _out_and_back(motion: WristMotion, at_s: float, by: Angles) -> None:
    turn, elevation, rotation = by
    motion.shift(at_s, by, 1.0)
    motion.shift(at_s + 1.0, (-turn, -elevation, -rotation), 1.0)
