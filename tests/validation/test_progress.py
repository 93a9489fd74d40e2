"""Simulated histories: the bands hold the truth, and practice alone is not called a change."""

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.validation import progress
from sar_tui.validation.report import Conditions, Report


@pytest.mark.slow
def test_all_claims_hold_on_more_than_two_thousand_histories(catalogue: Catalogue) -> None:
    report = progress.run(Conditions(catalogue))
    assert [claim for claim in report.claims if not claim.holds] == []
    assert sum(row["histories"] for row in report.rows if row["model"] == "only practice") >= 2000


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue) -> Report:
    monkeypatch.setattr(progress, "HISTORIES", 12)
    monkeypatch.setattr(progress, "OTHER_HISTORIES", 2)
    return progress.run(Conditions(catalogue))


def test_every_model_is_tried_with_every_user(few: Report) -> None:
    assert {(row["model"], row["user"]) for row in few.rows} == {
        (model, user) for model in progress.MODELS for user in ("poor", "average", "competent")
    }
    for row in few.rows[:3]:
        assert row["coverage"] > 0.85
        assert abs(row["bias_bits"]) < 0.1


def test_a_band_that_is_too_narrow_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr("sar_tui.progress.level_estimate.t95", lambda df: 0.5)
    monkeypatch.setattr(progress, "HISTORIES", 12)
    monkeypatch.setattr(progress, "OTHER_HISTORIES", 2)
    band, _ = progress.run(Conditions(catalogue)).claims
    assert not band.holds


def test_a_verdict_without_students_t_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr("sar_tui.progress.change.t95", lambda df: 0.5)
    monkeypatch.setattr(progress, "HISTORIES", 12)
    monkeypatch.setattr(progress, "OTHER_HISTORIES", 2)
    _, changed = progress.run(Conditions(catalogue)).claims
    assert not changed.holds
