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


@pytest.fixture(scope="module")
def rows(catalogue: Catalogue) -> list[Row]:
    """The figures from few seeds: 160 attempts count for each."""
    kind = catalogue.task("keyboard")
    keys = [2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 15, 18, 22, 26, 31, 38, 46, 54, 63, 72]
    return difficulty.compare(
        keys, kind.metric, kind.Parameters, Conditions(catalogue), seeds=range(1, 5)
    )


def test_there_is_a_row_for_each_policy_user_and_state(rows: list[Row]) -> None:
    assert {(row["policy"], row["user"], row["learning"]) for row in rows} == {
        (policy, user, learning)
        for policy in difficulty.POLICIES
        for user in PEOPLE
        for learning in (False, True)
    }
    keys = {"policy", "user", "learning", "success_rate", "fitting", "level_sd", "at_bound"}
    assert all(set(row) == keys for row in rows)


@pytest.mark.parametrize(
    ("policy", "success", "within"),
    [("one-up-one-down", 0.5, 0.05), ("target", 0.7, 0.1), ("percentile", 0.7, 0.1)],
)
def test_policies_succeed_as_often_as_they_promise_and_targets_mostly_fit(
    rows: list[Row], policy: str, success: float, within: float
) -> None:
    found = [row for row in rows if row["policy"] == policy]
    assert [row["success_rate"] for row in found] == pytest.approx([success] * 6, abs=within)
    if policy == "one-up-one-down":
        assert max(row["fitting"] for row in found) < 0.5
    else:
        assert fmean(row["fitting"] for row in found) >= 0.7


@pytest.mark.slow
def test_all_claims_hold_with_all_seeds(catalogue: Catalogue) -> None:
    claims = difficulty.run(Conditions(catalogue)).claims
    assert [claim for claim in claims if not claim.holds] == []


@pytest.mark.parametrize("name", PEOPLE)
@pytest.mark.parametrize("margin", [-60.0, 25.0])
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


@pytest.mark.parametrize(
    ("policy", "wrong", "claim"),
    [
        ("one-up-one-down", {"success_rate": 0.56}, 0),
        ("one-up-one-down", {"success_rate": 0.44}, 0),
        ("target", {"success_rate": 0.76}, 1),
        ("percentile", {"success_rate": 0.64}, 1),
        ("percentile", {"fitting": 0.69}, 2),
    ],
)
def test_a_figure_out_of_range_fails_its_claim(
    policy: str, wrong: dict[str, float], claim: int
) -> None:
    right: dict[str, Any] = {"policy": policy, "user": "poor", "learning": True, "fitting": 0.7}
    right["success_rate"] = 0.5 if policy == "one-up-one-down" else 0.7
    assert all(each.holds for each in difficulty.claims([right]))
    against = [each.against for each in difficulty.claims([right, right | wrong])]
    (figure,) = wrong.values()
    expected = ["", "", ""]
    expected[claim] = f"{policy}, poor, learning: {figure:.2f}"
    assert against == expected
