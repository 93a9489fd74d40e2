"""The flanker task: its rows, its score, and the effect of its simulated people."""

from statistics import fmean

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result
from sar_tui.plugins import Catalogue
from sar_tui.validation.effects import effects, play


@pytest.fixture(scope="module")
def flanker() -> type[Task]:
    return Catalogue().task("flanker")


def result(congruent: bool, value: float | None, correct: bool = True) -> Result:
    return Result(correct=correct, response="left", value=value, details={"congruent": congruent})


def test_the_conflict_is_the_difference_of_the_mean_times_of_correct_responses(
    flanker: type[Task],
) -> None:
    task = flanker(flanker.Parameters())
    results = [result(True, 400), result(True, 500), result(False, 540), result(False, 900, False)]
    assert task.measures(results) == {"conflict_ms": 90}
    assert task.measures(results[:2]) == {}


def test_rows_agree_or_disagree_as_their_data_say(flanker: type[Task], calm: Theme) -> None:
    (effect,) = (effect for kind, effect in effects(Catalogue()) if kind is flanker)
    trials = play(flanker, effect, calm, 1)
    for trial in trials:
        assert (trial.stimulus[0] == trial.stimulus[2]) is trial.data["congruent"]
        assert trial.stimulus[0] == trial.stimulus[1] == trial.stimulus[3] == trial.stimulus[4]
    assert 0.25 < fmean(trial.data["congruent"] for trial in trials) < 0.75
