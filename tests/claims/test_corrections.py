"""Corrections by chance and of a true decline, on drawn attempts and in whole sessions."""

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.rules import real_change as decline
from sar_tui.validation.report import Conditions, Report
from tests.claims import corrections
from tests.claims.noise_worlds import WORLDS


@pytest.mark.slow
def test_all_claims_hold_in_every_world(catalogue: Catalogue) -> None:
    assert [each for each in run(catalogue).claims if not each.holds] == []


def run(catalogue: Catalogue) -> Report:
    return corrections.run(Conditions(catalogue, is_quick=True))


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(corrections, "QUICK_SESSIONS", 4)
    monkeypatch.setattr(corrections, "QUICK_DECLINES", 20)


@pytest.mark.usefixtures("few")
def test_each_world_has_its_rows(catalogue: Catalogue) -> None:
    rows = run(catalogue).rows
    assert {row["world"] for row in rows} == set(WORLDS)
    for row in rows:
        is_of_decline = row["earlier"] is not None
        assert (row["corrected_by_chance"] is None) == is_of_decline
        assert (row["found_within_3"] is not None) == is_of_decline
        if row["declines"]:
            assert row["found_within_1"] <= row["found_within_2"] <= row["found_within_3"]


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(
    ("name", "value", "fails"), [("LEAST_BASELINE", 2, [0, 2]), ("EACH", 9.0, [1])]
)
def test_a_rule_that_is_too_loose_or_too_strict_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue, name: str, value: float, fails: list[int]
) -> None:
    monkeypatch.setattr(decline, name, value)
    if name == "LEAST_BASELINE":
        monkeypatch.setattr(decline, "quantile", lambda df, share: 0.5)
        monkeypatch.setattr(decline, "EACH", 0.0)
    failed = [number for number, claim in enumerate(run(catalogue).claims) if not claim.holds]
    assert failed == fails


def test_steady_people_hear_no_corrections_by_chance_in_whole_sessions(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue, fewer_blocks: None
) -> None:
    monkeypatch.setattr(corrections, "PEOPLE", {"poor": corrections.PEOPLE["poor"]})
    row = corrections._sessions(Conditions(catalogue), 1)
    assert row["attempts"] == 20
    assert row["corrected_by_chance"] <= 0.05


def test_a_text_is_searched_for_every_aim(catalogue: Catalogue) -> None:
    kind = catalogue.task("reaching")
    assert corrections.names_a_correction("Next time, try to do it with a steady hand.", kind)
    assert not corrections.names_a_correction("Your movement was steadier than last time.", kind)
