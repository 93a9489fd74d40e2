"""Flankers, Posner's cueing and the serial reaction time task: their prompts and measures."""

from collections import Counter
from itertools import pairwise
from statistics import fmean

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.messages import TrialEnded
from sar_tui.model.trial_types import PastAttempt, Result, Score
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import ParameterError, build
from tests.tasks.conftest import EffectSession


def made(name: str) -> Task:
    kind = Catalogue().task(name)
    return kind(kind.Parameters())


def result(value: float, correct: bool = True, **details: bool) -> Result:
    return Result(correct=correct, response="left", value=value, details=details)


@pytest.mark.parametrize(
    ("task", "detail", "measure"),
    [("flanker", "congruent", "conflict_ms"), ("posner", "valid", "cueing_ms")],
)
def test_the_effect_is_the_difference_of_the_mean_times_of_correct_responses(
    task: str, detail: str, measure: str
) -> None:
    fast = [result(400, **{detail: True}), result(500, **{detail: True})]
    slow = [result(540, **{detail: False}), result(900, False, **{detail: False})]
    assert made(task).measures([*fast, *slow]) == {measure: 90}
    assert made(task).measures(fast) == {}


def test_flankers_agree_or_disagree_as_their_data_say(effect_session: EffectSession) -> None:
    trials = effect_session("flanker")
    for trial in trials:
        assert (trial.stimulus[0] == trial.stimulus[2]) is trial.data["congruent"]
        assert trial.stimulus[0] == trial.stimulus[1] == trial.stimulus[3] == trial.stimulus[4]
    assert 0.25 < fmean(trial.data["congruent"] for trial in trials) < 0.75


# --- Posner's cueing


def test_the_agent_cannot_look_before_the_wait_begins() -> None:
    with pytest.raises(ParameterError, match="longer than the shortest wait"):
        build(Catalogue().task("posner").Parameters, {"cue_lead_ms": 600})


def test_half_of_the_looks_are_valid_and_each_leads_as_set(effect_session: EffectSession) -> None:
    trials = effect_session("posner")
    assert 0.4 < fmean(trial.data["valid"] for trial in trials) < 0.6
    leads = [trial.details["lead_ms"] for trial in trials]
    assert leads == pytest.approx([300] * len(leads), abs=20)


# --- the serial reaction time task


def test_a_sequence_of_twelve_is_repeated_until_the_fourth_attempt_in_random_order(
    effect_session: EffectSession,
) -> None:
    trials = effect_session("srtt")
    sequence = keys(trials, 1)[:12]
    for attempt in (1, 2, 3):
        assert keys(trials, attempt) == sequence * 5
    assert Counter(sequence) == dict.fromkeys("dfjk", 3)
    assert len(set(pairwise([*sequence, sequence[0]]))) == 12, "each pair comes once"
    found = keys(trials, 4)
    assert found[:12] != found[12:24]
    assert all(one != other for one, other in pairwise(found))
    assert set(found) == set("dfjk")
    assert {trial.data["order"] for trial in trials if trial.attempt == 4} == {"random"}


def keys(trials: list[TrialEnded], attempt: int) -> list[str]:
    return [trial.stimulus for trial in trials if trial.attempt == attempt]


def test_learning_is_the_difference_from_the_last_attempt_with_the_sequence() -> None:
    def past(condition: str, metric: float | None) -> PastAttempt:
        return PastAttempt(1, False, 1, Score(metric, 1.0, 10, 10), condition=condition)

    task = made("srtt")
    history = [past("sequence", 700), past("sequence", 600), past("random", 650)]
    assert task.learning(past("random", 660), history) == {"learning_ms": 60}
    assert task.learning(past("sequence", 590), history) == {}
    assert task.learning(past("random", 660), []) == {}
    assert task.learning(past("random", None), history) == {}
