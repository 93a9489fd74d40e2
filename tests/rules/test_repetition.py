"""Wordings that do not repeat what was just said, encouragement before hard attempts, and rests."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.messages import AttemptEnded, Outcome
from sar_tui.rules.repetition import least_repeating, repeated, rest_due, why_hard


def test_a_word_is_repeated_whatever_its_ending_but_not_a_word_that_is_everywhere() -> None:
    assert repeated("You reached the goal.", "0.40 seconds, and that reaches the goal.") == 2
    assert repeated("You had this.", "You had that.") == 0
    assert repeated("Ha alcanzado la meta.", "Meta alcanzada.") == 2


def test_what_is_said_in_the_same_breath_counts_more_than_what_was_said_before() -> None:
    wordings = {"a": "You reached the goal.", "b": "Well done.", "c": "Very good."}
    assert least_repeating(wordings, "Inside the goal.", "") == ["b", "c"]
    assert least_repeating(wordings, "Inside the goal.", "Well done. Inside the goal.") == ["c"]
    assert least_repeating({"a": "Well done."}, "Well done.", "") == ["a"]


def attempt(level: int, outcome: Outcome) -> AttemptEnded:
    return AttemptEnded(
        attempt=1,
        practice=False,
        level=level,
        metric=None,
        metric_unit="ms",
        accuracy=None,
        correct=0,
        trials=0,
        outcome=outcome,
        feedback="none",
        started=0,
        ended=0,
    )


@pytest.mark.parametrize(
    ("earlier", "level", "reason"),
    [
        ([], 9, ""),
        ([(3, "failure")], 2, ""),
        ([(3, "failure")], 3, ""),
        ([(3, "failure")], 4, "new level"),
        ([(4, "success"), (3, "success")], 4, ""),
        ([(3, "failure"), (2, "failure")], 1, "failures"),
        ([(3, "failure"), (2, "failure")], 4, "failures"),
        ([(3, "failure"), (2, "success")], 3, ""),
        ([(1, "success"), (3, "failure"), (2, "failure")], 1, "failures"),
    ],
)
def test_an_attempt_is_hard_after_two_failures_or_at_a_new_level(
    earlier: list[tuple[int, Outcome]], level: int, reason: str
) -> None:
    assert why_hard([attempt(*each) for each in earlier], level) == reason


@given(st.integers(0, 200), st.integers(0, 200))
def test_a_rest_is_suggested_every_n_attempts_but_never_before_the_first(
    attempts: int, every: int
) -> None:
    assert rest_due(attempts, every) == (every > 0 and attempts in range(every, 201, every))
