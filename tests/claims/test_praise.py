"""Praise by chance and of a true change, on drawn attempts and in whole sessions."""

from statistics import fmean

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.rules.real_change import LEAST_ATTEMPTS, LEAST_TRIALS
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation.report import Claim, Conditions, Report
from tests.claims import praise, praised_sessions
from tests.claims.noise_worlds import WORLDS, sem


@pytest.mark.slow
def test_all_claims_hold_in_every_world_and_in_sessions(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr(praise, "QUICK_TASKS", tuple(praise.TASKS))
    assert [claim for claim in run(catalogue).claims if not claim.holds] == []


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(praise, "QUICK_PAIRS", 40)


def run(catalogue: Catalogue) -> Report:
    return praise.run(Conditions(catalogue, is_quick=True))


@pytest.mark.slow
@pytest.mark.usefixtures("few")
def test_each_world_is_tried_with_few_and_many_earlier_attempts(catalogue: Catalogue) -> None:
    rows = run(catalogue).rows
    assert {(row["world"], row["earlier"]) for row in rows} == {
        (world, earlier) for world in WORLDS for earlier in (2, 3, 5)
    }
    for row in rows:
        is_known = (
            row["earlier"] >= LEAST_ATTEMPTS and row["earlier"] * row["trials"] >= LEAST_TRIALS
        )
        assert (row["better_if_changed"] is not None) == is_known
    assert fmean(row["better_by_chance"] for row in rows) < 0.05


@pytest.mark.slow
@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(("margin", "fails"), [(0.3, [0]), (9.0, [1])])
def test_a_wrong_margin_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue, margin: float, fails: list[int]
) -> None:
    monkeypatch.setattr("sar_tui.rules.real_change.quantile", lambda df, share: margin)
    claims: list[Claim] = list(run(catalogue).claims)
    assert [number for number, claim in enumerate(claims) if not claim.holds] == fails


@pytest.mark.usefixtures("few")
def test_praise_after_one_earlier_attempt_fails_its_claim(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr("sar_tui.rules.real_change.LEAST_ATTEMPTS", 2)
    assert not run(catalogue).claims[2].holds


@pytest.mark.parametrize(
    ("world", "trials", "expected"), [("normal", 1, 1.0), ("normal", 4, 0.5), ("moments", 4, 0.86)]
)
def test_the_true_noise_of_a_world_is_known(world: str, trials: int, expected: float) -> None:
    assert sem(world, trials) == pytest.approx(expected, rel=0.05)


def test_sessions_with_nothing_trained_hear_no_praise_of_change_and_those_with_a_true_one_do(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    monkeypatch.setattr(praised_sessions, "QUICK_SEEDS", 2)
    row = praised_sessions.session_row(Conditions(catalogue, is_quick=True), "keyboard")
    assert (row["pairs"], row["changes"]) == (30, 6)
    assert row["better_by_chance"] <= 0.1
    assert row["better_if_changed"] >= 0.8


def test_nobody_hears_smoother_without_having_become_so(
    monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue, fewer_blocks: None
) -> None:
    monkeypatch.setattr(praised_sessions, "QUICK_SEEDS", 1)
    monkeypatch.setattr(praised_sessions, "PEOPLE", {"poor": PEOPLE["poor"]})
    row = praised_sessions.session_row(Conditions(catalogue, is_quick=True), "reaching")
    assert row["better_by_chance"] <= 0.1


def test_a_text_is_searched_for_every_word_of_improvement(catalogue: Catalogue) -> None:
    kind = catalogue.task("reaching")
    for text, better in (
        ("You had 0.9 seconds, faster than last time.", True),
        ("Your movement was 9 % smoother than last time.", True),
        ("You had 1.2 seconds, slower than last time.", False),
        ("Next time, try to do it as smoothly as you can.", False),
    ):
        assert praised_sessions.says_better(text, kind) == better
