"""A participant is asked whether somebody may watch: only where no response is awaited."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import COMMAND, VISIT, VISIT_DECIDED, VOIDED, WAITING
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from tests.loop_driver import LoopDriver

NewSession = Callable[..., LoopDriver]
ANNA, BEN = "operator.anna", "operator.ben"


@pytest.fixture
def new_session(keyboard: type[Task], calm: Theme) -> NewSession:
    def make(**given: Any) -> LoopDriver:
        return LoopDriver(keyboard, calm, **{"attempts": 3, "prompts_per_attempt": 2} | given)

    return make


@pytest.fixture
def driver(new_session: NewSession) -> LoopDriver:
    driver = new_session()
    driver.wait(5000)  # the greeting is over
    return driver


def ask(driver: LoopDriver, who: str = ANNA, state: Any = "asked") -> None:
    driver.session.bus.publish(VISIT, m.VisitRequested(actor=who, state=state))


def answer(driver: LoopDriver, key: str) -> None:
    """Press a key once the question was read."""
    driver.wait(1500)
    if key == "escape":
        driver.operate("dismiss")
    else:
        driver.strike(key)


def is_asked(driver: LoopDriver) -> bool:
    return (driver.waiting.stage, driver.waiting.reason) == ("paused", "visit")


def decided(driver: LoopDriver) -> list[tuple[str, tuple[str, ...]]]:
    return [(each.outcome, each.peers) for each in driver.all(VISIT_DECIDED)]


@pytest.mark.parametrize(("key", "outcome"), [("enter", "agreed"), ("escape", "declined")])
def test_before_the_session_the_question_is_put_at_once_and_the_session_goes_on_where_it_was(
    driver: LoopDriver, key: str, outcome: str
) -> None:
    ask(driver)
    assert is_asked(driver)
    answer(driver, "f")
    assert is_asked(driver), "no other key answers it"
    answer(driver, key)
    assert decided(driver) == [(outcome, (ANNA,))]
    assert driver.waiting.stage == "instructions"
    assert driver.difference() is None


def test_a_key_that_was_under_way_does_not_answer(driver: LoopDriver) -> None:
    ask(driver)
    driver.strike("enter")
    assert is_asked(driver)
    assert decided(driver) == []


def test_in_an_attempt_nothing_is_asked_and_no_trial_is_void(driver: LoopDriver) -> None:
    driver.start()
    ask(driver)
    driver.answer()
    assert driver.to_prompt().trial == 2
    assert not any(each.reason == "visit" for each in driver.all(WAITING))
    driver.answer()
    driver.wait(60_000)
    assert is_asked(driver)
    answer(driver, "enter")
    assert (driver.waiting.stage, driver.waiting.attempt) == ("attempt", 2)
    assert driver.all(VOIDED) == []


def test_nobody_is_asked_after_a_no_and_each_visitor_once_after_a_yes(
    driver: LoopDriver,
) -> None:
    ask(driver)
    answer(driver, "enter")
    ask(driver, BEN)
    assert is_asked(driver)
    answer(driver, "escape")
    ask(driver, "observer.eve")
    assert not is_asked(driver)
    assert decided(driver) == [("agreed", (ANNA,)), ("declined", (BEN,))]


def test_two_who_ask_at_once_get_one_answer(driver: LoopDriver) -> None:
    ask(driver)
    ask(driver, BEN)
    answer(driver, "enter")
    assert decided(driver) == [("agreed", (ANNA, BEN))]
    assert driver.waiting.stage == "instructions"


def test_the_question_is_withdrawn_with_the_request(driver: LoopDriver) -> None:
    ask(driver)
    ask(driver, state="withdrawn")
    assert driver.waiting.stage == "instructions"
    assert decided(driver) == []
    ask(driver)
    assert is_asked(driver)


def test_after_the_question_a_pause_goes_on(driver: LoopDriver) -> None:
    driver.operate("pause", "tired")
    ask(driver)
    assert is_asked(driver)
    driver.operate("resume")
    assert is_asked(driver), "it is answered first"
    answer(driver, "enter")
    assert (driver.waiting.stage, driver.waiting.reason) == ("paused", "tired")
    driver.operate("resume")
    assert driver.waiting.stage == "instructions"


def test_who_is_in_pain_is_not_asked(driver: LoopDriver) -> None:
    driver.operate("pause", "pain")
    ask(driver)
    assert driver.waiting.reason == "pain"
    driver.operate("resume")
    assert is_asked(driver)


def test_a_rest_is_a_moment_to_ask_and_is_not_longer_for_it(new_session: NewSession) -> None:
    driver = new_session(rest_after_attempts=1, rest_seconds=40)
    driver.enter()
    driver.attempt()
    driver.until(lambda: driver.waiting.stage == "rest")
    until = driver.waiting.until
    driver.wait(5000)
    ask(driver)
    assert is_asked(driver)
    answer(driver, "enter")
    assert (driver.waiting.stage, driver.waiting.until) == ("rest", until)


def test_only_the_participant_ends_a_visit(driver: LoopDriver) -> None:
    ask(driver)
    answer(driver, "enter")
    for actor in (ANNA, "participant"):
        driver.session.bus.publish(COMMAND, m.SessionCommand(command="dismiss", actor=actor))
    assert decided(driver) == [("agreed", (ANNA,)), ("ended", ())]
    ask(driver, BEN)
    assert not is_asked(driver)


def test_a_session_that_is_resumed_asks_only_if_somebody_asks_again(
    driver: LoopDriver, new_session: NewSession
) -> None:
    ask(driver)
    resumed = new_session(history=driver.records)
    resumed.wait(1000)
    assert resumed.waiting.reason == "interrupted"
    resumed.wait(1000)
    ask(resumed)
    assert is_asked(resumed)
