"""Steps stand between attempts until they are answered, declined, skipped or over; nothing of them
is lost.
"""

import pytest
from msgspec.structs import replace

from sar_tui.loop.task import Task
from sar_tui.loop.topics import PROPOSED, SESSION_ENDED, STEP_ENDED
from sar_tui.model import messages as m
from sar_tui.model.step import Entry, Step, points, problem
from sar_tui.plugins import Catalogue
from sar_tui.rules.keys import UNREAD
from tests.loop_driver import LoopDriver

TWO = {"attempts": 2, "prompts_per_attempt": 1}


def questioned(keyboard: type[Task], *steps: Step, **parameters: object) -> LoopDriver:
    class Questioned(keyboard):  # type: ignore[misc, valid-type]
        @property
        def steps(self) -> tuple[Step, ...]:
            return steps

    theme = Catalogue().theme("calm")
    return LoopDriver(Questioned, theme, **{**TWO, **parameters})


def asked(driver: LoopDriver) -> m.AskedStep | None:
    return driver.waiting.step


def settle(driver: LoopDriver) -> None:
    driver.wait(500)


def answer(driver: LoopDriver, *keys: str) -> m.StepEnded:
    settle(driver)
    for key in (*keys, "enter"):
        driver.press(key)
    ended = driver.last(STEP_ENDED)
    settle(driver)
    return ended


PAIN = Step(name="pain", text="How strong is your pain?", kind="number", every=1)
READ = Step(name="read", text="Now comes the harder part.", before=True)
STILL = Step(name="still", kind="calibration", text="Keep still.", seconds=3, after=(1,))
LAST = Step(name="word", kind="text", text="Anything else?")


def test_a_step_before_the_first_attempt_comes_after_the_instructions(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, READ)
    driver.enter()
    shown = asked(driver)
    assert shown is not None
    assert (driver.waiting.what, driver.waiting.stage, shown.step.text) == (
        "step",
        "step",
        READ.text,
    )
    settle(driver)
    driver.press("enter")
    assert driver.last(STEP_ENDED).status == "done"
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 1)


def test_a_question_after_each_attempt_is_answered_with_the_keyboard(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN)
    driver.enter()
    driver.attempt()
    shown = asked(driver)
    assert shown is not None
    assert (shown.number, shown.entry) == (1, Entry())
    ended = answer(driver, "1", "0")
    assert (ended.name, ended.attempt, ended.status, ended.answer) == ("pain", 1, "answered", 10)
    assert ended.shown < ended.ended
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 2)
    driver.attempt()
    assert answer(driver, "3").number == 2
    assert driver.waiting.stage == "review"


def test_the_next_attempt_does_not_begin_before_the_answer(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN)
    driver.enter()
    driver.attempt()
    settle(driver)
    driver.press("enter")
    shown = asked(driver)
    assert shown is not None
    assert shown.entry.is_missing
    assert driver.all(STEP_ENDED) == []


def test_enter_that_was_meant_for_what_stood_there_before_answers_nothing(
    keyboard: type[Task],
) -> None:
    driver = questioned(keyboard, READ)
    driver.enter()
    driver.wait(290)
    driver.strike("enter")
    assert driver.all(STEP_ENDED) == []
    driver.press("enter")
    assert driver.last(STEP_ENDED).status == "done"


def test_a_number_that_was_meant_for_the_question_before_answers_nothing(
    keyboard: type[Task],
) -> None:
    driver = questioned(keyboard, PAIN)
    driver.enter()
    driver.begin_attempt()
    driver.answer()
    driver.until(lambda: driver.waiting.what == "step")
    driver.clock.advance(driver.screen.waiting_since + UNREAD - 1 - driver.clock.now())
    before = driver.waiting
    driver.strike("3")
    assert driver.waiting == before
    driver.press("4")
    assert driver.waiting != before


def test_a_calibration_lasts_its_time_and_ends_by_itself(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, STILL)
    driver.enter()
    driver.attempt()
    settle(driver)
    driver.press("enter")
    until = driver.waiting.until
    assert until - driver.clock.now() > 1_000_000_000
    driver.until(lambda: driver.all(STEP_ENDED))
    ended = driver.last(STEP_ENDED)
    assert (ended.kind, ended.status, ended.ended - ended.shown) == (
        "calibration",
        "done",
        3_000_000_000,
    )


def test_tab_declines_and_is_no_request_for_feedback(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN, feedback_schedule="request")
    driver.enter()
    driver.attempt()
    settle(driver)
    driver.press("tab")
    assert (driver.last(STEP_ENDED).status, driver.last(STEP_ENDED).answer) == ("declined", None)


def test_an_operator_can_skip_a_step(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN)
    driver.enter()
    driver.attempt()
    driver.operate("skip")
    assert driver.last(STEP_ENDED).status == "skipped"
    assert driver.waiting.stage == "attempt"


def test_a_skip_ends_the_step_that_the_operator_saw_and_not_the_next(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN, LAST, attempts=1)
    driver.enter()
    driver.attempt()
    answer(driver, "4")
    driver.operate("skip", reason="step", value=1)
    shown = asked(driver)
    assert shown is not None
    assert shown.number == 2
    driver.operate("skip", reason="step", value=2)
    ended = driver.last(STEP_ENDED)
    assert (ended.name, ended.status, ended.answer) == ("word", "skipped", None)
    assert driver.waiting.stage == "review"


def test_a_pause_keeps_what_was_typed(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, LAST, attempts=1)
    driver.enter()
    driver.attempt()
    for key in "ok":
        driver.press(key)
    driver.operate("pause")
    driver.press("x")
    driver.operate("resume")
    assert answer(driver, "!").answer == "ok!"
    assert driver.waiting.stage == "review"


def test_a_session_that_is_ended_while_its_last_question_stands_is_complete(
    keyboard: type[Task],
) -> None:
    driver = questioned(keyboard, LAST, attempts=1)
    driver.enter()
    driver.attempt()
    driver.operate("end")
    assert driver.last(SESSION_ENDED).status == "completed"
    assert driver.all(STEP_ENDED) == []


def test_a_resumed_session_asks_again_and_does_not_repeat_what_was_answered(
    keyboard: type[Task],
) -> None:
    again = Step(name="again", text="And now?", kind="number", every=1)
    first = questioned(keyboard, PAIN, again)
    first.enter()
    first.attempt()
    answer(first, "3")
    first.press("5")
    assert asked(first) is not None
    kind = type(first.session.task)
    second = LoopDriver(kind, Catalogue().theme("calm"), history=first.records, **TWO)
    assert (second.waiting.stage, second.waiting.reason) == ("paused", "interrupted")
    second.press("enter")
    shown = asked(second)
    assert shown is not None
    assert (shown.step.name, shown.number, shown.entry.chosen) == ("again", 2, (5,))
    assert answer(second).answer == 5
    assert (second.waiting.stage, second.waiting.attempt) == ("attempt", 2)


def test_the_steps_that_a_session_was_begun_with_are_kept_by_its_record(
    keyboard: type[Task],
) -> None:
    first = LoopDriver(keyboard, Catalogue().theme("calm"), begin=False, **TWO)
    first.session.steps = (PAIN,)
    first.session.begin(1)
    first.enter()
    first.attempt()
    assert asked(first) is not None
    second = LoopDriver(keyboard, Catalogue().theme("calm"), history=first.records, **TWO)
    second.press("enter")
    assert answer(second, "2").name == "pain"


def test_the_question_is_spoken_once(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, PAIN)
    driver.enter()
    driver.attempt()
    answer(driver, "1", "2", "4")
    said = [each.spoken for each in driver.all(PROPOSED) if each.kind == "instruction"]
    assert said[1:] == ["How strong is your pain?"]


@pytest.mark.parametrize("every", [0, 1])
def test_therapists_choose_questions_by_name(keyboard: type[Task], every: int) -> None:
    driver = LoopDriver(
        keyboard,
        Catalogue().theme("calm"),
        **TWO,
        questions=("pain", "effort"),
        questions_every=every,
    )
    driver.enter()
    for _ in range(2):
        driver.attempt()
        while asked(driver):
            answer(driver, "2")
    assert [each.name for each in driver.all(STEP_ENDED)] == ["pain", "effort"] * (1 + every)


def test_questions_are_in_the_language_of_the_session(keyboard: type[Task]) -> None:
    spanish = {
        "attempts": 1,
        "prompts_per_attempt": 1,
        "questions": ("pain", "effort"),
        "language": "es",
    }
    driver = LoopDriver(keyboard, Catalogue().theme("calm", "es"), **spanish)
    driver.enter()
    driver.attempt()
    shown = asked(driver)
    assert shown is not None
    assert shown.step.text == "¿Cuánto dolor hay ahora?"
    assert "ningún dolor" in shown.step.labels
    answer(driver, "1")
    shown = asked(driver)
    assert shown is not None
    assert points(shown.step)[0].label == "nada"


CONSENT = Step(
    name="consent",
    kind="choice",
    text="Do you agree?",
    labels=("yes", "no"),
    before=True,
    required="yes",
)
FEELING = Step(name="feeling", kind="number", text="How do you feel?", before=True)


def test_the_required_answer_lets_the_session_begin(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, FEELING, CONSENT)
    driver.enter()
    assert driver.session.awaits_agreement
    assert answer(driver, "1").name == "consent", "it comes before all others"
    assert not driver.session.awaits_agreement
    answer(driver, "5")
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 1)


@pytest.mark.parametrize("keys", [("2", "enter"), ("tab",)])
def test_any_other_answer_ends_the_session_before_the_first_attempt(
    keyboard: type[Task], keys: tuple[str, ...]
) -> None:
    driver = questioned(keyboard, FEELING, CONSENT)
    driver.enter()
    settle(driver)
    for key in keys:
        driver.press(key)
    settle(driver)
    assert driver.last(SESSION_ENDED).status == "refused"
    assert [ended.name for ended in driver.all(STEP_ENDED)] == ["consent"]
    assert driver.session.awaits_agreement
    assert not [each for each in driver.all(PROPOSED) if getattr(each, "kind", "") == "goodbye"]


def test_enter_without_an_answer_and_an_operator_who_skips_do_not_agree(
    keyboard: type[Task],
) -> None:
    driver = questioned(keyboard, CONSENT)
    driver.enter()
    settle(driver)
    driver.press("enter")
    driver.operate("skip")
    shown = asked(driver)
    assert shown is not None
    assert shown.step.name == "consent"
    assert driver.all(STEP_ENDED) == []


@pytest.mark.parametrize("is_asked", [False, True])
def test_a_session_that_is_ended_before_all_agreed_is_kept_as_refused(
    keyboard: type[Task], is_asked: bool
) -> None:
    driver = questioned(keyboard, CONSENT, FEELING)
    if is_asked:
        driver.enter()
    settle(driver)
    driver.operate("end")
    assert driver.last(SESSION_ENDED).status == "refused"


def test_a_session_that_is_ended_after_all_agreed_is_aborted(keyboard: type[Task]) -> None:
    driver = questioned(keyboard, CONSENT, FEELING)
    driver.enter()
    answer(driver, "1")
    driver.operate("end")
    assert driver.last(SESSION_ENDED).status == "aborted"


def test_in_a_task_for_two_one_refusal_ends_the_session(catalogue: Catalogue) -> None:
    driver = questioned(catalogue.task("pairs"), CONSENT, prompts_per_attempt=2)
    driver.enter()
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
