"""Encouragement before hard attempts, and rests at intervals."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.messages import AttemptEnded, Outcome
from sar_tui.rules.repetition import rest_due, why_hard

LEVELS = st.integers(1, 10)


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


ATTEMPTS = st.lists(
    st.builds(attempt, LEVELS, st.sampled_from(["success", "failure"])), max_size=10
)


@given(LEVELS)
def test_the_first_attempt_is_not_called_hard(level: int) -> None:
    assert why_hard([], level) == ""


@given(ATTEMPTS.filter(bool), LEVELS)
def test_an_attempt_is_hard_after_two_failures_or_at_a_new_level(
    attempts: list[AttemptEnded], level: int
) -> None:
    new = all(earlier.level < level for earlier in attempts)
    failing = len(attempts) > 1 and all(earlier.outcome == "failure" for earlier in attempts[-2:])
    assert why_hard(attempts, level) == ("failures" if failing else "new level" if new else "")


def test_one_failure_is_not_two() -> None:
    assert why_hard([attempt(3, "failure")], 2) == ""
    assert why_hard([attempt(3, "failure"), attempt(2, "failure")], 1) == "failures"
    assert why_hard([attempt(3, "failure"), attempt(2, "success")], 3) == ""


@given(st.integers(0, 200), st.integers(0, 200))
def test_a_rest_is_suggested_every_n_attempts_but_never_before_the_first(
    attempts: int, every: int
) -> None:
    assert rest_due(attempts, every) == (every > 0 and attempts in range(every, 201, every))
