"""Attempts are scored against the goal of their level, amended, and given feedback as scheduled."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.attempts import Attempts
from sar_tui.model.trial_types import Result, Results, Target
from sar_tui.rules.judgement import degree
from sar_tui.rules.parameters import build
from tests.facts import facts
from tests.lifting_task import Lift, attempt


def session_attempts(**parameters: Any) -> Attempts:
    return Attempts(Lift(build(Lift.Parameters, {"attempts": 4, "lifts": 1, **parameters})), seed=1)


def lift(value: float, correct: bool = True, **details: Any) -> Results:
    return {"A": Result(correct=correct, response="lift", value=value, details=details)}


# --- goals of levels


@pytest.mark.parametrize(
    ("level", "value", "outcome", "valence"),
    [
        (1, 989.0, "success", "positive"),
        (1, 991.0, "success", "neutral"),
        (1, 1050.0, "failure", "negative"),
        (3, 1050.0, "success", "positive"),
        (3, 1189.0, "success", "positive"),
        (3, 1205.0, "failure", "neutral"),
        (3, 1211.0, "failure", "negative"),
    ],
)
def test_an_attempt_is_compared_with_the_goal_of_its_level(
    level: int, value: float, outcome: str, valence: str
) -> None:
    scored = attempt(session_attempts(start_level=level), lift(value))
    assert (scored.first.ended.outcome, scored.first.ended.feedback) == (outcome, valence)
    assert scored.first.feedback is not None
    assert scored.first.feedback.valence == valence
    assert scored.first.ended.goal == scored.first.feedback.goal == 1000 + 100 * (level - 1)


# --- knowledge of performance


def test_a_quality_is_the_mean_over_correct_trials_that_have_it() -> None:
    results = [
        lift(500, sway=2.0),
        lift(500, sway=4.0),
        lift(500, sway=None, grip=None),
        lift(500, correct=False, sway=90.0, grip=90.0),
    ]
    scored = attempt(session_attempts(lifts=4), *results).first
    assert scored.feedback is not None
    assert scored.ended.qualities == scored.feedback.qualities == {"sway": 3.0}


# --- amending


def test_nothing_is_amendable_before_a_trial_or_after_what_follows_has_begun() -> None:
    under_way = session_attempts()
    assert under_way.amendable_trial is None
    attempt(under_way, lift(500))
    assert under_way.amendable_trial == (1, 1)
    under_way.begin(now=3000)
    assert under_way.amendable_trial is None
    by_hand = session_attempts()
    attempt(by_hand, lift(500))
    by_hand.set_level(8, under_way=False)
    assert (by_hand.amendable_trial, by_hand.level) == (None, 8)


def test_amending_within_an_attempt_replaces_the_last_trial_and_scores_nothing() -> None:
    under_way = session_attempts(lifts=3)
    under_way.begin(now=0)
    under_way.add(lift(400))
    under_way.add(lift(500))
    assert under_way.amendable_trial == (1, 2)
    assert under_way.amend(lift(900)) is None
    assert [results["A"].value for results in under_way.state.results] == [400, 900]


@pytest.mark.parametrize("attempts", [1, 4])
def test_an_amended_attempt_is_scored_as_if_it_had_the_amended_results_from_the_start(
    attempts: int,
) -> None:
    under_way, at_once = (
        session_attempts(lifts=2, attempts=attempts, start_level=4) for _ in range(2)
    )
    said = attempt(under_way, lift(400), lift(500)).first.ended
    amended = under_way.amend(lift(500, correct=False))
    straight = attempt(at_once, lift(400), lift(500, correct=False))
    assert amended is not None
    assert straight.first.ended.feedback != said.feedback
    assert amended.first.ended.feedback == said.feedback
    assert facts(amended.first.ended, "metric correct outcome goal") == (
        straight.first.ended.metric,
        straight.first.ended.correct,
        straight.first.ended.outcome,
        straight.first.ended.goal,
    )
    expected = (at_once.attempt, at_once.trial, at_once.level)
    assert facts(under_way, "attempt trial level") == expected
    assert amended.level is not None
    assert (amended.level.previous, amended.level.level, amended.level.reason) == (5, 3, "mark")


@given(
    st.lists(st.booleans(), min_size=1, max_size=6),
    st.booleans(),
    st.integers(1, 3),
    st.integers(1, 3),
)
def test_after_repeated_amendments_only_the_last_counts(
    words: list[bool], first: bool, successes: int, failures: int
) -> None:
    rules = {"start_level": 3, "consecutive_successes": successes, "consecutive_failures": failures}
    under_way, at_once = session_attempts(**rules), session_attempts(**rules)
    said = attempt(under_way, lift(500, correct=first)).first.ended.feedback
    for correct in words:
        amended = under_way.amend(lift(500, correct=correct))
    attempt(at_once, lift(500, correct=words[-1]))
    assert amended is not None
    assert amended.first.ended.feedback == said
    for _ in range(3):
        assert (under_way.attempt, under_way.level) == (at_once.attempt, at_once.level)
        attempt(under_way, lift(500, correct=False))
        attempt(at_once, lift(500, correct=False))


def test_a_level_set_by_hand_in_an_attempt_survives_its_amendment() -> None:
    under_way = session_attempts(start_level=3)
    under_way.begin(now=0)
    under_way.set_level(8, under_way=True)
    under_way.add(lift(500))
    under_way.score(now=1)
    under_way.advance()
    amended = under_way.amend(lift(500, correct=False))
    assert amended is not None
    assert (
        amended.first.ended.level,
        amended.first.ended.outcome,
        amended.level,
        under_way.level,
    ) == (3, "failure", None, 8)


# --- feedback

SCHEDULES = ("every", "faded", "bandwidth", "summary", "request", "none")
STEPS = st.lists(
    st.tuples(st.floats(300, 2000), st.none() | st.booleans(), st.booleans()),
    min_size=1,
    max_size=15,
)


@given(st.sampled_from(SCHEDULES), STEPS, st.integers(1, 4), st.integers(0, 3))
def test_attempts_since_the_last_feedback_are_counted_despite_amendments_and_requests(
    schedule: str, steps: list[tuple[float, bool | None, bool]], every: int, practice: int
) -> None:
    under_way = session_attempts(
        attempts=15,
        practice_attempts=practice,
        feedback_schedule=schedule,
        feedback_every=every,
        feedback_fade=1,
        difficulty_policy="fixed",
    )
    since = 0
    for number, (value, amended, asks) in enumerate(steps, 1):
        scored = attempt(under_way, lift(value))
        choice = scored.first.ended.choice
        assert choice is not None
        since += number > practice
        assert choice.since == since
        assert scored.first.is_feedback_due == choice.due == (scored.first.ended.feedback != "none")
        if amended is not None:
            again = under_way.amend(lift(value, correct=amended))
            assert again is not None
            expected = (choice, scored.first.ended.feedback)
            assert facts(again.first.ended, "choice feedback") == expected
        asked = under_way.request_feedback(now=3000) if asks else None
        assert (asked is not None) == (asks and schedule == "request")
        if (choice.due and number > practice) or asked:
            since = 0


@given(st.lists(st.floats(300, 2000), min_size=12, max_size=12), st.integers(2, 6))
def test_a_summary_reports_the_means_of_its_attempts(values: list[float], every: int) -> None:
    settings = {
        "feedback_schedule": "summary",
        "feedback_every": every,
        "difficulty_policy": "fixed",
    }
    under_way = session_attempts(attempts=12, **settings)
    for number, value in enumerate(values, 1):
        scored = attempt(under_way, lift(value))
        assert scored.first.is_feedback_due == (number % every == 0)
        assert facts(scored.first.ended, "metric choice") == (value, scored.first.feedback.choice)
        if scored.first.is_feedback_due:
            last = values[number - every : number]
            mean = sum(last) / every
            assert scored.first.feedback.metric == pytest.approx(mean)
            assert scored.first.feedback.reached == sum(value < 1000 for value in last)
            assert scored.first.feedback.choice.attempts == every
            assert scored.first.feedback.choice.degree == degree(
                scored.first.feedback.metric, Target(1000.0, 10.0)
            )
            assert scored.first.ended.feedback == scored.first.feedback.valence


def test_a_level_settled_during_an_attempt_applies_to_the_next_with_its_original_reason() -> None:
    under_way = session_attempts()
    changed = attempt(under_way, lift(400.0)).level
    assert changed
    under_way.hold(changed)
    assert under_way.level == 1
    under_way.begin(now=3000)
    settled = under_way.settle(2, under_way=True)
    assert settled is not None
    expected = (1, 2, "success", 1)
    assert (settled.previous, settled.level, settled.reason, under_way.level) == expected
    under_way.add(lift(5000.0))
    under_way.score(now=4000)
    assert under_way.level == 1, "the failure lowers the level that was settled"
