"""Posner's cueing task: the agent's look before the star, its score, and the effect of its
simulated people.
"""

from statistics import fmean

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Result
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import ParameterError, build
from sar_tui.validation.effects import effects, play


@pytest.fixture(scope="module")
def posner() -> type[Task]:
    return Catalogue().task("posner")


def result(valid: bool, value: float, correct: bool = True) -> Result:
    return Result(
        correct=correct, response="left", value=value, details={"valid": valid, "lead_ms": 300.0}
    )


def test_the_effect_is_the_difference_of_the_mean_times_of_correct_responses(
    posner: type[Task],
) -> None:
    task = posner(posner.Parameters())
    results = [result(True, 400), result(True, 440), result(False, 450), result(False, 900, False)]
    assert task.measures(results) == {"cueing_ms": 30}
    assert task.measures(results[:2]) == {}


def test_the_agent_cannot_look_before_the_wait_begins(posner: type[Task]) -> None:
    with pytest.raises(ParameterError, match="longer than the shortest wait"):
        build(posner.Parameters, {"cue_lead_ms": 600})


def test_half_of_the_looks_are_valid_and_each_leads_as_set(posner: type[Task], calm: Theme) -> None:
    (effect,) = (effect for kind, effect in effects(Catalogue()) if kind is posner)
    trials = play(posner, effect, calm, 1)
    assert 0.4 < fmean(trial.data["valid"] for trial in trials) < 0.6
    leads = [trial.details["lead_ms"] for trial in trials]
    assert leads == pytest.approx([300] * len(leads), abs=20)
