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
        Bounds(
            onset_s=onset,
            arrival_s=(onset + end) / 2,
            departure_s=(onset + end) / 2,
            end_s=end,
            axis=z,
        )
        for onset, end in times
    )
    return Detected(grid.time_s, grid.rate - rest.bias, grid.rate_hz, reaches, rest.tremor_hz)


def _kept(recording: Recording, times: Sequence[tuple[float, float]]) -> int:
    return len(plausible(_found(recording, times)).reaches)


@pytest.mark.parametrize("seed", first(2, range(30)))
@pytest.mark.parametrize("kind", KINDS)
def test_a_reach_about_many_axes_is_kept(kind: str, seed: int) -> None:
    made = simulate_reaches(kind, seed, placement=seed % 4, arm="left" if seed % 2 else "right")
    is_small = (kind, seed) == ("trunk-lean", 1)  # 10.5°, no more than a gesture
    assert _kept(made.recording, made.truth) == (0 if is_small else 1)


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


SMALL = [(4.0, 8.0, 1.0), (5.0, -8.0, 1.0)]
LARGER = [(4.0, 12.0, 1.0), (5.0, -12.0, 1.0)]
NO_RETURN = [(4.0, 40.0, 1.0), (5.5, -15.0, 1.0)]
SOON_BACK = [(3.0, 60.0, 1.0), (4.0, -35.0, 1.0), (5.8, -25.0, 0.8)]
LATE_BACK = [(3.0, 60.0, 1.0), (4.0, -25.0, 1.0), (8.0, -35.0, 0.8)]
TWO_WAYS = [(4.0, 40.0, 1.0), (5.0, -28.0, 0.8), (5.8, 28.0, 0.8), (6.6, -40.0, 1.0)]
ONE_WAY = [(4.0, 40.0, 1.0), (5.0, -12.0, 0.8), (5.8, 12.0, 0.8), (6.6, -40.0, 1.0)]


@pytest.mark.parametrize(
    ("shifts", "found", "kept"),
    [
        pytest.param(SMALL, (4.0, 6.0), 0, id="a small gesture"),
        pytest.param(LARGER, (4.0, 6.0), 1, id="a larger one"),
        pytest.param(NO_RETURN, (4.0, 6.5), 0, id="no return"),
        pytest.param(SOON_BACK, (3.0, 5.0), 1, id="back once something is set down"),
        pytest.param(LATE_BACK, (3.0, 5.0), 0, id="back much later"),
        pytest.param(TWO_WAYS, (4.0, 7.6), 0, id="two excursions"),
        pytest.param(ONE_WAY, (4.0, 7.6), 1, id="one that falters"),
    ],
)
def test_an_excursion_is_kept_if_it_is_one_large_enough_and_comes_back_soon(
    motion: WristMotion, shifts: list[Angles], found: tuple[float, float], kept: int
) -> None:
    """Each shift is its time (s), its turn (degrees) and its duration (s)."""
    for at_s, turn, takes_s in shifts:
        motion.shift(at_s, (turn, 0.0, 0.0), takes_s)
    assert _kept(motion.measured(), [found]) == kept


def test_a_reach_whose_onset_was_found_too_early_is_kept(motion: WristMotion) -> None:
    for at_s, elevation in ((3.0, 40.0), (4.0, -40.0), (6.0, 40.0), (7.0, -40.0)):
        motion.shift(at_s, (0.0, elevation, 0.0), 1.0)
    assert _kept(motion.measured(), [(3.0, 5.0), (5.0, 8.0)]) == 2


def test_a_bout_of_a_rhythm_somewhere_else_and_a_swing_of_it_are_none(motion: WristMotion) -> None:
    motion.shift(3.0, (60.0, 0.0, 0.0), 1.0)
    motion.rhythm(3.5, 8.5, 1.0, (0.0, 25.0, 20.0), lags=(0.0, 0.0, 0.25))
    motion.shift(8.0, (-60.0, 0.0, 0.0), 1.0)
    assert _kept(motion.measured(), [(3.0, 9.0)]) == 0

    swinging = WristMotion(12.0, 100.0, np.random.default_rng(7))
    swinging.rhythm(3.0, 9.0, 0.5, (0.0, 25.0, 5.0))
    assert _kept(swinging.measured(), [(3.0, 4.0), (4.0, 5.0), (5.0, 6.0)]) == 0


@pytest.mark.parametrize(
    ("left_deg", "smooth", "rubbing"), [(3.0, 1, 1), (17.0, 1, 0), (25.0, 0, 0)]
)
def test_a_hand_that_rubs_somewhere_must_come_back_nearer(
    motion: WristMotion, left_deg: float, smooth: int, rubbing: int
) -> None:
    """People scratch at 3 to 5 Hz (Moreau et al. 2018, IEEE J Biomed Health Inform 22:1011-1018)."""
    for at_s, turn in ((3.0, 45.0), (6.0, left_deg - 45.0)):
        motion.shift(at_s, (turn, 0.0, 0.0), 1.0)
    assert _kept(motion.measured(), [(3.0, 7.0)]) == smooth
    motion.rhythm(3.8, 6.2, 4.0, (3.0, 8.0, 3.0))
    assert _kept(motion.measured(), [(3.0, 7.0)]) == rubbing


def test_a_reach_that_was_not_measured_whole_is_not_judged(motion: WristMotion) -> None:
    motion.shift(4.0, (40.0, 0.0, 0.0), 1.0)
    found = _found(motion.measured(), [(4.0, 5.0)])
    assert plausible(found).reaches == ()
    (bounds,) = found.reaches
    flagged = found._replace(reaches=(msgspec.structs.replace(bounds, flags=("cut",)),))
    assert plausible(flagged) == flagged
    nothing = found._replace(reaches=())
    assert plausible(nothing) == nothing
