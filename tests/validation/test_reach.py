"""Simulated reaches are put to every detector, and counted where exactly one is found."""

import pytest

from sar_tui.motion.detector_names import COLUMN_NAMES
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.plugins import Catalogue
from sar_tui.validation import reach
from sar_tui.validation.report import Conditions, Report

SEEDS = 16
FINE = {
    "exactly_one_percent": 100.0, "endless_percent": 0.0, "onset_error_median_ms": 10.0,
    "error_median_ms": -20.0, "onset_error_iqr_ms": 30.0, "error_iqr_ms": 40.0,
}  # fmt: skip
"""Figures within the limits."""


@pytest.fixture(scope="module")
def kinds() -> dict[str, reach.Group]:
    return {group.name: group for group in reach.groups() if group.axes == "many"}


@pytest.fixture(scope="module")
def one_of_each(catalogue: Catalogue, kinds: dict[str, reach.Group]) -> Report:
    clean = next(group for group in reach.groups() if group.name == "clean")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reach, "groups", lambda: [clean, *kinds.values()])
        return reach.run(Conditions(catalogue, reaches=2))


def test_every_kind_is_made_with_either_arm_each_placement_and_either_sensor(
    kinds: dict[str, reach.Group],
) -> None:
    def is_positive_on_the_way_out(trial: reach.Trial) -> bool:
        after_s = trial.recording.time_s - trial.onset_s
        return bool(trial.recording.rate[(after_s > 0) & (after_s < 0.3)].mean(axis=0)[2] > 0)

    assert tuple(kinds) == KINDS
    trials = [kinds["cross-arm"].make(seed) for seed in range(SEEDS)]
    assert {trial.hand for trial in trials} == {"left", "right"}
    assert sum(trial.recording.acceleration is None for trial in trials) == SEEDS / 2
    for first, second in ((0, 1), (2, 5)):
        assert trials[first].recording.rate.tobytes() != trials[second].recording.rate.tobytes()
    signs = [is_positive_on_the_way_out(trial) for trial in trials]
    assert signs[:2] == [True, False], "a left hand swipes the other way"
    assert signs[4:6] == [False, True], "a sensor on the palm sees it the other way again"


def test_every_detector_has_its_share_and_its_errors_of_every_group(one_of_each: Report) -> None:
    rows = one_of_each.rows
    assert [row["scenario"] for row in rows] == ["clean", *KINDS]
    for row in rows:
        for name in COLUMN_NAMES.values():
            found = row[f"{name}_exactly_one_percent"]
            assert found in {0.0, 50.0, 100.0}
            for figure in ("error", "onset_error"):
                assert (row[f"{name}_{figure}_median_ms"] is None) == (found == 0.0)
    columns = [column for table in one_of_each.tables for column in table]
    printed = {column.head: column.show(rows[0]) for column in columns}
    assert printed["exactly one\nreach found, %"] == "clean"


def test_errors_are_those_of_a_reach_that_is_found_alone() -> None:
    def late(seed: int) -> reach.Trial:
        trial = swipe.make(seed)
        return trial._replace(onset_s=trial.onset_s - 1.0)

    swipe = next(group for group in reach.groups() if group.name == "cross-arm")
    right, wrong = (reach.row_of(group, 2) for group in (swipe, swipe._replace(make=late)))
    assert right["single_axis_exactly_one_percent"] == 100.0
    for figure, by_ms in (("error", -1000.0), ("onset_error", 1000.0)):
        difference = (
            wrong[f"single_axis_{figure}_median_ms"] - right[f"single_axis_{figure}_median_ms"]
        )
        assert difference == pytest.approx(by_ms)


@pytest.mark.parametrize(
    ("figure", "value", "says"),
    [
        ("exactly_one_percent", 49.0, "exactly one reach in 99 % or more, or in all but one"),
        ("endless_percent", 0.5, "endless"),
        ("onset_error_median_ms", -31.0, "onsets is within 30 ms"),
        ("error_median_ms", None, "durations is within 60 ms"),
        ("error_iqr_ms", 81.0, "durations' errors spans at most 80 ms"),
    ],
)
def test_a_kind_outside_the_limits_is_named_against_the_claim(
    one_of_each: Report, figure: str, value: float | None, says: str
) -> None:
    rows = [dict(row) for row in one_of_each.rows]
    for row in rows:
        row |= {f"orientation_{name}": fine for name, fine in FINE.items()}
    assert all(claim.holds for claim in reach.claims(rows))
    rows[-1][f"orientation_{figure}"] = value
    (failed,) = [claim for claim in reach.claims(rows) if not claim.holds]
    assert says in failed.sentence
    assert failed.against.startswith("point-and-hold: ")
