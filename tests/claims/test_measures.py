"""Measures are compared with the truth of trajectories, and smoothness between sensors."""

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.validation.report import Conditions, Report
from tests.claims import measures, smoothness


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue) -> Report:
    monkeypatch.setattr(measures, "KINDS", ("cross-arm", "two-hand-push"))
    return measures.run(Conditions(catalogue, reaches=3))


def test_every_measure_has_its_errors_in_every_kind(few: Report) -> None:
    assert [row["scenario"] for row in few.rows] == ["cross-arm", "two-hand-push"]
    for row in few.rows:
        assert row["found"] <= row["reaches"] == 3
        for measure in measures.MEASURES:
            assert 0 <= row[f"{measure.name}_error_median"] <= row[f"{measure.name}_error_95"]
    assert all(claim.holds for claim in few.claims)


def test_a_measure_that_is_off_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr(measures, "KINDS", ("cross-arm",))
    true = measures.true_measures
    monkeypatch.setattr(
        measures, "true_measures", lambda *made: {**true(*made), "excursion_deg": 0.0}
    )
    failed = [
        claim for claim in measures.run(Conditions(catalogue, reaches=1)).claims if not claim.holds
    ]
    assert ["excursion_deg" in claim.sentence for claim in failed] == [True]
    assert failed[0].against.startswith("cross-arm: ")


def test_smoothness_is_measured_at_every_rate_and_noise(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr(smoothness, "RECORDINGS", 2)
    report = smoothness.run(Conditions(catalogue))
    assert len(report.rows) == len(smoothness.MOVEMENTS) * len(smoothness.RATES_HZ) * len(
        smoothness.NOISES_DEG_S
    )
    assert all(claim.holds for claim in report.claims)
