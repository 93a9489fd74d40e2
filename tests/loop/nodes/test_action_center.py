"""The action center proposes text, face and gesture to fit the events of a session."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.nodes.action_center import RULES
from sar_tui.loop.task import Task
from sar_tui.loop.topics import PROPOSED, THEME
from sar_tui.model.messages import Proposal, ThemeApplied
from sar_tui.model.theme import FACES, GAZES, TONES, Manner, Theme
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from tests.facts import facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop.nodes.agent_driver import Agent

NewSession = Callable[..., LiftDriver]


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session; by default five attempts of one lift each."""

    def start(**settings: Any) -> LiftDriver:
        return LiftDriver(Lift, calm, **{"attempts": 5, "lifts": 1, "start_level": 3, **settings})

    return start


def proposed(driver: LiftDriver, *kinds: str) -> list[Proposal]:
    return [proposal for proposal in driver.all(PROPOSED) if not kinds or proposal.kind in kinds]


def lift_once(driver: LiftDriver, time_ms: float) -> None:
    driver.press("enter")
    driver.lift(time_ms)


GOOD, BAD = 400.0, 1900.0


# --- greeting, instructions, goodbye


def test_the_agent_greets_gives_instructions_and_says_goodbye(
    new_session: NewSession, calm: Theme
) -> None:
    driver = new_session(attempts=1)
    greeting, instruction = proposed(driver)
    assert (greeting.kind, greeting.face, greeting.gesture) == ("greeting", "happy", "wave")
    assert greeting.text in calm.phrases["greeting"]
    assert greeting.spoken == greeting.text
    assert facts(instruction, "kind text spoken") == ("instruction", "", "Press Space, and lift.")
    driver.enter()
    lift_once(driver, GOOD)
    assert proposed(driver, "goodbye") == [], "the last feedback is read first"
    driver.press("enter")
    (goodbye,) = proposed(driver, "goodbye")
    assert goodbye.text in calm.phrases["goodbye"]


def test_instructions_are_given_once_per_run(new_session: NewSession) -> None:
    driver = new_session()
    driver.operate("pause")
    driver.operate("resume")
    assert driver.waiting.stage == "instructions"
    assert len(proposed(driver, "instruction")) == 1


def test_instructions_are_given_again_after_an_interruption_in_them(
    new_session: NewSession, calm: Theme
) -> None:
    driver = new_session()
    resumed = LiftDriver(Lift, calm, attempts=5, lifts=1, start_level=3, history=driver.records)
    assert [proposal.kind for proposal in proposed(resumed)] == ["greeting", "instruction"]


def test_a_resumed_session_welcomes_the_participant_back(
    new_session: NewSession, calm: Theme
) -> None:
    driver = new_session()
    driver.begin_lifts()
    resumed = LiftDriver(Lift, calm, attempts=5, lifts=1, start_level=3, history=driver.records)
    assert [proposal.text in calm.phrases["welcome_back"] for proposal in proposed(resumed)] == [
        True
    ]


def test_an_aborted_session_ends_with_a_goodbye_too(new_session: NewSession) -> None:
    driver = new_session()
    driver.begin_lifts()
    driver.operate("end")
    assert [proposal.kind for proposal in proposed(driver)][-1] == "goodbye"


# --- between attempts


def test_encouragement_precedes_a_new_level_and_follows_two_failures(
    new_session: NewSession,
) -> None:
    driver = new_session(attempts=6)
    driver.enter()
    for time_ms in (GOOD, BAD, GOOD, BAD, BAD):
        lift_once(driver, time_ms)
    proposals = [
        (proposal.attempt, proposal.joins) for proposal in proposed(driver, "encouragement")
    ]
    assert proposals == [(2, True), (6, True)], (
        "level 4 is new before attempt 2; attempts 4 and 5 failed"
    )


def test_encouragement_fits_what_has_just_happened(new_session: NewSession, calm: Theme) -> None:
    driver = new_session(attempts=6)
    driver.enter()
    for time_ms in (GOOD, BAD, GOOD, BAD, BAD):
        lift_once(driver, time_ms)
    new_level, missed = proposed(driver, "encouragement")
    assert new_level.text in calm.phrases["encouragement_new_level"]
    assert missed.text in calm.phrases["encouragement"]


def test_feedback_says_nothing_twice_and_not_what_the_last_feedback_said(
    new_session: NewSession,
) -> None:
    driver = new_session(attempts=8, encouragement=False, rest_every=0, max_level=3)
    driver.enter()
    for _ in range(8):
        lift_once(driver, GOOD)
    texts = [proposal.text for proposal in proposed(driver, "feedback")]
    assert [text for text in texts if text.lower().count("goal") > 1] == []
    openings = [text.split(".")[0] for text in texts]
    assert all(one != other for one, other in pairwise(openings)), openings


def test_the_first_attempt_gets_no_encouragement(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    assert proposed(driver, "encouragement", "rest") == []


def test_encouragement_can_be_left_out(new_session: NewSession) -> None:
    driver = new_session(encouragement=False)
    driver.enter()
    for _ in range(3):
        lift_once(driver, GOOD)
    assert proposed(driver, "encouragement") == []


@pytest.mark.parametrize(("every", "before"), [(0, []), (1, [2, 3, 4, 5]), (2, [3, 5]), (4, [5])])
def test_a_rest_is_suggested_every_n_scored_attempts_but_not_after_the_last(
    new_session: NewSession, every: int, before: list[int]
) -> None:
    driver = new_session(rest_every=every)
    driver.enter()
    for _ in range(5):
        lift_once(driver, GOOD)
    assert [proposal.attempt for proposal in proposed(driver, "rest")] == before


def test_practice_does_not_count_towards_a_rest(new_session: NewSession) -> None:
    driver = new_session(rest_every=2, practice_attempts=2)
    driver.enter()
    for _ in range(4):
        lift_once(driver, GOOD)
    assert [proposal.attempt for proposal in proposed(driver, "rest")] == [5]


def test_rest_and_encouragement_are_not_both_given(new_session: NewSession) -> None:
    driver = new_session(rest_every=1)
    driver.enter()
    for _ in range(4):
        lift_once(driver, GOOD)
    assert proposed(driver, "encouragement") == [], (
        "each was harder, and a rest was suggested before each"
    )
    assert len(proposed(driver, "rest")) == 4


def test_encouragement_is_given_once_per_attempt(new_session: NewSession) -> None:
    driver = new_session()
    driver.enter()
    lift_once(driver, GOOD)
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
@pytest.mark.parametrize("name", ["calm", "playful", "high-contrast"])
def test_distance_from_the_goal_selects_text_face_and_gesture(
    catalogue: Catalogue, name: str, metric: float, valence: str, degree: str, situation: str
) -> None:
    theme = catalogue.theme(name)
    agent = Agent(Lift, theme, "qualitative")
    said = agent.feedback_on(metric)
    answer = agent.said[-1]
    assert said in theme.phrases[situation]
    assert facts(answer, "kind valence degree attempt") == ("feedback", valence, degree, 1)
    manner = theme.manner(situation)
    assert Manner(answer.face, answer.gesture, answer.gaze, answer.tone) == manner
    assert manner.tone == ("success" if valence == "positive" else "")


def test_every_manner_is_known_to_the_outputs(catalogue: Catalogue) -> None:
    for name in catalogue.theme_names():
        agent = Agent(Lift, catalogue.theme(name))
        for metric in (500.0, 800.0, 950.0, 1005.0, 1050.0, 1200.0, 2000.0, None):
            agent.feedback_on(metric)
        for said in agent.said:
            assert said.face in FACES
            assert said.gesture in ("", *catalogue.theme(name).gestures)
            assert said.gaze in ("", *GAZES)
            assert said.tone in ("", *TONES)


class Heights(Lift):
    """The same task with a metric that is no time."""

    name = "heights"
    metric = Metric("height", "cm", "lower", improved="lower", worsened="higher")


def test_units_are_spoken_in_full(calm: Theme) -> None:
    agent = Agent(Heights, calm)
    agent.feedback_on(700.0)
    (said,) = agent.said
    assert "700 cm" in said.text
    assert said.spoken == said.text.replace(" cm", " centimetres")


def test_priorities_and_policies_of_the_kinds(calm: Theme) -> None:
    assert {kind for kind, rule in RULES.items() if rule.policy == "drop"} == {
        "instruction",
        "encouragement",
        "rest",
        "filler",
    }
    assert {kind for kind, rule in RULES.items() if rule.policy == "interrupt"} == {"feedback"}
    helps = max(
        rule.priority for kind, rule in RULES.items() if rule.policy == "drop" and kind != "filler"
    )
    assert RULES["filler"].priority > RULES["feedback"].priority  # a filler is not interrupted
    assert helps < RULES["greeting"].priority < RULES["feedback"].priority
    assert min(RULES, key=lambda kind: RULES[kind].priority) in ("goodbye", "rest")
    agent = Agent(Lift, calm)
    agent.feedback_on(700.0)
    assert (agent.said[-1].priority, agent.said[-1].policy) == RULES["feedback"]


# --- choice of phrases


@given(st.lists(st.sampled_from([500.0, 800.0, 950.0, 1005.0, 1050.0, 1200.0, 2000.0, None]), max_size=20),
       st.sampled_from(["calm", "playful", "high-contrast"]), st.integers(0, 1000))  # fmt: skip
def test_a_phrase_is_not_used_twice_in_a_row(
    catalogue: Catalogue, metrics: list[float | None], name: str, seed: int
) -> None:
    theme = catalogue.theme(name)
    agent = Agent(Lift, theme, "qualitative", seed)
    said = [agent.feedback_on(metric) for metric in metrics]
    for wordings in theme.phrases.values():
        spoken = [words for words in said if words in wordings]
        assert all(one != other for one, other in pairwise(spoken))


@given(st.integers(0, 1000))
def test_a_phrase_with_figures_is_not_used_twice_in_a_row(catalogue: Catalogue, seed: int) -> None:
    agent = Agent(catalogue.task("keyboard"), catalogue.theme("calm"), "quantitative", seed)
    said = [agent.feedback_on(700, level) for level in range(1, 9)]
    assert all(one != other for one, other in pairwise(said))


@pytest.mark.parametrize(
    ("form", "situation"), [("qualitative", "positive_strong"), ("quantitative", "positive_first")]
)
def test_every_phrase_is_used(keyboard: type[Task], calm: Theme, form: str, situation: str) -> None:
    said = {Agent(keyboard, calm, form, seed).feedback_on(700) for seed in range(30)}
    assert said == {
        wording.format(value="0.70 seconds", goal="1 second") for wording in calm.phrases[situation]
    }


def test_the_same_seed_says_the_same(keyboard: type[Task], calm: Theme) -> None:
    def session() -> list[str]:
        agent = Agent(keyboard, calm, "both", seed=9)
        return [agent.feedback_on(700 + 10 * attempt) for attempt in range(10)]

    assert session() == session()


# --- another theme


def test_an_edited_theme_is_used_from_then_on(calm: Theme) -> None:
    agent = Agent(Lift, calm, "qualitative")
    agent.feedback_on(500)
    words, manner = (
        {"positive_strong": ("Splendid.",)},
        {"positive_strong": Manner("neutral", "", "up")},
    )
    edited = msgspec.structs.replace(calm, phrases={**calm.phrases, **words}, manners=manner)
    agent.bus.publish(THEME, ThemeApplied(theme=edited))
    assert agent.feedback_on(500) == "Splendid."
    assert facts(agent.said[-1], "face gesture gaze") == ("neutral", "", "up")
