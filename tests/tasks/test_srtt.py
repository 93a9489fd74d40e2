"""The serial reaction time task: its order of places, what is learnt of it, and the effect of its
simulated people.
"""

from collections import Counter
from itertools import pairwise

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.messages import TrialEnded
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import PastAttempt, Score
from sar_tui.plugins import Catalogue
from sar_tui.validation.effects import effects, play


@pytest.fixture(scope="module")
def srtt() -> type[Task]:
    return Catalogue().task("srtt")


@pytest.fixture(scope="module")
def trials(srtt: type[Task], calm: Theme) -> list[TrialEnded]:
    """A session of four attempts, the last in random order."""
    (effect,) = (effect for kind, effect in effects(Catalogue()) if kind is srtt)
    return play(srtt, effect, calm, 1)


def keys(trials: list[TrialEnded], attempt: int) -> list[str]:
    return [trial.stimulus for trial in trials if trial.attempt == attempt]


def past(condition: str, metric: float | None) -> PastAttempt:
    return PastAttempt(1, False, 1, Score(metric, 1.0, 10, 10), condition=condition)


def test_three_attempts_repeat_one_sequence_of_twelve_whose_pairs_come_once(
    trials: list[TrialEnded],
) -> None:
    sequence = keys(trials, 1)[:12]
    for attempt in (1, 2, 3):
        assert keys(trials, attempt) == sequence * 5
    assert Counter(sequence) == dict.fromkeys("dfjk", 3)
    assert len(set(pairwise([*sequence, sequence[0]]))) == 12


def test_the_fourth_attempt_is_in_random_order_without_repetitions(
    trials: list[TrialEnded],
) -> None:
    found = keys(trials, 4)
    assert found[:12] != found[12:24]
    assert all(one != other for one, other in pairwise(found))
    assert set(found) == set("dfjk")
    assert {trial.data["order"] for trial in trials if trial.attempt == 4} == {"random"}


def test_learning_is_the_difference_from_the_last_attempt_with_the_sequence(
    srtt: type[Task],
) -> None:
    task = srtt(srtt.Parameters())
    history = [past("sequence", 700), past("sequence", 600), past("random", 650)]
    assert task.learning(past("random", 660), history) == {"learning_ms": 60}
    assert task.learning(past("sequence", 590), history) == {}
    assert task.learning(past("random", 660), []) == {}
    assert task.learning(past("random", None), history) == {}
