"""Attempts of two participants: each has a score and feedback, and the level is shared."""

from typing import Any

import pytest

from sar_tui.loop.attempt_state import AttemptScore
from sar_tui.loop.attempts import Attempts
from sar_tui.model.trial_types import Result, Score
from sar_tui.rules.judgement import Judgement, judge_race
from sar_tui.rules.parameters import build
from tests.lifting_task import Lift, attempt


class Together(Lift):
    """Lifting task with two seats."""

    seats = ("A", "B")


def attempts(**parameters: Any) -> Attempts:
    return Attempts(
        Together(build(Together.Parameters, {"attempts": 4, "lifts": 1, **parameters})), seed=1
    )


def lift(value: float, correct: bool = True) -> Result:
    return Result(correct=correct, response="lift", value=value)


def each(scored: AttemptScore) -> dict[str, tuple[Any, ...]]:
    return {
        one.ended.seat: (one.ended.metric, one.ended.outcome, one.ended.feedback)
        for one in scored.seats
    }


@pytest.mark.parametrize(
    ("a", "b", "level"), [(500, 600, 2), (500, 1200, 1), (1200, 500, 1), (1200, 1300, 1)]
)
def test_each_seat_has_its_result_and_the_level_rises_if_both_reach_the_goal(
    a: float, b: float, level: int
) -> None:
    under_way = attempts()
    scored = attempt(under_way, {"A": lift(a), "B": lift(b)})
    assert [one.ended.metric for one in scored.seats] == [a, b]
    assert [one.ended.outcome for one in scored.seats] == [
        "success" if v < 1000 else "failure" for v in (a, b)
    ]
    assert [one.feedback.seat for one in scored.seats] == ["A", "B"]
    assert under_way.level == level


def test_the_level_falls_if_one_seat_misses_the_goal() -> None:
    under_way = attempts(start_level=3)
    assert attempt(under_way, {"A": lift(500), "B": lift(5000)}).level is not None
    assert under_way.level == 2


def test_feedback_schedules_are_counted_per_seat() -> None:
    under_way = attempts(feedback_schedule="bandwidth", feedback_tolerance=10.0, max_level=1)
    scored = attempt(under_way, {"A": lift(950), "B": lift(400)})
    assert [one.is_feedback_due for one in scored.seats] == [False, True]


REACHED, MISSED = (
    Judgement("success", "positive", "goal"),
    Judgement("failure", "negative", "missed"),
)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (3, 1, (("success", "positive", "won"), ("failure", "negative", "lost"))),
        (1, 3, (("success", "negative", "lost"), ("failure", "positive", "won"))),
        (2, 2, (("success", "neutral", "drawn"), ("failure", "neutral", "drawn"))),
        (0, 0, (("success", "positive", "goal"), ("failure", "negative", "missed"))),
        (None, None, (("success", "positive", "goal"), ("failure", "negative", "missed"))),
    ],
)
def test_feedback_on_a_race_tells_who_won_and_keeps_the_outcome(
    a: int | None, b: int | None, expected: tuple[tuple[str, str, str], ...]
) -> None:
    scores = {"A": Score(500, 1.0, 4, 4, a), "B": Score(1500, 1.0, 4, 4, b)}
    judged = judge_race(scores, {"A": REACHED, "B": MISSED})
    assert tuple((one.outcome, one.valence, one.reason) for one in judged.values()) == expected
