"""Delayed and requested feedback comes on time."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver

NewSession = Callable[..., LiftDriver]
DELAY_MS = 2500
ONE_LIFT = {"attempts": 3, "lifts": 1}
CALM = Catalogue().theme("calm")


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session of three attempts of one lift each, ready for the first lift."""

    def start(**settings: Any) -> LiftDriver:
        driver = LiftDriver(Lift, calm, **{**ONE_LIFT, **settings})
        driver.begin_lifts()
        return driver

    return start


def lift(driver: LiftDriver, time_ms: float = 400) -> None:
    """Do a lift, without waiting after it."""
    driver.press("space")
    driver.to_prompt()
    driver.press("k")
    driver.wait(time_ms)
    driver.press("u")


def feedback_times(driver: LiftDriver) -> list[int]:
    """Return the times (ns) at which the agent gave feedback."""
    return [
        record.at
        for record in driver.records
        if record.topic is t.ACTION and record.message.kind == "feedback"
    ]


# --- after a delay


def test_delayed_feedback_comes_exactly_on_time(new_session: NewSession) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    ended = driver.last(t.ATTEMPT_ENDED).ended
    assert (driver.waiting.what, driver.waiting.stage) == ("answer", "answer")
    driver.wait(DELAY_MS - 1)
    assert (feedback_times(driver), driver.waiting.what) == ([], "answer")
    driver.wait(1)
    assert feedback_times(driver) == [ended + DELAY_MS * MS]
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "attempt")
    assert driver.last(t.FEEDBACK).due == ended + DELAY_MS * MS


def test_no_attempt_begins_before_the_feedback(new_session: NewSession) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    for _ in range(24):
        driver.press("enter")
        driver.wait(100)
    assert (len(driver.all(t.ATTEMPT_STARTED)), feedback_times(driver)) == (1, [])
    driver.wait(200)
    driver.press("enter")
    assert len(driver.all(t.ATTEMPT_STARTED)) == 2
    assert len(feedback_times(driver)) == 1


def test_the_review_waits_for_the_last_feedback(new_session: NewSession) -> None:
    driver = new_session(attempts=1, feedback_delay_ms=DELAY_MS)
    lift(driver)
    driver.press("enter")
    assert driver.waiting.what == "answer"
    driver.wait(DELAY_MS)
    assert (len(feedback_times(driver)), driver.waiting.stage) == (1, "review")
    driver.press("enter")
    assert driver.all(t.SESSION_ENDED)


def test_without_feedback_there_is_no_wait(new_session: NewSession) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS, feedback_every=2)
    lift(driver)
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "attempt")


def test_a_pause_in_the_delay_does_not_delay_the_feedback(new_session: NewSession) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    ended = driver.last(t.ATTEMPT_ENDED).ended
    driver.wait(500)
    driver.operate("pause")
    driver.wait(1000)
    driver.operate("resume")
    assert driver.waiting.what == "answer"
    driver.wait(1000)
    assert driver.waiting.what == "enter"
    assert feedback_times(driver) == [ended + DELAY_MS * MS]


def test_feedback_due_in_a_pause_comes_after_it(new_session: NewSession) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    driver.operate("pause", reason="pain")
    driver.wait(10_000)
    assert (driver.waiting.stage, feedback_times(driver)) == ("paused", [])
    driver.operate("resume")
    assert (driver.waiting.what, driver.waiting.stage) == ("enter", "attempt")
    assert len(feedback_times(driver)) == 1


def test_a_session_ended_in_the_delay_gives_no_feedback_after_the_goodbye(
    new_session: NewSession,
) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    driver.wait(500)
    driver.operate("end")
    driver.wait(10_000)
    said = [action.kind for action in driver.all(t.ACTION)]
    assert said[-1] == "goodbye"
    assert "feedback" not in said
    assert [dropped.reason for dropped in driver.all(t.DROPPED)] == ["late"]


@pytest.mark.parametrize("starts_at", [10 * SECOND, 0, 10**15])
def test_a_session_cut_off_in_the_delay_does_not_wait_for_feedback(
    new_session: NewSession, calm: Theme, starts_at: int
) -> None:
    """Time stamps of different runs cannot be compared."""
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    driver.wait(500)
    resumed = LiftDriver(
        Lift, calm, history=driver.records, begin=False, feedback_delay_ms=DELAY_MS, **ONE_LIFT
    )
    resumed.clock.set(starts_at)
    resumed.session.begin(2)
    assert (resumed.waiting.what, resumed.waiting.reason) == ("enter", "interrupted")
    resumed.press("enter")
    assert facts(resumed.waiting, "what stage attempt") == ("enter", "attempt", 2)
    resumed.wait(300)
    resumed.press("enter")
    resumed.wait(0)
    lift(resumed)
    assert resumed.last(t.TRIAL).attempt == 2
    resumed.wait(DELAY_MS)
    assert feedback_times(resumed) == [resumed.last(t.ATTEMPT_ENDED).ended + DELAY_MS * MS]
    late = [proposal.id for proposal in driver.all(t.PROPOSED) if proposal.kind == "feedback"]
    assert [dropped.id for dropped in resumed.all(t.DROPPED) if dropped.reason == "late"] == late


def test_an_attempt_amended_in_the_delay_gets_the_amended_feedback_once(
    new_session: NewSession,
) -> None:
    driver = new_session(feedback_delay_ms=DELAY_MS)
    lift(driver)
    driver.operate("mark", reason="caught")
    assert driver.waiting.what == "answer"
    driver.wait(10_000)
    assert len(feedback_times(driver)) == 1
    assert [ended.outcome for ended in driver.all(t.ATTEMPT_ENDED)] == ["success", "failure"]
    assert [ended.feedback for ended in driver.all(t.ATTEMPT_ENDED)] == ["positive", "negative"]
    (feedback,) = [action for action in driver.all(t.ACTION) if action.kind == "feedback"]
    assert feedback.valence == "negative"
    assert [dropped.reason for dropped in driver.all(t.DROPPED)].count("amended") == 1


@given(st.lists(st.integers(0, 1500), max_size=6), st.integers(0, 6000))
def test_with_any_pauses_feedback_comes_once_and_on_time(waits: list[int], delay_ms: int) -> None:
    driver = LiftDriver(Lift, CALM, feedback_delay_ms=delay_ms, **ONE_LIFT)
    driver.begin_lifts()
    lift(driver)
    for number, wait_ms in enumerate(waits):
        driver.wait(wait_ms)
        driver.operate("resume" if number % 2 else "pause")
        driver.press("enter")
    driver.operate("resume")
    driver.wait(10_000)
    driver.press("enter")
    (given,) = feedback_times(driver)
    assert given >= driver.all(t.ATTEMPT_ENDED)[0].ended + delay_ms * MS
    began = [record.at for record in driver.records if record.topic is t.ATTEMPT_STARTED]
    assert len(began) == 2
    assert began[1] >= given


# --- on request


def requests(driver: LiftDriver) -> list[str]:
    """Return the keys that request feedback, ``""`` if there is none, of all waits."""
    return [waiting.ask for waiting in driver.all(t.WAITING)]


def test_feedback_on_request_is_given_once_when_requested(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request", feedback_delay_ms=DELAY_MS)
    assert set(requests(driver)) == {""}
    lift(driver)
    assert facts(driver.waiting, "what stage ask") == ("enter", "attempt", "tab")
    assert driver.last(t.ATTEMPT_ENDED).feedback == "none"
    driver.wait(7000)
    assert feedback_times(driver) == []
    driver.press("tab")
    requested = driver.clock.now()
    assert feedback_times(driver) == [requested], "requested feedback comes at once"
    assert (driver.last(t.ATTEMPT_ENDED).feedback, driver.last(t.FEEDBACK).valence) == (
        "positive",
        "positive",
    )
    assert driver.waiting.ask == ""
    before, after = (ended.choice for ended in driver.all(t.ATTEMPT_ENDED))
    assert before is not None
    assert after == driver.last(t.FEEDBACK).choice
    assert (before.due, after.due, after.why) == (False, True, "The participant asked for it.")
    driver.press("tab")
    assert len(feedback_times(driver)) == 1


def test_feedback_can_be_requested_until_the_next_attempt_begins(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request")
    lift(driver)
    driver.press("enter")
    driver.wait(300)
    driver.press("tab")
    lift(driver)
    assert (feedback_times(driver), driver.waiting.ask) == ([], "tab")
    driver.press("tab")
    assert [feedback.attempt for feedback in driver.all(t.FEEDBACK)] == [2]


def test_feedback_on_the_last_attempt_can_be_requested(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request", attempts=1)
    lift(driver)
    assert (driver.waiting.stage, driver.waiting.ask) == ("review", "tab")
    driver.press("tab")
    assert (len(feedback_times(driver)), driver.waiting.stage) == (1, "review")


@pytest.mark.parametrize("schedule", ["every", "faded", "bandwidth", "summary", "none"])
def test_under_other_schedules_a_request_is_ignored(new_session: NewSession, schedule: str) -> None:
    driver = new_session(feedback_schedule=schedule, feedback_every=3)
    lift(driver)
    before = len(feedback_times(driver))
    driver.press("tab")
    driver.wait(5000)
    assert len(feedback_times(driver)) == before
    assert set(requests(driver)) == {""}


def test_requested_feedback_is_kept_when_the_attempt_is_amended(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request")
    lift(driver)
    driver.press("tab")
    driver.operate("mark", reason="caught")
    assert each(driver.all(t.ATTEMPT_ENDED), "feedback outcome") == [
        ("none", "success"),
        ("positive", "success"),
        ("positive", "failure"),
    ]
    requested, amended = (ended.choice for ended in driver.all(t.ATTEMPT_ENDED)[1:])
    assert requested == amended
    driver.press("tab")
    assert len(feedback_times(driver)) == 1


def test_a_request_after_an_amendment_gives_the_amended_feedback(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request")
    lift(driver)
    driver.operate("mark", reason="caught")
    assert driver.waiting.ask == "tab"
    driver.press("tab")
    assert driver.last(t.FEEDBACK).valence == driver.last(t.ATTEMPT_ENDED).feedback == "negative"


def test_feedback_can_be_requested_after_a_resume(new_session: NewSession, calm: Theme) -> None:
    driver = new_session(feedback_schedule="request")
    lift(driver)
    resumed = LiftDriver(
        Lift, calm, history=driver.records, feedback_schedule="request", **ONE_LIFT
    )
    resumed.press("enter")
    assert resumed.waiting.ask == "tab"
    resumed.press("tab")
    assert len(feedback_times(resumed)) == 1


def test_a_request_in_a_pause_is_ignored(new_session: NewSession) -> None:
    driver = new_session(feedback_schedule="request")
    lift(driver)
    driver.operate("pause")
    driver.press("tab")
    assert feedback_times(driver) == []
    driver.operate("resume")
    assert driver.waiting.ask == "tab"
    assert len(driver.all(t.COMMAND)) == 2
