"""The figures about difficulty policies: their probabilities, their claims, and a failure of each
claim.
"""

from statistics import fmean
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation import difficulty
from sar_tui.validation.difficulty import User, attempt_success, chances, prompt_success
from sar_tui.validation.report import Conditions, Row

FEW = range(1, 5)


def rows_of(catalogue: Catalogue, seeds: range) -> list[Row]:
    kind = catalogue.task("keyboard")
    keys = [2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 15, 18, 22, 26, 31, 38, 46, 54, 63, 72]
    return difficulty.compare(keys, kind.metric, kind.Parameters, Conditions(catalogue), seeds)


@pytest.fixture(scope="module")
def rows(catalogue: Catalogue) -> list[Row]:
    """The figures from few seeds: 160 attempts count for each."""
    return rows_of(catalogue, FEW)


def test_there_is_a_row_for_each_policy_user_and_state(rows: list[Row]) -> None:
    assert len(rows) == len(difficulty.POLICIES) * len(PEOPLE) * 2
    keys = {"policy", "user", "learning", "success_rate", "fitting", "level_sd", "at_bound"}
    assert all(set(row) == keys for row in rows)


def test_the_same_seeds_give_the_same_figures(catalogue: Catalogue, rows: list[Row]) -> None:
    assert rows_of(catalogue, FEW) == rows


def test_one_up_one_down_succeeds_half_the_time_and_rarely_fits(rows: list[Row]) -> None:
    found = [row for row in rows if row["policy"] == "one-up-one-down"]
    assert [row["success_rate"] for row in found] == pytest.approx([0.5] * 6, abs=0.05)
    assert max(row["fitting"] for row in found) < 0.5


@pytest.mark.parametrize("policy", ["target", "percentile"])
def test_target_and_percentile_succeed_in_seven_of_ten_and_mostly_fit(
    rows: list[Row], policy: str
) -> None:
    found = [row for row in rows if row["policy"] == policy]
    assert [row["success_rate"] for row in found] == pytest.approx([0.7] * 6, abs=0.1)
    assert fmean(row["fitting"] for row in found) >= 0.7


@pytest.mark.slow
def test_all_claims_hold_with_all_seeds(catalogue: Catalogue) -> None:
    claims = difficulty.run(Conditions(catalogue)).claims
    assert [claim for claim in claims if not claim.holds] == []


@pytest.mark.parametrize("name", PEOPLE)
@pytest.mark.parametrize("margin", [-60.0, 0.0, 25.0])
def test_the_probabilities_are_the_shares_of_many_attempts(name: str, margin: float) -> None:
    user = User(PEOPLE[name], learns=False, goal=1000.0)
    attempts = [chance.attempt(1, 1000.0 - margin, 1000.0) for chance in chances(user, 4000, 1)]
    reached = fmean(each.reached / each.prompts for each in attempts)
    assert reached == pytest.approx(prompt_success(user, margin), abs=0.01)
    succeeded = fmean(each.outcome == "success" for each in attempts)
    assert succeeded == pytest.approx(attempt_success(user, margin), abs=0.03)


def test_a_learner_is_a_third_faster_after_sixty_attempts() -> None:
    user = User(PEOPLE["poor"], learns=True, goal=1000.0)
    shares = [user.mean(2, attempt) / user.mean(2, 0) for attempt in (0, 30, 60, 90)]
    assert shares == pytest.approx([1, 0.825, 0.65, 0.65])


def row(policy: str, **figures: Any) -> Row:
    usual = {"success_rate": 0.5 if policy == "one-up-one-down" else 0.7, "fitting": 0.9}
    return {"policy": policy, "user": "poor", "learning": True, **usual, **figures}


@pytest.mark.parametrize(
    ("wrong", "sentence", "against"),
    [
        (row("one-up-one-down", success_rate=0.7), "one-up-one-down: about half", "one-up-one-down, poor, "
         "learning: 0.70"),
        (row("target", success_rate=0.9), "target: 7 of 10 prompts", "target, poor, learning: 0.90"),
        (row("percentile", fitting=0.5), "target and percentile: at least", "percentile, poor, learning: 0.50"),
    ],
)  # fmt: skip
def test_a_figure_out_of_range_fails_its_claim(wrong: Row, sentence: str, against: str) -> None:
    found = {
        claim.sentence: claim.against for claim in difficulty.claims([row("percentile"), wrong])
    }
    assert [text for said, text in found.items() if said.startswith(sentence)] == [against]
    assert sum(map(bool, found.values())) == 1
