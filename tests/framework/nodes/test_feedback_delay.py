"""Given feedback after a delay or on request, when the participant waits, asks or hurries, then it comes in time."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTION,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    DROPPED,
    FEEDBACK,
    OPERATOR,
    PROPOSED,
    SESSION_ENDED,
    TRIAL,
    WAITING,
)
from sar_tui.plugins import Catalogue
from tests.lifting import Bench, Lift

Sit = Callable[..., Bench]
DELAY_MS = 2500
ONE_LIFT = {"attempts": 3, "lifts": 1}
CALM = Catalogue().theme("calm")


@pytest.fixture
def sit(calm: Theme) -> Sit:
    """Sit down to three attempts of one lift each; ready to start the first."""

    def at(**settings: Any) -> Bench:
        desk = Bench(Lift, calm, **{**ONE_LIFT, **settings})
        desk.begin_lifts()
        return desk

    return at


def lift(desk: Bench, time_ms: float = 400) -> None:
    """A lift, and not a moment more."""
    desk.press("space")
    desk.to_prompt()
    desk.press("k")
    desk.wait(time_ms)
    desk.press("u")


def answers(desk: Bench) -> list[int]:
    """When the agent answered."""
    return [record.at for record in desk.records if record.topic is ACTION and record.message.kind == "feedback"]


# --- after a delay --------------------------------------------------------------------------------------------


def test_the_answer_comes_exactly_so_long_after_the_attempts_end(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    ended = desk.last(ATTEMPT_ENDED).ended
    assert (desk.waiting.what, desk.waiting.stage) == ("answer", "answer")
    desk.wait(DELAY_MS - 1)
    assert (answers(desk), desk.waiting.what) == ([], "answer")
    desk.wait(1)
    assert answers(desk) == [ended + DELAY_MS * MS]
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "attempt")
    assert desk.last(FEEDBACK).due == ended + DELAY_MS * MS


def test_no_attempt_begins_before_the_answer_however_often_enter_is_pressed(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    for _ in range(24):
        desk.press("enter")
        desk.wait(100)
    assert (len(desk.all(ATTEMPT_STARTED)), answers(desk)) == (1, [])
    desk.wait(200)
    desk.press("enter")
    assert len(desk.all(ATTEMPT_STARTED)) == 2
    assert len(answers(desk)) == 1


def test_the_last_answer_is_waited_for_before_the_review(sit: Sit) -> None:
    desk = sit(attempts=1, feedback_delay_ms=DELAY_MS)
    lift(desk)
    desk.press("enter")
    assert desk.waiting.what == "answer"
    desk.wait(DELAY_MS)
    assert (len(answers(desk)), desk.waiting.stage) == (1, "review")
    desk.press("enter")
    assert desk.all(SESSION_ENDED)


def test_where_no_answer_is_due_there_is_nothing_to_wait_for(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS, feedback_every=2)
    lift(desk)
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "attempt")


def test_a_pause_in_the_delay_puts_off_the_next_attempt_but_not_the_answer(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    ended = desk.last(ATTEMPT_ENDED).ended
    desk.wait(500)
    desk.operate("pause")
    desk.wait(1000)
    desk.operate("resume")
    assert desk.waiting.what == "answer"
    desk.wait(1000)
    assert desk.waiting.what == "enter"
    assert answers(desk) == [ended + DELAY_MS * MS]


def test_a_pause_that_outlasts_the_delay_is_quiet_and_the_answer_comes_after_it(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    desk.operate("pause", reason="pain")
    desk.wait(10_000)
    assert (desk.waiting.stage, answers(desk)) == ("paused", [])
    desk.operate("resume")
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "attempt")
    assert len(answers(desk)) == 1


def test_a_session_that_is_ended_in_the_delay_says_goodbye_and_no_answer_after_it(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    desk.wait(500)
    desk.operate("end")
    desk.wait(10_000)
    said = [action.kind for action in desk.all(ACTION)]
    assert said[-1] == "goodbye"
    assert "feedback" not in said
    assert [dropped.reason for dropped in desk.all(DROPPED)] == ["late"]


@pytest.mark.parametrize("starts_at", [10 * SECOND, 0, 10**15])
def test_a_session_cut_off_in_the_delay_waits_for_no_answer_whatever_the_clock_says_then(
    sit: Sit, calm: Theme, starts_at: int
) -> None:
    """The stamps of another run of the program, or of the machine, say nothing."""
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    desk.wait(500)
    resumed = Bench(Lift, calm, history=desk.records, begin=False, feedback_delay_ms=DELAY_MS, **ONE_LIFT)
    resumed.clock.set(starts_at)
    resumed.session.begin(2)
    assert (resumed.waiting.what, resumed.waiting.reason) == ("enter", "interrupted")
    resumed.press("enter")
    assert (resumed.waiting.what, resumed.waiting.stage, resumed.waiting.attempt) == ("enter", "attempt", 2)
    resumed.wait(300)
    resumed.press("enter")
    resumed.wait(0)
    lift(resumed)
    assert resumed.last(TRIAL).attempt == 2
    resumed.wait(DELAY_MS)
    assert answers(resumed) == [resumed.last(ATTEMPT_ENDED).ended + DELAY_MS * MS]
    late = [proposal.id for proposal in desk.all(PROPOSED) if proposal.kind == "feedback"]
    assert [dropped.id for dropped in resumed.all(DROPPED) if dropped.reason == "late"] == late


def test_an_attempt_that_is_amended_in_the_delay_is_answered_as_it_is_now_and_once(sit: Sit) -> None:
    desk = sit(feedback_delay_ms=DELAY_MS)
    lift(desk)
    desk.operate("mark", reason="caught")
    assert desk.waiting.what == "answer"
    desk.wait(10_000)
    assert len(answers(desk)) == 1
    assert [ended.outcome for ended in desk.all(ATTEMPT_ENDED)] == ["success", "failure"]
    assert [ended.feedback for ended in desk.all(ATTEMPT_ENDED)] == ["positive", "negative"]
    (answer,) = [action for action in desk.all(ACTION) if action.kind == "feedback"]
    assert answer.valence == "negative"
    assert [dropped.reason for dropped in desk.all(DROPPED)].count("amended") == 1


@given(st.lists(st.integers(0, 1500), max_size=6), st.integers(0, 6000))
def test_however_it_is_paused_the_answer_comes_once_not_too_early_and_no_attempt_before(
    waits: list[int], delay_ms: int
) -> None:
    desk = Bench(Lift, CALM, feedback_delay_ms=delay_ms, **ONE_LIFT)
    desk.begin_lifts()
    lift(desk)
    for number, wait_ms in enumerate(waits):
        desk.wait(wait_ms)
        desk.operate("resume" if number % 2 else "pause")
        desk.press("enter")
    desk.operate("resume")
    desk.wait(10_000)
    desk.press("enter")
    (answered,) = answers(desk)
    assert answered >= desk.all(ATTEMPT_ENDED)[0].ended + delay_ms * MS
    began = [record.at for record in desk.records if record.topic is ATTEMPT_STARTED]
    assert len(began) == 2
    assert began[1] >= answered


# --- on request -----------------------------------------------------------------------------------------------


def asks(desk: Bench) -> list[str]:
    return [waiting.ask for waiting in desk.all(WAITING)]


def test_on_request_nothing_is_said_until_it_is_asked_for_and_then_once(sit: Sit) -> None:
    desk = sit(feedback_schedule="request", feedback_delay_ms=DELAY_MS)
    assert set(asks(desk)) == {""}
    lift(desk)
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.ask) == ("enter", "attempt", "tab")
    assert desk.last(ATTEMPT_ENDED).feedback == "none"
    desk.wait(7000)
    assert answers(desk) == []
    desk.press("tab")
    asked = desk.clock.now()
    assert answers(desk) == [asked], "what is asked for comes at once"
    assert (desk.last(ATTEMPT_ENDED).feedback, desk.last(FEEDBACK).valence) == ("positive", "positive")
    assert desk.waiting.ask == ""
    before, after = (ended.choice for ended in desk.all(ATTEMPT_ENDED))
    assert before is not None
    assert after == desk.last(FEEDBACK).choice
    assert (before.due, after.due, after.why) == (False, True, "The participant asked for it.")
    desk.press("tab")
    assert len(answers(desk)) == 1


def test_it_can_be_asked_for_until_the_next_attempt_begins_and_of_that_one_again(sit: Sit) -> None:
    desk = sit(feedback_schedule="request")
    lift(desk)
    desk.press("enter")
    desk.wait(300)
    desk.press("tab")
    lift(desk)
    assert (answers(desk), desk.waiting.ask) == ([], "tab")
    desk.press("tab")
    assert [feedback.attempt for feedback in desk.all(FEEDBACK)] == [2]


def test_the_last_attempt_can_be_asked_about_too(sit: Sit) -> None:
    desk = sit(feedback_schedule="request", attempts=1)
    lift(desk)
    assert (desk.waiting.stage, desk.waiting.ask) == ("review", "tab")
    desk.press("tab")
    assert (len(answers(desk)), desk.waiting.stage) == (1, "review")


@pytest.mark.parametrize("schedule", ["every", "faded", "bandwidth", "summary", "none"])
def test_under_any_other_schedule_asking_is_of_no_use(sit: Sit, schedule: str) -> None:
    desk = sit(feedback_schedule=schedule, feedback_every=3)
    lift(desk)
    before = len(answers(desk))
    desk.press("tab")
    desk.wait(5000)
    assert len(answers(desk)) == before
    assert set(asks(desk)) == {""}


def test_what_was_asked_for_stays_said_when_the_attempt_is_amended(sit: Sit) -> None:
    desk = sit(feedback_schedule="request")
    lift(desk)
    desk.press("tab")
    desk.operate("mark", reason="caught")
    assert [(ended.feedback, ended.outcome) for ended in desk.all(ATTEMPT_ENDED)] == [
        ("none", "success"),
        ("positive", "success"),
        ("positive", "failure"),
    ]
    asked, amended = (ended.choice for ended in desk.all(ATTEMPT_ENDED)[1:])
    assert asked == amended
    desk.press("tab")
    assert len(answers(desk)) == 1


def test_asked_about_an_attempt_that_was_amended_the_agent_tells_what_it_is_now(sit: Sit) -> None:
    desk = sit(feedback_schedule="request")
    lift(desk)
    desk.operate("mark", reason="caught")
    assert desk.waiting.ask == "tab"
    desk.press("tab")
    assert desk.last(FEEDBACK).valence == desk.last(ATTEMPT_ENDED).feedback == "negative"


def test_a_session_cut_off_before_it_was_asked_can_be_asked_after(sit: Sit, calm: Theme) -> None:
    desk = sit(feedback_schedule="request")
    lift(desk)
    resumed = Bench(Lift, calm, history=desk.records, feedback_schedule="request", **ONE_LIFT)
    resumed.press("enter")
    assert resumed.waiting.ask == "tab"
    resumed.press("tab")
    assert len(answers(resumed)) == 1


def test_asking_in_a_pause_is_not_heard(sit: Sit) -> None:
    desk = sit(feedback_schedule="request")
    lift(desk)
    desk.operate("pause")
    desk.press("tab")
    assert answers(desk) == []
    desk.operate("resume")
    assert desk.waiting.ask == "tab"
    assert len(desk.all(OPERATOR)) == 2
