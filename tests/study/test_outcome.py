"""``[outcome]`` and ``[power]`` are checked, and the model follows from them."""

import math
import tomllib
from typing import Any

import pytest

from sar_tui.store.database import StoreError
from sar_tui.study.outcome import (
    Assumptions,
    Number,
    assumptions,
    read_outcome,
    read_power,
    tasks_of,
)
from sar_tui.study.power import estimate
from tests.study.exact import groups_with_baseline

OUTCOME = {"measure": "metric", "block": "training", "visit": "second", "compared": "groups"}
PAIRED = OUTCOME | {"compared": "within"}
SCORE = {"measure": "sus.score", "visit": "second", "compared": "groups"}


def assumed(
    outcome: dict[str, Any], pilot: dict[str, Number] | None = None, **power: Any
) -> Assumptions:
    plan = {"outcome": outcome, "power": power}
    read = read_outcome(plan)
    return assumptions(read_power(plan, read), read, pilot)


def refused(outcome: dict[str, Any], power: dict[str, Any] | None) -> str:
    plan = {"outcome": outcome} | ({} if power is None else {"power": power})

    def read() -> Assumptions:
        main = read_outcome(plan)
        return assumptions(read_power(plan, main), main)

    with pytest.raises(StoreError) as refusal:
        read()
    assert refusal.value.bad_input
    return str(refusal.value)


# --- the model


def test_defaults_are_reaction_times_with_their_sources() -> None:
    found = assumed(OUTCOME, effect=20)
    model = found.model
    assert (model.person_sd, model.dropout, model.effect) == (39, 0, 20)
    assert model.within_sd == pytest.approx(math.sqrt(20**2 + 69**2 / 40))
    assert model.total_sd == pytest.approx(45, abs=0.3)
    assert model.retest == pytest.approx(0.75, abs=0.01)
    assert all(number.source for number in found.numbers.values())
    assert found.numbers["within_sd"].source == "√(20² + 69² / 40)"


def test_a_shorter_baseline_varies_more_and_says_less_of_the_outcome() -> None:
    with_baseline = OUTCOME | {
        "compared": "groups, baseline",
        "baseline": {"visit": "first", "block": "baseline"},
    }
    read = read_outcome({"outcome": with_baseline})
    stated = read_power({"power": {"effect": 20}}, read)
    alike, shorter = (
        assumptions(stated, read, None, Number(40), Number(trials)) for trials in (40, 10)
    )
    assert alike.model.baseline_sd is None
    assert "baseline_sd" not in alike.numbers
    model = shorter.model
    assert model.baseline_sd == pytest.approx(math.sqrt(20**2 + 69**2 / 10))
    assert model.within_sd == alike.model.within_sd
    assert model.retest == pytest.approx(
        39**2 / (model.total_sd * math.hypot(39, model.of_baseline))
    )
    assert model.retest < alike.model.retest
    found = estimate(model, 60, draws=4000)
    exact = groups_with_baseline(model.effect / model.total_sd, model.retest, 60)
    assert found.low - 0.01 < exact < found.high + 0.01


def test_at_home_people_vary_more_and_are_lost() -> None:
    model = assumed(OUTCOME, effect=20, place="home").model
    assert model.retest == pytest.approx(0.55)
    assert model.person_sd == 39
    assert model.dropout == 0.2
    assert assumed(OUTCOME, effect=20, place="home", session_sd=20).model.retest > 0.7


def test_more_trials_lessen_the_variance_within_people() -> None:
    few, many = (assumed(OUTCOME, effect=20, trials=trials).model for trials in (10, 1000))
    assert many.within_sd < few.within_sd
    assert many.within_sd == pytest.approx(20, abs=0.2)


def test_an_effect_can_be_stated_in_standard_deviations() -> None:
    model = assumed(OUTCOME, effect_d=0.5).model
    assert model.effect == pytest.approx(0.5 * model.total_sd)
    model = assumed(PAIRED, effect_dz=0.5).model
    assert model.effect == pytest.approx(0.5 * math.sqrt(2) * model.within_sd)
    # dz = d / √(2 (1 - r))
    d = model.effect / model.total_sd
    assert d / math.sqrt(2 * (1 - model.retest)) == pytest.approx(0.5)
    assert assumed(PAIRED, effect_dz=0.5).effect.endswith("(dz = 0.5, d = 0.357)")


def test_a_number_may_say_its_source() -> None:
    found = assumed(OUTCOME, effect=20, person_sd={"value": 30, "source": "our own data"})
    assert found.numbers["person_sd"] == Number(30, "our own data")
    assert found.numbers["effect"].source == "stated in the plan"


def test_a_score_needs_its_own_numbers() -> None:
    model = assumed(SCORE, effect=5, unit="", person_sd=10, session_sd=5).model
    assert model.total_sd == pytest.approx(math.hypot(10, 5))
    assert "person_sd and session_sd must be stated" in refused(SCORE, {"effect": 5})


def test_a_pilot_replaces_the_numbers_but_not_the_trials() -> None:
    pilot = {
        name: Number(value, "pilot")
        for name, value in (("person_sd", 30), ("session_sd", 10), ("trial_sd", 50), ("trials", 20))
    }
    model = assumed(OUTCOME, pilot, effect=20, retest=0.5, trials=25, place="home").model
    assert (model.person_sd, model.dropout) == (30, 0.2)
    assert model.within_sd == pytest.approx(math.hypot(10, 50 / 5))
    assert assumed(OUTCOME, pilot, effect=20).numbers["trials"].value == 20


# --- refusals


@pytest.mark.parametrize(
    ("power", "said"),
    [
        (None, "The plan has no [power]: add it, such as effect = 20 (docs/power.md)."),
        ({}, "State one effect in [power]"),
        ({"effect": 20, "effect_d": 0.5}, "State one effect in [power]"),
        ({"effect": 20, "persn_sd": 3}, "[power] has unknown entries: persn_sd. Known are: unit,"),
        ({"effect": "20"}, "[power] effect must be a number, or { value = 39, source ="),
        ({"effect": {"value": 20, "form": "x"}}, "[power] effect must be a number, or {"),
        ({"effect": 0}, "[power] effect must be other than 0, not 0."),
        ({"effect": math.nan}, "[power] effect must be other than 0, not nan."),
        ({"effect": 20, "person_sd": -1}, "[power] person_sd must be 0 or more, not -1."),
        ({"effect": 20, "session_sd": math.inf}, "[power] session_sd must be 0 or more, not inf."),
        ({"effect": 20, "trials": 2.5}, "[power] trials must be a whole number from 1 to 10,000"),
        ({"effect": 20, "retest": 1}, "[power] retest must be more than 0 and less than 1, not 1."),
        ({"effect": 20, "retest": 0.95}, "40 trials with an SD of 69 allow: at most 0.927."),
        ({"effect": 20, "retest": 0.5, "session_sd": 2}, "State session_sd or retest in [power]"),
        ({"effect": 20, "dropout": 20}, "[power] dropout must be a share from 0 to 0.9, not 20."),
        ({"effect_dz": 0.5}, '[power] effect_dz is for compared = "within"'),
        ({"effect": 20, "wanted": 80}, "[power] wanted must be more than 0.05 and less than 1"),
        ({"effect": 20, "wanted": "x"}, "[power] wanted must be a number, such as 0.8."),
        ({"effect": 20, "sizes": [2]}, "[power] sizes must be from 4 to 5,000 people, not 2."),
        ({"effect": 20, "sizes": 40}, "[power] sizes must be a list of whole numbers"),
        ({"effect": 20, "place": "moon"}, '[power] place must be "lab" or "home".'),
        (
            {"effect": 20, "person_sd": 0, "session_sd": 0, "trial_sd": 0},
            "[power] says that nothing varies",
        ),
    ],
)
def test_a_wrong_number_is_refused_by_a_sentence(power: dict[str, Any] | None, said: str) -> None:
    assert said in refused(OUTCOME, power)


@pytest.mark.parametrize(
    ("outcome", "said"),
    [
        (OUTCOME | {"measure": "speed"}, "[outcome] measure must be one of metric, accuracy"),
        (OUTCOME | {"measures": 1}, "[outcome] has unknown entries: measures."),
        (OUTCOME | {"compared": "pairs"}, '[outcome] compared must be "within", "groups" or'),
        (OUTCOME | {"compared": "groups, baseline"}, "[outcome] baseline and compared"),
        (OUTCOME | {"baseline": {"visit": "first", "block": "a"}}, "[outcome] baseline and comp"),
        (OUTCOME | {"baseline": {"visit": "first"}}, "[outcome] baseline must be {"),
        ({"measure": "metric", "visit": "x", "compared": "groups"}, "[outcome] block is missing"),
        ({"measure": "metric", "block": "x"}, "[outcome] visit is missing: it must be the name of"),
    ],
)
def test_a_wrong_outcome_is_refused_by_a_sentence(outcome: dict[str, Any], said: str) -> None:
    assert said in refused(outcome, {"effect": 20})


def test_a_design_within_people_needs_a_variance_within_them() -> None:
    power = {"effect": 20, "session_sd": 0, "trial_sd": 0}
    assert "nobody varies from visit to visit" in refused(PAIRED, power)


# --- tasks

PLAN = """
[conditions.praise]
task = "keyboard"
[conditions.neutral]
task = "flanker"
[conditions.third]
task = "gonogo"
[groups.praise]
condition = "praise"
[groups.neutral]
condition = "neutral"
[[visits]]
name = "second"
[[visits.blocks]]
name = "training"
"""


@pytest.mark.parametrize(
    ("block", "tasks"),
    [
        ('condition = "as allocated"', ["keyboard", "flanker"]),
        ('condition = "third"', ["gonogo"]),
        ('conditions = ["third", "praise"]', ["gonogo", "keyboard"]),
        ('form = "SUS"', []),
    ],
)
def test_the_tasks_of_the_outcome_are_found(block: str, tasks: list[str]) -> None:
    outcome = read_outcome({"outcome": OUTCOME})
    assert tasks_of(tomllib.loads(PLAN + block), outcome) == tasks
