"""False reaches in simulated daily life are counted, and trips, which are reaches by their shape,
apart.
"""

import msgspec
import pytest

from sar_tui.motion.detection import detect
from sar_tui.motion.detector_names import COLUMN_NAMES
from sar_tui.motion.reach import Reach
from sar_tui.motion.synthesis import ReachShape, simulate
from sar_tui.motion.trajectories import simulate_reaches
from sar_tui.plugins import Catalogue
from sar_tui.validation.report import Conditions, Report
from tests.claims import quiet
from tests.examples import first
from tests.motion import daily_life
from tests.motion.daily_life import KINDS
from tests.motion.wrist_motion import Trip


@pytest.fixture(scope="module")
def reach() -> Reach:
    made = simulate([ReachShape(out_s=0.8, back_s=0.8)])
    (found,) = detect(made.recording)
    return found


def _at(reach: Reach, onset_s: float) -> Reach:
    by_s = onset_s - reach.onset_s
    return msgspec.structs.replace(
        reach, onset_s=onset_s, turn_s=reach.turn_s + by_s, end_s=reach.end_s + by_s
    )


def test_a_find_that_spans_a_trip_is_counted_as_one(reach: Reach) -> None:
    lasts_s = reach.reach_time_s
    for trip, is_one in (
        (Trip(10.0, 10.0 + lasts_s), True),
        (Trip(10.0 + 0.4 * lasts_s, 10.0 + 1.4 * lasts_s), True),
        (Trip(10.0 + 0.6 * lasts_s, 10.0 + 1.6 * lasts_s), False),
        (Trip(8.0, 20.0), False),
    ):
        assert quiet.count([_at(reach, 10.0)], [trip]) == ((0, 1) if is_one else (1, 0))


def test_reaches_that_overlap_are_counted(reach: Reach) -> None:
    lasts_s = reach.reach_time_s
    assert (
        quiet.overlapping([_at(reach, 1.0), _at(reach, 1.0 + lasts_s), _at(reach, 1.5 + lasts_s)])
        == 1
    )


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue) -> Report:
    monkeypatch.setattr(quiet, "QUICK_MINUTES", 0.5)
    return quiet.run(Conditions(catalogue, is_quick=True))


def test_every_kind_of_daily_life_is_tried_with_every_detector(short: Report) -> None:
    assert [row["kind"] for row in short.rows] == list(KINDS)
    for row in short.rows:
        assert row["minutes"] == 0.5
        for name in COLUMN_NAMES.values():
            assert row[f"{name}_false_per_minute"] >= 0.0
            assert row[f"{name}_trips"] <= row["trips"]


def test_a_detector_that_finds_reaches_in_walking_fails_the_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr(quiet, "QUICK_MINUTES", 0.5)
    monkeypatch.setattr(quiet, "JUDGED", "single-axis")
    claim, _ = quiet.run(Conditions(catalogue, is_quick=True)).claims
    assert not claim.holds
    assert "walking: " in claim.against


@pytest.mark.parametrize("kind", KINDS)
def test_the_default_detector_is_quiet_in_daily_life(kind: str) -> None:
    life = daily_life.simulate(kind, 1, minutes=3.0)
    found = detect(life.recording)
    assert quiet.count(found, life.trips).false < 3
    assert quiet.overlapping(found) == 0


@pytest.mark.slow
def test_all_claims_hold_on_ten_minutes_of_three_people(catalogue: Catalogue) -> None:
    report = quiet.run(Conditions(catalogue))
    assert [claim for claim in report.claims if not claim.holds] == []


@pytest.mark.parametrize("rest_s", [0.5, pytest.param(1.0, marks=pytest.mark.slow), 2.0])
@pytest.mark.parametrize(
    "kind", first(1, ["from-the-side", "cross-arm", "forearm-rotation", "two-hand-push"])
)
def test_the_default_detector_finds_every_reach_of_many_in_a_row(kind: str, rest_s: float) -> None:
    made = simulate_reaches(kind, 4, count=12, rest_s=rest_s)
    found = detect(made.recording)
    assert quiet.count(found, [Trip(*times) for times in made.truth]) == (0, 12)
