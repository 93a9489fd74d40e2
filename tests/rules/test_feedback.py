"""Outcome and valence of feedback depend only on score and goal."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.trial_types import Metric, Score, Target
from sar_tui.rules.judgement import Judgement, degree, judge
from sar_tui.rules.parameters import TaskParameters, build

TIME = Metric("time", unit="ms", better="lower")
TAPS = Metric("taps", unit="taps", better="higher")
P = build(TaskParameters, {"threshold": 1000, "neutral_band": 10, "min_accuracy": 0.8})

METRICS = st.one_of(st.none(), st.integers(0, 2000).map(float), st.floats(0, 2000))
ACCURACIES = st.one_of(st.none(), st.integers(0, 20).map(lambda right: right / 20))


def score(metric: float | None, accuracy: float | None = 1.0) -> Score:
    return Score(metric=metric, accuracy=accuracy, correct=0, trials=20)


def judged(score: Score, metric: Metric, parameters: TaskParameters) -> Judgement:
    return judge(
        score,
        metric,
        Target(parameters.threshold, parameters.neutral_band),
        parameters.min_accuracy,
    )


def test_a_result_equal_to_the_threshold_is_failure() -> None:
    sharp = build(TaskParameters, {"threshold": 1000, "neutral_band": 0})
    assert judged(score(1000.0), TIME, sharp).outcome == "failure"
    assert judged(score(1000.0), TAPS, sharp).outcome == "failure"
    assert judged(score(999.999), TIME, sharp) == Judgement("success", "positive", "goal")
    assert judged(score(1000.001), TAPS, sharp) == Judgement("success", "positive", "goal")


@pytest.mark.parametrize(
    ("metric", "expected"),
    [
        (989.999, Judgement("success", "positive", "goal")),
        (990.0, Judgement("success", "neutral", "band")),
        (999.9, Judgement("success", "neutral", "band")),
        (1000.0, Judgement("failure", "neutral", "band")),
        (1010.0, Judgement("failure", "neutral", "band")),
        (1010.001, Judgement("failure", "negative", "missed")),
    ],
)
def test_feedback_within_the_band_including_its_bounds_is_neutral(
    metric: float, expected: Judgement
) -> None:
    assert judged(score(metric), TIME, P) == expected


@pytest.mark.parametrize(
    ("metric", "expected"),
    [
        (1010.001, Judgement("success", "positive", "goal")),
        (1010.0, Judgement("success", "neutral", "band")),
        (990.0, Judgement("failure", "neutral", "band")),
        (989.999, Judgement("failure", "negative", "missed")),
    ],
)
def test_above_the_threshold_is_success_if_higher_is_better(
    metric: float, expected: Judgement
) -> None:
    assert judged(score(metric), TAPS, P) == expected


@pytest.mark.parametrize("metric", [None, 1.0, 995.0, 1005.0, 5000.0])
def test_below_the_minimum_accuracy_feedback_is_negative_and_names_accuracy(
    metric: float | None,
) -> None:
    assert judged(score(metric, 0.79), TIME, P) == Judgement("failure", "negative", "accuracy")
    assert judged(score(500.0, 16 / 20), TIME, P).outcome == "success"


def test_an_attempt_without_results_is_failure() -> None:
    assert judged(score(None, 1.0), TIME, P) == Judgement("failure", "negative", "empty")


def test_a_task_without_accuracy_is_judged_by_its_metric() -> None:
    assert judged(score(500.0, None), TIME, P) == Judgement("success", "positive", "goal")
    assert judged(score(None, None), TIME, P) == Judgement("failure", "negative", "empty")


@given(
    METRICS, ACCURACIES, st.sampled_from([TIME, TAPS]), st.integers(1, 2000), st.integers(0, 100)
)
def test_failure_is_never_praised_and_success_is_never_blamed(
    metric: float | None, accuracy: float | None, kind: Metric, threshold: int, band: int
) -> None:
    parameters = build(TaskParameters, {"threshold": threshold, "neutral_band": band})
    verdict = judged(score(metric, accuracy), kind, parameters)
    assert (verdict.valence, verdict.outcome) not in (
        ("positive", "failure"),
        ("negative", "success"),
    )
    enough = accuracy is None or accuracy >= 0.8
    better = metric is not None and (metric < threshold if kind is TIME else metric > threshold)
    assert (verdict.outcome == "success") == (enough and better)
    near = metric is not None and abs(metric - threshold) <= band
    assert (verdict.valence == "neutral") == (enough and near)


# --- distance from the goal


@pytest.mark.parametrize(
    ("metric", "expected"),
    [
        (1000.0, "slight"),
        (901.0, "slight"),
        (1099.0, "slight"),
        (900.0, "clear"),
        (1100.0, "clear"),
        (751.0, "clear"),
        (1249.0, "clear"),
        (750.0, "strong"),
        (1250.0, "strong"),
        (5000.0, "strong"),
    ],
)
def test_the_degree_grows_with_the_distance_from_the_goal(metric: float, expected: str) -> None:
    assert degree(metric, Target(1000.0, 10.0)) == expected


@pytest.mark.parametrize(("metric", "goal"), [(None, 1000.0), (12.0, 0.0)])
def test_without_a_result_or_a_goal_the_degree_is_the_middle_one(
    metric: float | None, goal: float
) -> None:
    assert degree(metric, Target(goal, 0.0)) == "clear"
