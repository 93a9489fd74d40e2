"""The last act of a person can be taken back for ten seconds, by that person."""

from collections.abc import Callable

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.loop.undo import UNDO_FOR
from sar_tui.model import messages as m
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop.nodes.test_step_flow import (
    PAIN,
    answer,
    asked,
    asked_after_one,
    place,
    questioned,
)
from tests.loop_driver import LoopDriver

TIRED = Step(name="tired", text="How tired are you?", kind="number", every=1)
AGREE = Step(
    name="agree", text="Do you agree?", kind="choice", labels=("yes", "no"), before=True,
    required="yes",
)  # fmt: skip
TOO_LATE_MS = UNDO_FOR / MS + 1
New = Callable[..., LoopDriver]


@pytest.fixture
def new(keyboard: type[Task], calm: Theme) -> New:
    """Start a session of the keyboard task, and leave its instructions."""

    def start(**settings: int) -> LoopDriver:
        settings = {"attempts": 3, "prompts_per_attempt": 2, "start_level": 3} | settings
        driver = LoopDriver(keyboard, calm, **settings)
        driver.enter()
        return driver

    return start


def do(driver: LoopDriver, command: str, actor: str = "therapist", **more: object) -> None:
    act = m.SessionCommand(command=command, actor=actor, id="an act", **more)  # type: ignore[arg-type]
    driver.session.bus.publish(t.COMMAND, act)


def undo(driver: LoopDriver, actor: str = "participant") -> str:
    """Take back the last act of a person. Returns what became of that."""
    do(driver, "undo", actor)
    return driver.last(t.ANSWERED).outcome


def taken_back(driver: LoopDriver) -> list[tuple[str, int]]:
    return each(driver.all(t.TAKEN_BACK), "what number")


# --- an answer


def test_the_last_answer_is_asked_for_again() -> None:
    driver = asked_after_one(PAIN)
    answer(driver, "9")
    assert place(driver) == ("attempt", 2)
    assert undo(driver) == "done"
    assert facts(asked(driver), "step.name number entry.chosen") == ("pain", 2, ())
    answer(driver, "2")
    assert place(driver) == ("attempt", 2)
    assert each(driver.all(t.STEP_ENDED), "number answer") == [(1, 9), (2, 2)]
    assert taken_back(driver) == [("answer", 1)]
    assert driver.difference() is None


def test_a_taken_back_answer_is_followed_by_the_questions_after_it() -> None:
    driver = asked_after_one(PAIN, TIRED)
    answer(driver, "9")
    assert asked(driver).step.name == "tired"
    undo(driver)
    assert answer(driver, "2").name == "pain"
    assert answer(driver, "4").name == "tired"
    assert place(driver) == ("attempt", 2)


def test_only_the_last_answer_can_be_taken_back() -> None:
    driver = asked_after_one(PAIN, TIRED)
    answer(driver, "9")
    answer(driver, "3")
    assert [undo(driver) for _ in range(3)] == ["done", "late", "late"]
    assert asked(driver).step.name == "tired"


def test_an_answer_stands_after_ten_seconds() -> None:
    driver = asked_after_one(PAIN)
    answer(driver, "9")
    driver.wait(TOO_LATE_MS)
    assert undo(driver) == "late"
    assert place(driver) == ("attempt", 2)


def test_an_answer_stands_once_the_next_attempt_has_begun() -> None:
    driver = asked_after_one(PAIN)
    answer(driver, "9")
    driver.begin_attempt()
    undo(driver)
    assert taken_back(driver) == [("attempt", 2)]


def test_an_answer_after_the_last_attempt_is_asked_for_again() -> None:
    driver = asked_after_one(PAIN, attempts=1)
    answer(driver, "9")
    assert driver.waiting.stage == "review"
    undo(driver)
    answer(driver, "1")
    assert driver.waiting.stage == "review"


def test_a_rest_goes_on_after_an_answer_is_given_again() -> None:
    driver = asked_after_one(PAIN, rest_after_attempts=1, rest_seconds=60)
    answer(driver, "9")
    until = driver.waiting.until
    assert driver.waiting.stage == "rest"
    undo(driver)
    answer(driver, "1")
    assert facts(driver.waiting, "stage until") == ("rest", until)


def test_an_agreement_that_was_taken_back_was_not_given() -> None:
    driver = questioned(AGREE)
    answer(driver, "1")
    assert not driver.session.awaits_agreement
    undo(driver)
    assert driver.session.awaits_agreement


# --- an attempt


def test_an_attempt_begun_by_mistake_waits_to_be_begun(new: New) -> None:
    driver = new()
    driver.begin_attempt()
    assert undo(driver) == "done"
    waiting = driver.waiting
    assert facts(waiting, "stage what attempt_name") == ("attempt", "enter", "attempt 1 of 3")
    driver.wait(60_000)
    assert driver.waiting is waiting, "nothing begins by itself"
    driver.attempt()
    assert each(driver.all(t.ATTEMPT_ENDED), "attempt trials") == [(2, 2)]
    assert taken_back(driver) == [("attempt", 1)]
    assert driver.difference() is None


def test_an_attempt_is_not_taken_back_after_its_first_response(new: New) -> None:
    driver = new()
    driver.begin_attempt()
    driver.answer()
    assert undo(driver) == "late"


def test_an_attempt_is_not_taken_back_in_a_pause(new: New) -> None:
    driver = new()
    driver.begin_attempt()
    driver.operate("pause")
    assert undo(driver) == "late"
    assert driver.waiting.stage == "paused"


def test_nothing_can_be_taken_back_in_the_next_run(new: New, keyboard: type[Task]) -> None:
    driver = new()
    driver.begin_attempt()
    settings = {"attempts": 3, "prompts_per_attempt": 2, "start_level": 3}
    resumed = LoopDriver(keyboard, driver.session.theme, history=driver.records, **settings)
    resumed.press("enter")
    assert undo(resumed) == "late"


def test_what_was_taken_back_is_taken_back_in_the_next_run(new: New, keyboard: type[Task]) -> None:
    driver = new()
    driver.begin_attempt()
    undo(driver)
    settings = {"attempts": 3, "prompts_per_attempt": 2, "start_level": 3}
    resumed = LoopDriver(keyboard, driver.session.theme, history=driver.records, **settings)
    resumed.press("enter")
    resumed.wait(300)
    assert facts(resumed.waiting, "stage attempt") == ("attempt", 2)


# --- a level, a setting, a mark, a note


def test_the_level_is_what_it_was_before_it_was_set(new: New) -> None:
    driver = new()
    driver.attempt(after_ms=5000, wrong=2)
    before = driver.session.next_attempt.level
    do(driver, "level", value=before + 1)
    assert undo(driver, "therapist") == "done"
    assert driver.session.next_attempt.level == before
    assert facts(driver.last(t.LEVEL), "previous level") == (before + 1, before)
    assert driver.waiting.level == before


def test_an_attempt_changes_the_level_again_after_a_level_was_taken_back(new: New) -> None:
    levels = []
    for is_set in (False, True):
        driver = new()
        driver.begin_attempt()
        if is_set:
            do(driver, "level", value=1)
            undo(driver, "therapist")
        driver.answer()
        driver.answer()
        driver.wait(1000)
        levels.append(driver.waiting.level)
    assert levels[0] == levels[1] != 3


def test_a_level_stands_once_an_attempt_has_begun_with_it(new: New) -> None:
    driver = new()
    do(driver, "level", value=5)
    driver.begin_attempt()
    assert undo(driver, "therapist") == "late"


def test_nobody_takes_back_what_another_person_did(new: New) -> None:
    driver = new()
    do(driver, "level", "operator.one", value=5)
    assert undo(driver) == "late"
    assert undo(driver, "therapist") == "late"
    assert undo(driver, "operator.one") == "done"


def test_a_level_stands_when_somebody_else_sets_another(new: New) -> None:
    driver = new()
    do(driver, "level", value=5)
    do(driver, "level", "operator.one", value=7)
    assert undo(driver, "therapist") == "late"
    assert driver.session.next_attempt.level == 7


def test_a_held_level_is_released(new: New) -> None:
    driver = new()
    do(driver, "hold")
    undo(driver, "therapist")
    assert not driver.session.next_attempt.is_level_held


def test_a_goal_is_what_it_was_before(new: New) -> None:
    driver = new()
    before = driver.session.next_attempt.settings["threshold"]
    changed = m.SettingChanged(name="threshold", value=300)
    driver.session.bus.publish(t.SETTING, changed)
    undo(driver, "therapist")
    assert driver.session.next_attempt.settings["threshold"] == before


@pytest.mark.parametrize("first", ["", "caught"])
def test_a_mark_is_what_it_was_before(calm: Theme, first: str) -> None:
    driver = LiftDriver(Lift, calm, attempts=3)
    driver.begin_lifts()
    driver.lift(400)
    if first:
        do(driver, "mark", reason=first)
    do(driver, "mark", reason="leaned")
    assert driver.session.trial_mark.present == "leaned"
    undo(driver, "therapist")
    assert driver.session.trial_mark.present == first


def test_a_mark_stands_once_the_next_trial_is_there_to_be_marked(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, attempts=3)
    driver.begin_lifts()
    driver.lift(400)
    do(driver, "mark", reason="caught")
    driver.press("space")
    driver.to_prompt()
    assert undo(driver, "therapist") == "late"


def test_a_note_is_taken_back_by_its_time(new: New) -> None:
    driver = new()
    at = driver.clock.now()
    driver.session.bus.publish(t.NOTE_ADDED, m.NoteAdded(text="wrong", actor="therapist", at=at))
    undo(driver, "therapist")
    assert each(driver.all(t.TAKEN_BACK), "what actor done") == [("note", "therapist", at)]
