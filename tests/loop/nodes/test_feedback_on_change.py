"""Feedback reports a change from earlier attempts only if it is more than the person's own
noise.
"""

from typing import Any

import pytest

from sar_tui.model.messages import Spread
from sar_tui.plugins import Catalogue
from tests.facts import facts
from tests.lifting_task import Lift
from tests.loop.nodes.agent_driver import Agent, Spelled, spelled, spelling

VOICE = spelling(Catalogue().theme("calm", "en"))
STEADY, FIRM = "with a steady arm", "with a firm grip"
COMPARED = ("last attempt", "best attempt", "session's mean")


def agent(compared_with: str = "last attempt") -> Agent:
    return Agent(Lift, VOICE, "quantitative", feedback_compared_with=compared_with)


def watcher(form: str = "qualitative") -> Agent:
    """Return an agent with feedback on performance: sway in steps of 2, grip in steps of 5."""
    return Agent(Lift, VOICE, form, about="performance")


def result(told: Agent, metric: float, n: int = 5, sd: float = 20.0, **fields: Any) -> Spelled:
    """Return the figures of the feedback on an attempt."""
    return spelled(told.feedback_on(metric, spreads={"lift_time": Spread(n, sd)}, **fields))[-1]


def how(
    told: Agent, sway: float, grip: float = 50.0, metric: float = 900.0, n: int = 5, sd: float = 2.0
) -> Spelled:
    """Return the feedback on how an attempt was done."""
    spreads = {name: Spread(n, sd) for name in ("lift_time", "sway", "grip")}
    return spelled(told.feedback_on(metric, sway=sway, grip=grip, spreads=spreads))[-1]


# --- the result


@pytest.mark.parametrize("compared_with", COMPARED)
def test_a_change_within_the_noise_is_not_reported(compared_with: str) -> None:
    told = agent(compared_with)
    for metric in (900, 940, 870, 920, 860, 890, 935):
        found = result(told, metric)
        assert found.situation == "positive_first"
        assert set(found.slots) == {"value", "goal"}


@pytest.mark.parametrize("compared_with", COMPARED)
@pytest.mark.parametrize(
    ("metric", "situation", "word"), [(700, "improved", "faster"), (980, "worsened", "slower")]
)
def test_a_change_beyond_the_noise_is_reported(
    compared_with: str, metric: float, situation: str, word: str
) -> None:
    told = agent(compared_with)
    for before in (872, 870, 874, 870):
        result(told, before, sd=10.0)
    found = result(told, metric, sd=10.0)
    assert found.situation == f"positive_{situation}"
    assert found.slots["change"] == word


@pytest.mark.parametrize("compared_with", COMPARED)
def test_an_attempt_is_compared_with_those_in_its_condition(compared_with: str) -> None:
    told = agent(compared_with)
    for _ in range(4):
        result(told, 870, sd=10.0, condition="loaded")
        result(told, 700, sd=10.0, condition="free")
    found = result(told, 800, sd=10.0, condition="loaded")
    assert (found.situation, found.slots["change"]) == ("positive_improved", "faster")
    assert result(told, 500, sd=10.0, condition="other").situation == "positive_first"


# --- how it was done


def test_a_quality_is_praised_beyond_its_noise() -> None:
    told = watcher()
    for sway in (20.0, 21.0, 19.0, 20.0):
        assert how(told, sway).situation == "positive"
    found = how(told, 9.0)
    assert (found.situation, found.slots["change"]) == ("performance_improved", "steadier")
    assert facts(told.said[-1], "valence evidence") == ("positive", "sway -11 (MDC95 2.6)")


BASELINE = (20.0, 20.6, 19.4, 20.0, 20.8, 19.2, 20.5, 19.5)
"""Sways that differ by noise."""


def test_a_quality_that_is_worse_than_its_noise_twice_gives_the_advice() -> None:
    told = watcher()
    for sway in BASELINE:
        assert how(told, sway).situation == "positive"
    assert how(told, 32.0).situation == "positive", "it may be a single spoilt attempt"
    found = how(told, 31.0)
    assert (found.situation, found.slots["aim"]) == ("performance_worsened", STEADY)
    assert told.said[-1].valence == "negative"
    assert told.said[-1].evidence == "sway +12 (MDC95 1.1)"


@pytest.mark.parametrize("form", ["qualitative", "quantitative", "both"])
@pytest.mark.parametrize("about", ["performance", "both"])
def test_without_a_change_feedback_speaks_of_the_result(form: str, about: str) -> None:
    told = Agent(Lift, VOICE, form, about=about)
    aims = {aim for quality in Lift.qualities for aim in (quality.aim, quality.improved)}
    for sway in (20.0, 21.0, 40.0, *BASELINE):
        how(told, sway)
        assert not any(aim in told.said[-1].text for aim in aims)
        assert told.said[-1].text


def test_a_decline_in_figures_is_a_share_of_the_persons_mean() -> None:
    told = watcher("quantitative")
    for sway in (*BASELINE, 30.0, 30.0):
        found = how(told, sway)
    assert (found.situation, found.slots["percent"]) == ("performance_worsened_figures", "50 %")


def test_a_change_less_than_the_margin_is_not_praised_however_steady_the_person_is() -> None:
    told = watcher()
    for _ in range(5):
        how(told, 10.0, sd=0.0)
    assert how(told, 8.5, sd=0.0).situation == "positive"
    assert how(told, 6.0, sd=0.0).situation == "performance_improved"


def test_the_noise_is_that_of_attempts_with_a_similar_result() -> None:
    """A slower movement has higher values: that is neither noise nor a decline."""
    told = watcher()
    for sway in (20.0, 20.5, 19.5, 20.0):
        how(told, sway)
        how(told, 3 * sway, metric=1300.0)
    assert how(told, 10.0).situation == "performance_improved"


# --- the evidence, for the therapist


def test_a_reported_change_stands_beside_its_mdc95() -> None:
    told = agent()
    for before in (872, 870, 874, 870):
        result(told, before, sd=10.0)
        assert told.said[-1].evidence == ""
    result(told, 700, sd=10.0)
    assert told.said[-1].evidence == "lift time -0.170 s (MDC95 0.013 s)"
    assert "MDC95" not in told.said[-1].text


# --- doubtful trials


@pytest.mark.parametrize("doubtful", [4, 5], ids=["the last attempt", "this attempt"])
def test_no_change_of_a_result_is_reported_from_a_doubtful_trial(doubtful: int) -> None:
    told = agent()
    for number, metric in enumerate((900, 902, 898, 901, 905, 600)):
        found = result(told, metric, n=0 if number == doubtful else 5)
    assert found.situation == "positive_first"
    assert result(told, 1400).situation == (
        "negative_worsened" if doubtful == 4 else "negative_first"
    )
