"""The action center proposes text, face and gesture to fit the events of a session."""

from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.nodes.action_center import RULES
from sar_tui.loop.topics import PROPOSED
from sar_tui.model.messages import Proposal
from sar_tui.model.theme import Manner
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver, lifting
from tests.loop.nodes.agent_driver import Agent

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
THEMES = ["calm", "playful", "high-contrast"]
GOOD, BAD = 400.0, 1900.0
METRICS = [500.0, 800.0, 950.0, 1005.0, 1050.0, 1200.0, 2000.0, None]


def session(at: str = "instructions", *times_ms: float, **settings: Any) -> LiftDriver:
    """Start a session of five attempts of one lift each, and do some."""
    driver = lifting(at, Lift, **{"attempts": 5, "lifts": 1, "start_level": 3, **settings})
    for time_ms in times_ms:
        driver.press("enter")
        driver.lift(time_ms)
    return driver


def proposed(driver: LiftDriver, *kinds: str) -> list[Proposal]:
    return [proposal for proposal in driver.all(PROPOSED) if not kinds or proposal.kind in kinds]


# --- greeting, instructions, goodbye


def test_the_agent_greets_gives_instructions_and_says_goodbye() -> None:
    driver = session(attempts=1)
    greeting, instruction = proposed(driver)
    assert facts(greeting, "kind face gesture") == ("greeting", "happy", "wave")
    assert greeting.spoken == greeting.text
    assert greeting.text in CALM.phrases["greeting"]
    assert facts(instruction, "kind text spoken") == ("instruction", "", "Press Space, and lift.")
    driver.begin_lifts()
    driver.lift(GOOD)
    assert proposed(driver, "goodbye") == [], "the last feedback is read first"
    driver.press("enter")
    (goodbye,) = proposed(driver, "goodbye")
    assert goodbye.text in CALM.phrases["goodbye"]


def test_after_an_interruption_instructions_are_given_again_or_the_participant_is_welcomed() -> (
    None
):
    again = session(history=session().records)
    assert each(proposed(again), "kind") == ["greeting", "instruction"]
    (welcome,) = proposed(session(history=session("start").records))
    assert welcome.text in CALM.phrases["welcome_back"]


# --- between attempts


def test_encouragement_precedes_a_new_level_and_follows_two_failures() -> None:
    driver = session("attempt", GOOD, BAD, GOOD, BAD, BAD, attempts=6)
    new_level, missed = proposed(driver, "encouragement")
    assert facts(new_level, "attempt joins") == (2, True), "level 4 is new"
    assert facts(missed, "attempt joins") == (6, True), "attempts 4 and 5 failed"
    assert new_level.text in CALM.phrases["encouragement_new_level"]
    assert missed.text in CALM.phrases["encouragement"]


def test_feedback_says_nothing_twice_and_not_what_the_last_feedback_said() -> None:
    quiet = {"encouragement": False, "rest_every": 0, "max_level": 3}
    driver = session("attempt", *[GOOD] * 8, attempts=8, **quiet)
    texts = each(proposed(driver, "feedback"), "text")
    assert [text for text in texts if text.lower().count("goal") > 1] == []
    openings = [text.split(".")[0] for text in texts]
    assert all(one != other for one, other in pairwise(openings)), openings


def test_encouragement_can_be_left_out() -> None:
    driver = session("attempt", GOOD, GOOD, GOOD, encouragement=False)
    assert proposed(driver, "encouragement") == []


@pytest.mark.parametrize(
    ("every", "practice", "before"),
    [(0, 0, []), (2, 0, [3, 5]), (2, 2, [5])],
)
def test_a_rest_is_suggested_every_n_scored_attempts_but_not_after_the_last(
    every: int, practice: int, before: list[int]
) -> None:
    driver = session("attempt", *[GOOD] * 5, rest_every=every, practice_attempts=practice)
    assert each(proposed(driver, "rest"), "attempt") == before


def test_encouragement_is_given_once_per_attempt() -> None:
    driver = session("attempt", GOOD)
    for level in (7, 8):
        driver.operate("level", value=level)
    assert len(proposed(driver, "encouragement")) == 1


# --- manner of feedback


@pytest.mark.parametrize(
    ("metric", "valence", "degree", "situation"),
    [
        (500.0, "positive", "strong", "positive_strong"),
        (800.0, "positive", "clear", "positive"),
        (950.0, "positive", "slight", "positive_slight"),
        (1005.0, "neutral", "slight", "neutral"),
        (1050.0, "negative", "slight", "negative_slight"),
        (1200.0, "negative", "clear", "negative"),
        (2000.0, "negative", "strong", "negative_strong"),
    ],
)
def test_distance_from_the_goal_selects_text_face_and_gesture(
    metric: float, valence: str, degree: str, situation: str
) -> None:
    agent = Agent(Lift, CALM, "qualitative")
    assert agent.feedback_on(metric) in CALM.phrases[situation]
    answer = agent.said[-1]
    assert facts(answer, "kind valence degree attempt") == ("feedback", valence, degree, 1)
    manner = CALM.manner(situation)
    assert Manner(answer.face, answer.gesture, answer.gaze, answer.tone) == manner
    assert manner.tone == ("success" if valence == "positive" else "")


def test_priorities_and_policies_of_the_kinds() -> None:
    helps = {"instruction", "encouragement", "rest"}
    assert {kind for kind, rule in RULES.items() if rule.policy == "drop"} == {*helps, "filler"}
    assert {kind for kind, rule in RULES.items() if rule.policy == "interrupt"} == {"feedback"}
    priority = {kind: rule.priority for kind, rule in RULES.items()}
    assert priority["filler"] > priority["feedback"], "a filler is not interrupted"
    assert max(priority[kind] for kind in helps) < priority["greeting"] < priority["feedback"]
    assert min(RULES, key=lambda kind: priority[kind]) in ("goodbye", "rest")


# --- choice of phrases


@given(st.lists(st.sampled_from(METRICS), max_size=20), st.sampled_from(THEMES), st.integers(0, 99))
def test_a_phrase_is_not_used_twice_in_a_row(
    metrics: list[float | None], name: str, seed: int
) -> None:
    theme = CATALOGUE.theme(name)
    agent = Agent(Lift, theme, "qualitative", seed)
    said = [agent.feedback_on(metric) for metric in metrics]
    for wordings in theme.phrases.values():
        spoken = [words for words in said if words in wordings]
        assert all(one != other for one, other in pairwise(spoken))


# --- another theme
