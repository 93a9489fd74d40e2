"""Feedback schedules decide on which attempts feedback is given."""

from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sar_tui.model.messages import FeedbackChoice
from sar_tui.model.trial_types import Metric, Score, Target
from sar_tui.rules import feedback_choice, judgement
from sar_tui.rules.feedback import RAREST, History
from sar_tui.rules.judgement import JudgedAttempt
from sar_tui.rules.parameters import TaskParameters, build
from tests.facts import each, facts

TIME = Metric("time", unit="ms", better="lower")
GOAL = 1000.0
SCHEDULES = ("every", "faded", "bandwidth", "summary", "request", "none")
MEASURED = st.none() | st.floats(200, 3000)
RESULTS = st.lists(MEASURED | st.sampled_from([900.0, 1000.0, 1100.0]), max_size=60)
OUTCOMES = st.lists(st.sampled_from([500.0, 2000.0]), max_size=80)
"""Results that succeed or fail."""


def settings(schedule: str, **more: Any) -> TaskParameters:
    return build(TaskParameters, {"feedback_schedule": schedule, "threshold": GOAL, **more})


def judged(metric: float | None, accuracy: float | None = 1.0, goal: float = GOAL) -> JudgedAttempt:
    score, target = Score(metric, accuracy, 0, 20), Target(goal, 10.0)
    return JudgedAttempt(score, target, judgement.judge(score, TIME, target, 0.8))


def step(
    history: History, attempt: JudgedAttempt, parameters: TaskParameters, practice: bool = False
) -> tuple[History, FeedbackChoice]:
    """Remember an attempt and decide on its feedback, as a session does."""
    if not practice:
        history = feedback_choice.remember(history, attempt, parameters)
    choice = feedback_choice.choose(history, attempt, parameters, "results", practice=practice)
    return (feedback_choice.given(history) if choice.due and not practice else history), choice


def chosen(parameters: TaskParameters, *attempts: float | JudgedAttempt | None) -> Any:
    history, choices = History(), []
    for attempt in attempts:
        one = attempt if isinstance(attempt, JudgedAttempt) else judged(attempt)
        history, choice = step(history, one, parameters)
        choices.append(choice)
    return choices


def due(choices: list[FeedbackChoice]) -> list[int]:
    """Return the numbers of the attempts with feedback."""
    return [number for number, choice in enumerate(choices, 1) if choice.due]


# --- every, summary


@given(st.integers(1, 100), RESULTS, st.sampled_from(["every", "summary"]))
def test_every_nth_attempt_gets_feedback_regardless_of_the_outcomes(
    every: int, results: list[float | None], schedule: str
) -> None:
    choices = chosen(settings(schedule, feedback_every=every), *results)
    assert due(choices) == list(range(every, len(results) + 1, every))
    for number, choice in enumerate(choices):
        since = number % every + 1
        assert facts(choice, "since interval") == (since, every)
        if schedule == "every" and every > 1:
            assert choice.why == f"Due every {every} attempts; {since} since the last."


@given(st.integers(1, 20), RESULTS)
def test_a_summary_covers_exactly_the_attempts_since_the_last_one(
    every: int, results: list[float | None]
) -> None:
    parameters = settings("summary", feedback_every=every)
    history = History()
    for number, result in enumerate(results, 1):
        history = feedback_choice.remember(history, judged(result), parameters)
        choice = feedback_choice.choose(history, judged(result), parameters, "results")
        assert choice.attempts == (every if choice.due else 1)
        if choice.due:
            assert each(history.recent, "score.metric") == results[number - every : number]
            history = feedback_choice.given(history)


MANY = st.lists(st.tuples(MEASURED, st.floats(0, 1), st.floats(500, 2000)), min_size=1, max_size=20)


@given(MANY)
def test_a_summary_contains_the_means_and_counts_the_successes(
    attempts: list[tuple[float | None, float, float]],
) -> None:
    recent = tuple(judged(*attempt) for attempt in attempts)
    score, target, reached = judgement.summary(recent)
    measured = [(one, share, goal) for one, share, goal in attempts if one is not None]
    assert reached == sum(metric < goal and share >= 0.8 for metric, share, goal in measured)
    if measured:
        metrics, _, goals = zip(*measured, strict=True)
        assert score.metric == pytest.approx(sum(metrics) / len(measured))
        assert target.threshold == pytest.approx(sum(goals) / len(measured))
        assert target.neutral_band == pytest.approx(10.0)
    else:
        assert (score.metric, target) == (None, recent[-1].target)


@given(st.lists(st.tuples(MEASURED, st.sampled_from([0.25, 0.8, 1.0])), min_size=1, max_size=12))
def test_a_summary_takes_its_valence_from_the_majority_of_attempts(
    attempts: list[tuple[float | None, float]],
) -> None:
    recent = tuple(judged(*attempt) for attempt in attempts)
    verdict, _, _, reached = judgement.judge_summary(recent, TIME, 0.8)
    if verdict.valence == "positive":
        assert 2 * reached >= len(recent)
    if verdict.valence == "negative":
        assert 2 * reached <= len(recent)


# --- faded


@example([500.0] * 200, 6)
@given(OUTCOMES, st.integers(1, 10))
def test_faded_feedback_is_rarer_by_an_attempt_for_each_so_many_more_successes_than_failures(
    results: list[float], fade: int
) -> None:
    """Successes lengthen the interval only after the next feedback, a failure shortens it at
    once.
    """
    ahead = at_last = since = 0
    for result, choice in zip(
        results, chosen(settings("faded", feedback_fade=fade), *results), strict=True
    ):
        ahead = max(0, ahead + (1 if result < GOAL else -1))
        since += 1
        interval = min(RAREST, 1 + min(ahead, at_last) // fade)
        assert facts(choice, "since interval due") == (since, interval, since >= interval)
        if choice.due:
            since, at_last = 0, ahead


# --- bandwidth


@pytest.mark.parametrize(
    ("metric", "is_due"),
    [(899.9, True), (900.0, False), (1000.0, False), (1100.0, False), (1100.1, True), (None, True)],
)
def test_bandwidth_feedback_is_given_only_strictly_outside_the_tolerance(
    metric: float | None, is_due: bool
) -> None:
    (choice,) = chosen(settings("bandwidth", feedback_tolerance=10), metric)
    assert facts(choice, "due tolerance") == (is_due, 100.0)


def test_bounds_of_a_fractional_goal_are_within_the_tolerance() -> None:
    parameters = settings("bandwidth", feedback_tolerance=10)
    assert 0.7 * 1.1 - 0.7 > 0.07, "floating-point arithmetic puts this bound outside the tolerance"
    assert not chosen(parameters, judged(0.7 * 1.1, goal=0.7))[0].due


@given(st.floats(900, 1100), st.floats(0, 0.79))
def test_an_inaccurate_attempt_is_always_outside_the_tolerance(
    metric: float, accuracy: float
) -> None:
    (choice,) = chosen(settings("bandwidth"), judged(metric, accuracy))
    assert choice.due
    assert "right" in choice.why


# --- on request, never; practice


@given(RESULTS, st.sampled_from(["request", "none"]), st.booleans())
def test_on_request_and_none_never_give_feedback_without_a_request(
    results: list[float | None], schedule: str, practice: bool
) -> None:
    history = History()
    for result in results:
        history, choice = step(history, judged(result), settings(schedule), practice)
        assert not choice.due


@given(RESULTS, st.sampled_from(["every", "faded", "bandwidth", "summary"]), st.integers(1, 10))
def test_practice_always_gets_feedback_and_does_not_affect_the_schedule(
    results: list[float | None], schedule: str, every: int
) -> None:
    parameters = settings(schedule, feedback_every=every)
    history = History(since=2, skill=3, recent=(judged(700.0),))
    for result in results:
        after, choice = step(history, judged(result), parameters, practice=True)
        assert facts(choice, "due attempts") == (True, 1), "a summary does not include practice"
        assert after == history


# --- the stored decision


@given(RESULTS, st.sampled_from(SCHEDULES), st.integers(1, 10), st.floats(0, 1), st.booleans())
def test_every_attempt_records_its_feedback_decision_and_reason(
    results: list[float | None], schedule: str, every: int, accuracy: float, practice: bool
) -> None:
    compared = {"feedback_form": "quantitative", "feedback_compared_with": "best attempt"}
    parameters = settings(schedule, feedback_every=every, feedback_delay_ms=1500, **compared)
    delay_ms = 0 if schedule == "request" else 1500
    declared = (schedule, "results", "quantitative", "best attempt", delay_ms)
    history = History()
    for result in results:
        attempt = judged(result, accuracy)
        history, choice = step(history, attempt, parameters, practice)
        assert facts(choice, "schedule content form compared_with delay_ms") == declared
        assert choice.why.endswith(".")
        assert choice.why[0].isupper() or choice.why[0].isdigit()
        failed = result is None or accuracy < 0.8
        assert choice.degree == ("clear" if failed else judgement.degree(result, attempt.target))
