"""Staircases end at the share of right answers that the literature gives for them."""

import math
from random import Random
from statistics import fmean

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules.staircase import Staircase, weighted
from tests.examples import first_rows

TRIALS = 200


def sees_less_of_low_values(value: float) -> float:
    """The share of right answers of an observer for whom low values are hard."""
    return 1 / (1 + math.exp(-(value - 50) / 4))


def answers_to(staircase: Staircase, drawn: Random) -> list[bool]:
    """Return the answers of the observer, whose each prompt follows from those before."""
    answers: list[bool] = []
    for _ in range(TRIALS):
        answers.append(drawn.random() < sees_less_of_low_values(staircase.next(answers)))
    return answers


def share_right(staircase: Staircase) -> float:
    """Return the share of right answers in many tracks, each without its beginning."""
    drawn = Random(8)
    settled = [answer for _ in range(30) for answer in answers_to(staircase, drawn)[40:]]
    return fmean(settled)


RULES = [
    # up, down, share of right answers at rest (Levitt 1971, Table I)
    (1, 1, 0.5),
    (1, 2, 0.707),
    (2, 1, 0.293),
    (1, 3, 0.794),
    (3, 1, 0.206),
    (1, 4, 0.841),
]


@pytest.mark.parametrize(("wrong", "right", "share"), RULES)
def test_its_target_is_that_of_the_literature(wrong: int, right: int, share: float) -> None:
    assert Staircase(start=0, steps=(1,), wrong=wrong, right=right).target == pytest.approx(
        share, abs=5e-4
    )


@pytest.mark.parametrize(("wrong", "right", "share"), first_rows(2, RULES[1:4]))
def test_a_simulated_observer_ends_there(wrong: int, right: int, share: float) -> None:
    staircase = Staircase(start=55, steps=(4, 2, 1), wrong=wrong, right=right)
    assert share_right(staircase) == pytest.approx(share, abs=0.025)


@pytest.mark.slow
@pytest.mark.parametrize("target", [0.5, 0.75, 0.9])
def test_weighted_steps_end_at_any_share(target: float) -> None:
    staircase = weighted(target, start=55, steps=(1,))
    assert staircase.target == pytest.approx(target)
    assert share_right(staircase) == pytest.approx(target, abs=0.025)


def test_harder_may_be_higher() -> None:
    answers = [True, True, True, False, True, False, True, True]
    higher = Staircase(start=45, steps=(2, 1), harder="higher").track(answers)
    lower = Staircase(start=55, steps=(2, 1)).track(answers)
    assert [100 - value for value in higher.values] == list(lower.values)
    assert 100 - higher.next == lower.next


def test_the_steps_of_one_up_two_down() -> None:
    staircase = Staircase(start=10, steps=(4, 1))
    track = staircase.track([True, True, True, True, False, True, False, True, True])
    assert track.values == (10, 10, 6, 6, 2, 3, 3, 4, 4)
    assert track.reversals == (2, 4)
    assert track.next == 3


def test_the_threshold_is_the_mean_of_the_last_reversals() -> None:
    staircase = Staircase(start=10, steps=(4, 1))
    answers = [True, True, True, True, False, True, False, True, True]
    assert staircase.threshold(answers, 2) == 3
    assert staircase.threshold(answers, 4) is None
    assert staircase.threshold([]) is None


def test_the_threshold_is_that_of_the_observer() -> None:
    staircase = Staircase(start=60, steps=(4, 2, 1))
    found = staircase.threshold(answers_to(staircase, Random(8)), 20)
    at_target = 50 + 4 * math.log(staircase.target / (1 - staircase.target))
    assert found == pytest.approx(at_target, abs=2)


@given(st.lists(st.booleans(), max_size=60), st.integers(1, 3), st.integers(1, 3))
def test_values_stay_within_the_bounds(answers: list[bool], wrong: int, right: int) -> None:
    staircase = Staircase(start=2, steps=(3, 1), wrong=wrong, right=right, lowest=1, highest=6)
    track = staircase.track(answers)
    assert all(1 <= value <= 6 for value in (*track.values, track.next))
    assert len(track.values) == len(answers)
    assert [staircase.next(answers[:place]) for place in range(len(answers))] == list(track.values)


@pytest.mark.parametrize(
    "wrong_numbers",
    [{"steps": ()}, {"steps": (0,)}, {"right": 0}, {"easier": 0}, {"lowest": 1}, {"highest": -1}],
)
def test_numbers_that_make_no_staircase_are_refused(wrong_numbers: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="staircase"):
        Staircase(**{"start": 0.0, "steps": (1.0,), **wrong_numbers})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="share"):
        weighted(1.0, start=0, steps=(1,))
