"""Steps stand between attempts until they are answered, declined, skipped or over; nothing of them
is lost.
"""

from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.loop.task import Task
from sar_tui.loop.topics import PROPOSED, SESSION_ENDED, STEP_ENDED
from sar_tui.model import messages as m
from sar_tui.model.step import Entry, Step, problem
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.loop_driver import LoopDriver

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
TWO: dict[str, Any] = {"attempts": 2, "prompts_per_attempt": 1}


def questioned(*steps: Step, kind: type[Task] = KEYBOARD, **parameters: Any) -> LoopDriver:
    """Start a session with these steps, and leave its instructions."""
    task = type("Questioned", (kind,), {"steps": property(lambda task: steps)})
    driver = LoopDriver(task, CALM, **{**TWO, **parameters})
    driver.enter()
    return driver


def asked_after_one(*steps: Step, **parameters: Any) -> LoopDriver:
    driver = questioned(*steps, **parameters)
    driver.attempt()
    return driver


def asked(driver: LoopDriver) -> m.AskedStep:
    shown = driver.waiting.step
    assert shown is not None
    return shown


def settle(driver: LoopDriver) -> None:
    driver.wait(500)


def answer(driver: LoopDriver, *keys: str, end: str = "enter") -> m.StepEnded:
    settle(driver)
    for key in (*keys, end):
        driver.press(key)
    ended = driver.last(STEP_ENDED)
    settle(driver)
    return ended


def place(driver: LoopDriver) -> tuple[str, int]:
    return (driver.waiting.stage, driver.waiting.attempt)


PAIN = Step(name="pain", text="How strong is your pain?", kind="number", every=1)
READ = Step(name="read", text="Now comes the harder part.", before=True)
STILL = Step(name="still", kind="calibration", text="Keep still.", seconds=3, after=(1,))
LAST = Step(name="word", kind="text", text="Anything else?")


def test_a_step_before_the_first_attempt_comes_after_the_instructions() -> None:
    driver = questioned(READ)
    assert facts(driver.waiting, "what stage step.step.text") == ("step", "step", READ.text)
    assert answer(driver).status == "done"
    assert place(driver) == ("attempt", 1)


def test_a_question_after_each_attempt_is_answered_with_the_keyboard() -> None:
    driver = asked_after_one(PAIN)
    assert facts(asked(driver), "number entry") == (1, Entry())
    ended = answer(driver, "1", "0")
    assert facts(ended, "name attempt status answer") == ("pain", 1, "answered", 10)
    assert ended.shown < ended.ended
    assert place(driver) == ("attempt", 2)
    driver.attempt()
    assert answer(driver, "3").number == 2
    assert driver.waiting.stage == "review"


def test_a_calibration_lasts_its_time_and_ends_by_itself() -> None:
    driver = asked_after_one(STILL)
    settle(driver)
    driver.press("enter")
    assert driver.waiting.until - driver.clock.now() > SECOND
    driver.until(lambda: driver.all(STEP_ENDED))
    ended = driver.last(STEP_ENDED)
    assert facts(ended, "kind status") == ("calibration", "done")
    assert ended.ended - ended.shown == 3 * SECOND


def test_tab_declines_and_is_no_request_for_feedback() -> None:
    driver = asked_after_one(PAIN, feedback_schedule="request")
    assert facts(answer(driver, end="tab"), "status answer") == ("declined", None)


def test_a_skip_ends_the_step_that_the_operator_saw_and_not_the_next() -> None:
    driver = asked_after_one(PAIN, LAST, attempts=1)
    answer(driver, "4")
    driver.operate("skip", reason="step", value=1)
    assert asked(driver).number == 2
    driver.operate("skip", reason="step", value=2)
    assert facts(driver.last(STEP_ENDED), "name status answer") == ("word", "skipped", None)
    assert driver.waiting.stage == "review"


def test_a_pause_keeps_what_was_typed() -> None:
    driver = asked_after_one(LAST, attempts=1)
    for key in "ok":
        driver.press(key)
    driver.operate("pause")
    driver.press("x")
    driver.operate("resume")
    assert answer(driver, "!").answer == "ok!"
    assert driver.waiting.stage == "review"


def test_a_resumed_session_asks_again_and_does_not_repeat_what_was_answered() -> None:
    first = asked_after_one(PAIN, Step(name="again", text="And now?", kind="number", every=1))
    answer(first, "3")
    first.press("5")
    second = LoopDriver(type(first.session.task), CALM, history=first.records, **TWO)
    assert facts(second.waiting, "stage reason") == ("paused", "interrupted")
    second.press("enter")
    assert facts(asked(second), "step.name number entry.chosen") == ("again", 2, (5,))
    assert answer(second).answer == 5
    assert place(second) == ("attempt", 2)


def test_the_steps_that_a_session_was_begun_with_are_kept_by_its_record() -> None:
    first = LoopDriver(KEYBOARD, CALM, begin=False, **TWO)
    first.session.steps = (PAIN,)
    first.session.begin(1)
    first.enter()
    first.attempt()
    second = LoopDriver(KEYBOARD, CALM, history=first.records, **TWO)
    second.press("enter")
    assert answer(second, "2").name == "pain"


def test_the_question_is_spoken_once() -> None:
    driver = asked_after_one(PAIN)
    answer(driver, "1", "2", "4")
    said = [one.spoken for one in driver.all(PROPOSED) if one.kind == "instruction"]
    assert said[1:] == ["How strong is your pain?"]


@pytest.mark.parametrize("every", [0, 1])
def test_therapists_choose_questions_by_name(every: int) -> None:
    chosen = {"questions": ("pain", "exertion"), "questions_every": every}
    driver = LoopDriver(KEYBOARD, CALM, **TWO, **chosen)
    driver.enter()
    for _ in range(2):
        driver.attempt()
        while driver.waiting.step:
            answer(driver, "2")
    assert each(driver.all(STEP_ENDED), "name") == ["pain", "exertion"] * (1 + every)


# --- a required answer

AGREE: Any = {"before": True, "required": "yes"}
CONSENT = Step(name="consent", kind="choice", text="Agreed?", labels=("yes", "no"), **AGREE)
FEELING = Step(name="feeling", kind="number", text="How do you feel?", before=True)


def test_the_required_answer_lets_the_session_begin() -> None:
    driver = questioned(FEELING, CONSENT)
    assert driver.session.awaits_agreement
    assert answer(driver, "1").name == "consent", "it comes before all others"
    assert not driver.session.awaits_agreement
    answer(driver, "5")
    assert place(driver) == ("attempt", 1)


@pytest.mark.parametrize("keys", [("2", "enter"), ("tab",)])
def test_any_other_answer_ends_the_session_before_the_first_attempt(keys: tuple[str, ...]) -> None:
    driver = questioned(FEELING, CONSENT)
    *typed, end = keys
    answer(driver, *typed, end=end)
    assert driver.last(SESSION_ENDED).status == "refused"
    assert each(driver.all(STEP_ENDED), "name") == ["consent"]
    assert driver.session.awaits_agreement
    assert "goodbye" not in each(driver.all(PROPOSED), "kind")


def test_enter_without_an_answer_and_an_operator_who_skips_do_not_agree() -> None:
    driver = questioned(CONSENT)
    settle(driver)
    driver.press("enter")
    driver.operate("skip")
    assert asked(driver).step.name == "consent"
    assert driver.all(STEP_ENDED) == []


@pytest.mark.parametrize(
    ("reached", "status"),
    [("instructions", "refused"), ("question", "refused"), ("agreed", "aborted")],
)
def test_a_session_that_is_ended_before_all_agreed_is_kept_as_refused(
    reached: str, status: str
) -> None:
    if reached == "instructions":
        task = type("Questioned", (KEYBOARD,), {"steps": (CONSENT, FEELING)})
        driver = LoopDriver(task, CALM, **TWO)
    else:
        driver = questioned(CONSENT, FEELING)
    if reached == "agreed":
        answer(driver, "1")
    settle(driver)
    driver.operate("end")
    assert driver.last(SESSION_ENDED).status == status


def test_in_a_task_for_two_one_refusal_ends_the_session() -> None:
    driver = questioned(CONSENT, kind=CATALOGUE.task("pairs"), prompts_per_attempt=2)
    answer(driver, "1")
    assert driver.session.awaits_agreement
    answer(driver, "2")
    assert driver.last(SESSION_ENDED).status == "refused"


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"required": "perhaps"}, "must be one of the labels"),
        ({"kind": "number", "labels": ("yes", "no")}, "the kind choice"),
        ({"before": False}, "before the first attempt only"),
        ({"every": 2}, "before the first attempt only"),
    ],
)
def test_a_step_that_cannot_require_an_answer_is_refused_with_a_sentence(
    changes: dict[str, object], why: str
) -> None:
    assert why in problem(replace(CONSENT, **changes))
