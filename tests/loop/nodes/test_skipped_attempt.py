"""A participant leaves out an attempt: nothing of it is scored, and the session goes on with the
next one.
"""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.topics import ATTEMPT_ENDED, COMMAND, FEEDBACK, LEVEL, TRIAL
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from tests.lifting_task import Lift, LiftDriver

NewSession = Callable[..., LiftDriver]
SKIP = m.SessionCommand(command="skip", reason="attempt")


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session of three attempts of two lifts, and leave its instructions."""

    def start(**settings: Any) -> LiftDriver:
        driver = LiftDriver(Lift, calm, **{"attempts": 3, "lifts": 2, **settings})
        driver.enter()
        return driver

    return start


def skip(driver: LiftDriver) -> None:
    driver.session.bus.post(COMMAND, SKIP)
    driver.wait(300)


def test_an_attempt_under_way_is_left_out_with_what_was_done_of_it(new_session: NewSession) -> None:
    driver = new_session()
    driver.press("enter")
    driver.lift()
    driver.operate("pause")
    skip(driver)
    assert (driver.waiting.stage, driver.waiting.attempt, driver.waiting.trial) == ("attempt", 2, 1)
    assert [trial.attempt for trial in driver.all(TRIAL)] == [1], "the lift stays"
    assert driver.all(ATTEMPT_ENDED) == driver.all(LEVEL) == driver.all(FEEDBACK) == []
    for _ in range(2):
        driver.press("enter")
        driver.lift()
        driver.lift()
        driver.wait(300)
    assert [ended.attempt for ended in driver.all(ATTEMPT_ENDED)] == [2, 3]
    assert driver.waiting.stage == "review"


def test_an_attempt_is_left_out_before_it_begins_and_the_one_before_it_keeps_its_score(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.press("enter")
    driver.lift()
    driver.lift()
    driver.wait(300)
    level = driver.waiting.level
    driver.operate("pause")
    skip(driver)
    driver.operate("mark", reason="caught")
    assert (driver.waiting.attempt, driver.waiting.level) == (3, level)
    assert [ended.attempt for ended in driver.all(ATTEMPT_ENDED)] == [1]


def test_there_is_nothing_to_leave_out_in_the_instructions_and_at_the_end(calm: Theme) -> None:
    driver = LiftDriver(Lift, calm, attempts=1, lifts=1)
    assert not driver.session.can_skip_attempt
    skip(driver)
    assert driver.waiting.stage == "instructions"
    driver.enter()
    assert driver.session.can_skip_attempt
    driver.press("enter")
    driver.lift()
    driver.wait(300)
    assert driver.waiting.stage == "review"
    assert not driver.session.can_skip_attempt


def test_it_is_replayed_and_resumed(new_session: NewSession, calm: Theme) -> None:
    driver = new_session()
    driver.press("enter")
    driver.lift()
    driver.operate("pause")
    skip(driver)
    resumed = LiftDriver(Lift, calm, attempts=3, lifts=2, history=driver.records)
    assert resumed.waiting.attempt == 2
