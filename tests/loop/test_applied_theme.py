"""A theme that is edited during a session applies from then on, also after a resume."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.topics import ACTION, TRIAL, WAITING
from sar_tui.model.theme import Manner, Theme
from sar_tui.outputs.node import OutputNode
from sar_tui.plugins import Catalogue
from tests.facts import facts
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import FakeOutput

CALM = Catalogue().theme("calm")
KEYBOARD = Catalogue().task("keyboard")
WORDS = {"feedback_form": "qualitative", "difficulty_policy": "fixed"}
SET_UP = {"attempts": 4, "prompts_per_attempt": 1, **WORDS}
ROUNDS = {"attempt {number} of {total}": "round {number} of {total}"}


def edited(theme: Theme, word: str, **more: object) -> Theme:
    """Return the theme with one phrase per key."""
    phrases = dict.fromkeys(theme.phrases, (f"{word}.",))
    return msgspec.structs.replace(theme, phrases=phrases, **more)


def said(driver: LoopDriver) -> list[str]:
    return [action.text for action in driver.all(ACTION) if action.kind == "feedback"]


def new_session(
    theme: Theme = CALM, history: LoopDriver | None = None, **more: object
) -> LoopDriver:
    records = history.records if history else None
    return LoopDriver(KEYBOARD, theme, history=records, **{**SET_UP, **more})  # type: ignore[arg-type]


@pytest.fixture
def driver() -> LoopDriver:
    """Start a session of four attempts, after the first."""
    driver = new_session()
    driver.enter()
    driver.attempt()
    return driver


def test_an_edited_theme_changes_words_and_manner_from_then_on(driver: LoopDriver) -> None:
    manners = {"positive_strong": Manner("neutral", "shake", "up", "end")}
    driver.session.apply_theme(edited(CALM, "Splendid", manners=manners))
    driver.attempt()
    first, second = said(driver)
    assert first in CALM.phrases["positive_strong"]
    assert second == "Splendid."
    action = driver.all(ACTION)[-1]
    assert facts(action, "face gesture gaze tone") == ("neutral", "shake", "up", "end")


def test_every_output_receives_the_edited_theme() -> None:
    fake = FakeOutput()
    driver = LoopDriver(KEYBOARD, CALM, extra=[OutputNode(fake, "fake", CALM)], **SET_UP)
    driver.session.apply_theme(edited(CALM, "Splendid", name="edited"))
    expected = ["calm", "calm", "edited"]
    assert [what[1] for what in fake.asked if what[0] == "apply_theme"] == expected


def test_texts_of_the_theme_replace_those_of_the_task(driver: LoopDriver) -> None:
    assert driver.waiting.attempt_name == "attempt 2 of 4"
    driver.session.apply_theme(edited(CALM, "Splendid", texts=ROUNDS))
    driver.attempt()
    assert driver.waiting.attempt_name == "round 3 of 4"
    driver.session.apply_theme(CALM)
    driver.attempt()
    assert driver.waiting.attempt_name == "attempt 4 of 4"


def test_a_session_is_resumed_although_the_texts_of_its_theme_have_changed() -> None:
    driver = new_session(edited(CALM, "Splendid", texts=ROUNDS))
    driver.enter()
    assert driver.waiting.attempt_name == "round 1 of 4"
    texts = {name: f"next {text}" for name, text in ROUNDS.items()}
    resumed = new_session(edited(CALM, "Splendid", texts=texts), driver)
    resumed.press("enter")
    assert resumed.waiting.attempt_name == "next round 1 of 4"


@given(st.lists(st.sampled_from(["attempt", "apply", "wait", "cut"]), max_size=12))
def test_feedback_uses_the_theme_of_its_time_despite_edits_and_resumes(steps: list[str]) -> None:
    driver, applied, count, expected = new_session(attempts=13), CALM, 0, []
    driver.enter()
    for step in steps:
        match step:
            case "attempt":
                driver.attempt()
                expected.append(applied)
            case "apply":
                count += 1
                applied = edited(CALM, f"{'x' * count}", texts=ROUNDS if count % 2 else {})
                driver.session.apply_theme(applied)
            case "wait":
                driver.wait(700)
            case "cut":
                before = driver.records
                driver = new_session(applied, driver, attempts=13)
                driver.press("enter")
                driver.wait(300)
                driver.records[:0] = before
    utterances = said(driver)
    assert len(utterances) == len(expected) == len(driver.all(TRIAL))
    for words, theme in zip(utterances, expected, strict=True):
        assert words in theme.phrases["positive_strong"]
    assert driver.all(WAITING)[-1].stage == "attempt"
