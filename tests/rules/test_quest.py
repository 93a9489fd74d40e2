"""The estimate of a threshold: exact for its own kind of observer, within the error that it
states.
"""

import math
from random import Random
from statistics import fmean

import pytest

from sar_tui.rules.quest import Quest
from tests.examples import first

QUEST = Quest(lowest=-3, highest=1, grain=0.05, start=-1, spread=1, slope=8)
MIRRORED = Quest(lowest=-1, highest=3, grain=0.05, start=1, spread=1, slope=8, harder="higher")


def observer(value: float, threshold: float) -> float:
    """The share of right answers of two-choice observer with a Weibull function, by its textbook
    form.
    """
    at_threshold = -math.log(1 - 0.25 / 0.48)
    strength = 10 ** (8 / math.log(10) * (value - threshold)) * at_threshold
    return 0.5 + 0.48 * (1 - math.exp(-strength))


def answers(threshold: float, seed: int) -> list[bool]:
    drawn, given = Random(seed), list[bool]()
    for _ in range(40):
        given.append(drawn.random() < observer(QUEST.next(given), threshold))
    return given


def test_the_first_prompt_is_the_first_guess() -> None:
    assert QUEST.next([]) == pytest.approx(-1)
    assert QUEST.estimate([]).sd == pytest.approx(0.88, abs=0.01)  # the grid cuts off its tails


def test_right_answers_make_it_harder_and_wrong_ones_easier() -> None:
    assert QUEST.next([True]) < QUEST.next([]) < QUEST.next([False])


def test_harder_may_be_higher() -> None:
    given = [True, True, False, True, False, False, True]
    for count in range(len(given)):
        assert MIRRORED.next(given[:count]) == pytest.approx(-QUEST.next(given[:count]))
    assert MIRRORED.estimate(given).mean == pytest.approx(-QUEST.estimate(given).mean)


@pytest.mark.parametrize("threshold", first(1, [-1.8, -0.4]))
def test_it_finds_the_threshold_within_the_error_that_it_states(threshold: float) -> None:
    found = [QUEST.estimate(answers(threshold, seed)) for seed in range(10)]
    errors = [estimate.mean - threshold for estimate in found]
    assert fmean(errors) == pytest.approx(0, abs=0.06)
    assert math.sqrt(fmean(error**2 for error in errors)) == pytest.approx(
        fmean(each.sd for each in found), rel=0.5
    )


def test_an_answer_is_weighed_by_bayes_rule() -> None:
    coarse = Quest(lowest=-1, highest=1, grain=1, start=0, spread=1, slope=8)
    prior = [math.exp(-0.5), 1.0, math.exp(-0.5)]
    weighed = [
        was * observer(0, threshold) for was, threshold in zip(prior, coarse.values, strict=True)
    ]
    assert coarse.posterior([True]) == pytest.approx([weight / sum(weighed) for weight in weighed])


def test_hundreds_of_equal_answers_leave_it_at_the_bound() -> None:
    assert QUEST.next([True] * 300) == pytest.approx(-3, abs=0.11)
    assert QUEST.next([False] * 300) == pytest.approx(1, abs=0.11)


@pytest.mark.parametrize(
    "wrong_numbers",
    [{"grain": 0}, {"grain": 9}, {"lowest": 2}, {"spread": 0}, {"slope": 0}, {"target": 0.4}],
)
def test_numbers_that_fit_no_observer_are_refused(wrong_numbers: dict[str, float]) -> None:
    right = {"lowest": -3, "highest": 1, "grain": 0.1, "start": 0, "spread": 1, "slope": 8}
    with pytest.raises(ValueError, match="the "):
        Quest(**{**right, **wrong_numbers})
