"""Delayed and requested feedback comes on time."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.model.messages import Action
from sar_tui.model.units import MS, SECOND
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver, lifting

DELAY_MS = 2500
DELAYED = {"feedback_delay_ms": DELAY_MS}
ON_REQUEST = {"feedback_schedule": "request"}


def session(at: str = "start", **settings: Any) -> LiftDriver:
    """Start a session of three attempts of one lift each."""
    return lifting(at, Lift, **{"attempts": 3, "lifts": 1, **settings})


def lifted(**settings: Any) -> LiftDriver:
    """Start a session and do its first lift."""
    driver = session(**settings)
    lift(driver)
    return driver


def lift(driver: LiftDriver) -> None:
    """Do a lift, without waiting after it."""
    driver.to_lift()
    driver.press("k")
    driver.wait(400)
    driver.press("u")


def feedback(driver: LiftDriver) -> list[tuple[int, Action]]:
    """Return the feedback that the agent gave, each with its time (ns)."""
    acts = [(one.at, one.message) for one in driver.records if one.topic is t.ACTION]
    return [(at, action) for at, action in acts if action.kind == "feedback"]


def feedback_times(driver: LiftDriver) -> list[int]:
    return [at for at, _ in feedback(driver)]


def now(driver: LiftDriver, names: str = "what stage") -> tuple[Any, ...]:
    return facts(driver.waiting, names)


# --- after a delay


def test_delayed_feedback_comes_exactly_on_time() -> None:
    driver = lifted(**DELAYED)
    due = driver.last(t.ATTEMPT_ENDED).ended + DELAY_MS * MS
    assert now(driver) == ("answer", "answer")
    driver.wait(DELAY_MS - 1)
    assert (feedback(driver), driver.waiting.what) == ([], "answer")
    driver.wait(1)
    assert feedback_times(driver) == [due]
    assert now(driver) == ("enter", "attempt")
    assert driver.last(t.FEEDBACK).due == due


def test_without_feedback_there_is_no_wait() -> None:
    assert now(lifted(feedback_every=2, **DELAYED)) == ("enter", "attempt")


def test_a_pause_in_the_delay_does_not_delay_the_feedback() -> None:
    driver = lifted(**DELAYED)
    ended = driver.last(t.ATTEMPT_ENDED).ended
    driver.wait(500)
    driver.operate("pause")
    driver.wait(1000)
    driver.operate("resume")
    assert driver.waiting.what == "answer"
    driver.wait(1000)
    assert driver.waiting.what == "enter"
    assert feedback_times(driver) == [ended + DELAY_MS * MS]


def test_a_session_ended_in_the_delay_gives_no_feedback_after_the_goodbye() -> None:
    driver = lifted(**DELAYED)
    driver.wait(500)
    driver.operate("end")
    driver.wait(10_000)
    assert driver.last(t.ACTION).kind == "goodbye"
    assert feedback(driver) == []
    assert each(driver.all(t.DROPPED), "reason") == ["late"]


@pytest.mark.parametrize("starts_at", [10 * SECOND, 0, 10**15])
def test_a_session_cut_off_in_the_delay_does_not_wait_for_feedback(starts_at: int) -> None:
    """Time stamps of different runs cannot be compared."""
    driver = lifted(**DELAYED)
    driver.wait(500)
    resumed = session("instructions", history=driver.records, begin=False, **DELAYED)
    resumed.clock.set(starts_at)
    resumed.session.begin(2)
    assert now(resumed, "what reason") == ("enter", "interrupted")
    resumed.press("enter")
    assert now(resumed, "what stage attempt") == ("enter", "attempt", 2)
    resumed.wait(300)
    resumed.press("enter")
    resumed.wait(0)
    lift(resumed)
    assert resumed.last(t.TRIAL).attempt == 2
    resumed.wait(DELAY_MS)
    assert feedback_times(resumed) == [resumed.last(t.ATTEMPT_ENDED).ended + DELAY_MS * MS]
    late = [proposal.id for proposal in driver.all(t.PROPOSED) if proposal.kind == "feedback"]
    assert [dropped.id for dropped in resumed.all(t.DROPPED) if dropped.reason == "late"] == late


@given(st.lists(st.integers(0, 1500), max_size=6), st.integers(0, 6000))
def test_with_any_pauses_feedback_comes_once_and_on_time(waits: list[int], delay_ms: int) -> None:
    driver = lifted(feedback_delay_ms=delay_ms)
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


def asks(driver: LiftDriver) -> set[str]:
    """Return the keys that could request feedback, ``""`` for none."""
    return {waiting.ask for waiting in driver.all(t.WAITING)}


def test_feedback_on_request_is_given_once_when_requested() -> None:
    driver = session(**ON_REQUEST, **DELAYED)
    assert asks(driver) == {""}
    lift(driver)
    assert now(driver, "what stage ask") == ("enter", "attempt", "tab")
    assert driver.last(t.ATTEMPT_ENDED).feedback == "none"
    driver.wait(7000)
    assert feedback(driver) == []
    driver.press("tab")
    assert feedback_times(driver) == [driver.clock.now()], "requested feedback comes at once"
    assert driver.last(t.ATTEMPT_ENDED).feedback == driver.last(t.FEEDBACK).valence == "positive"
    assert driver.waiting.ask == ""
    before, after = each(driver.all(t.ATTEMPT_ENDED), "choice")
    assert after == driver.last(t.FEEDBACK).choice
    assert (before.due, after.due) == (False, True)
    assert "asked" in after.why
    driver.press("tab")
    assert len(feedback(driver)) == 1


def test_feedback_can_be_requested_until_the_next_attempt_begins() -> None:
    driver = lifted(**ON_REQUEST)
    driver.press("enter")
    driver.wait(300)
    driver.press("tab")
    lift(driver)
    assert (feedback(driver), driver.waiting.ask) == ([], "tab")
    driver.press("tab")
    assert each(driver.all(t.FEEDBACK), "attempt") == [2]


def test_feedback_on_the_last_attempt_can_be_requested() -> None:
    driver = lifted(attempts=1, **ON_REQUEST)
    assert now(driver, "stage ask") == ("review", "tab")
    driver.press("tab")
    assert (len(feedback(driver)), driver.waiting.stage) == (1, "review")
