"""Given a theme that is edited in mid-session, when the session goes on, or is gone on with, then it speaks by it."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.theme import Manner, Theme
from sar_tui.framework.topics import ACTION, ATTEMPT_ENDED, THEME, TRIAL, WAITING
from sar_tui.outputs.node import OutputNode
from sar_tui.plugins import Catalogue
from tests.desk import Desk
from tests.outputs.fakes import Puppet

CALM = Catalogue().theme("calm")
KEYBOARD = Catalogue().task("keyboard")
SET_UP = {"attempts": 4, "prompts_per_attempt": 1, "feedback_form": "qualitative", "difficulty_policy": "fixed"}
ROUNDS = {"attempt {number} of {total}": "round {number} of {total}"}


def edited(theme: Theme, word: str, **more: object) -> Theme:
    """The theme with one wording for each situation."""
    return msgspec.structs.replace(theme, phrases=dict.fromkeys(theme.phrases, (f"{word}.",)), **more)


def said(desk: Desk) -> list[str]:
    return [action.text for action in desk.all(ACTION) if action.kind == "feedback"]


def sit(theme: Theme = CALM, history: Desk | None = None, **more: object) -> Desk:
    records = history.records if history else None
    return Desk(KEYBOARD, theme, history=records, **{**SET_UP, **more})  # type: ignore[arg-type]


@pytest.fixture
def desk() -> Desk:
    """After the first of four attempts."""
    desk = sit()
    desk.enter()
    desk.attempt()
    return desk


def test_what_is_said_from_then_on_is_said_in_its_words_and_manner(desk: Desk) -> None:
    desk.session.wear(edited(CALM, "Splendid", manners={"positive_strong": Manner("neutral", "shake", "up", "end")}))
    desk.attempt()
    first, second = said(desk)
    assert first in CALM.phrases["positive_strong"]
    assert second == "Splendid."
    action = desk.all(ACTION)[-1]
    assert (action.face, action.gesture, action.gaze, action.tone) == ("neutral", "shake", "up", "end")


def test_every_output_wears_it_too() -> None:
    puppet = Puppet()
    desk = Desk(KEYBOARD, CALM, extra=[OutputNode(puppet, "puppet", CALM)], **SET_UP)
    desk.session.wear(edited(CALM, "Splendid", name="edited"))
    assert [what[1] for what in puppet.asked if what[0] == "wear"] == ["calm", "calm", "edited"]


def test_the_tasks_own_words_are_the_themes_where_it_has_some(desk: Desk) -> None:
    assert desk.waiting.attempt_name == "attempt 2 of 4"
    desk.session.wear(edited(CALM, "Splendid", texts=ROUNDS))
    desk.attempt()
    assert desk.waiting.attempt_name == "round 3 of 4"
    desk.session.wear(CALM)
    desk.attempt()
    assert desk.waiting.attempt_name == "attempt 4 of 4"


def test_a_session_that_wore_several_themes_is_gone_on_with_in_whatever_it_wears_now(desk: Desk) -> None:
    desk.session.wear(edited(CALM, "Splendid", texts=ROUNDS))
    desk.attempt()
    desk.session.wear(edited(CALM, "Great"))
    desk.attempt()
    resumed = sit(edited(CALM, "Bravo", name="calm"), desk)
    assert resumed.waiting.reason == "interrupted"
    resumed.press("enter")
    resumed.wait(300)
    resumed.attempt()
    assert [*said(desk)[1:], *said(resumed)] == ["Splendid.", "Great.", "Bravo."]
    assert [attempt.attempt for attempt in resumed.all(ATTEMPT_ENDED)] == [4]


def test_a_themes_own_texts_may_have_changed_since_the_session_was_cut_off() -> None:
    desk = sit(edited(CALM, "Splendid", texts=ROUNDS))
    desk.enter()
    assert desk.waiting.attempt_name == "round 1 of 4"
    resumed = sit(edited(CALM, "Splendid", texts={name: f"next {text}" for name, text in ROUNDS.items()}), desk)
    resumed.press("enter")
    assert resumed.waiting.attempt_name == "next round 1 of 4"


def test_a_theme_is_in_the_record_as_it_was_worn(desk: Desk) -> None:
    worn = edited(CALM, "Splendid", texts=ROUNDS)
    desk.session.wear(worn)
    for record in desk.records:
        if record.topic is THEME:
            text = msgspec.json.encode(record.message)
            assert msgspec.json.decode(text, type=THEME.type) == record.message
    assert [message.theme for message in desk.all(THEME)] == [CALM, worn]


@given(st.lists(st.sampled_from(["attempt", "wear", "wait", "cut"]), max_size=12))
def test_whenever_it_is_edited_and_cut_off_every_answer_is_in_the_words_of_its_time(steps: list[str]) -> None:
    desk, worn, count, expected = sit(attempts=13), CALM, 0, []
    desk.enter()
    for step in steps:
        match step:
            case "attempt":
                desk.attempt()
                expected.append(worn)
            case "wear":
                count += 1
                worn = edited(CALM, f"{'x' * count}", texts=ROUNDS if count % 2 else {})
                desk.session.wear(worn)
            case "wait":
                desk.wait(700)
            case "cut":
                before = desk.records
                desk = sit(worn, desk, attempts=13)
                desk.press("enter")
                desk.wait(300)
                desk.records[:0] = before
    heard = said(desk)
    assert len(heard) == len(expected) == len(desk.all(TRIAL))
    for words, theme in zip(heard, expected, strict=True):
        assert words in theme.phrases["positive_strong"]
    assert desk.all(WAITING)[-1].stage == "attempt"
