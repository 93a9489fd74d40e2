"""Rests that must be taken: Enter does not skip them, a therapist can end them."""

from collections.abc import Callable

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import PROPOSED, WAITING
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.rules.limits import is_rest_due
from sar_tui.rules.parameters import TaskParameters
from tests.facts import facts
from tests.loop_driver import LoopDriver

NewSession = Callable[..., LoopDriver]


@pytest.fixture
def new_session(keyboard: type[Task], calm: Theme) -> NewSession:
    def make(**settings: object) -> LoopDriver:
        return LoopDriver(keyboard, calm, **{"attempts": 5, "prompts_per_attempt": 2} | settings)  # type: ignore[arg-type]

    return make


@pytest.fixture
def resting(new_session: NewSession) -> LoopDriver:
    """A session in its first rest, of 40 s, one second after it began."""
    driver = new_session(attempts=6, rest_after_attempts=2, rest_seconds=40, foreperiod_min_ms=500)
    driver.enter()
    driver.attempt()
    driver.attempt()
    return driver


@pytest.mark.parametrize(
    ("settings", "attempts", "minutes", "due"),
    [
        ({}, 200, 500.0, False),
        ({"rest_after_attempts": 3}, 2, 500.0, False),
        ({"rest_after_attempts": 3}, 3, 0.0, True),
        ({"rest_after_minutes": 5}, 200, 4.9, False),
        ({"rest_after_minutes": 5}, 1, 5.0, True),
    ],
)
def test_a_rest_is_due_after_so_many_attempts_or_minutes(
    settings: dict[str, int], attempts: int, minutes: float, due: bool
) -> None:
    assert is_rest_due(TaskParameters(**settings), attempts, minutes) is due


def test_enter_does_not_skip_a_rest_and_may_lengthen_it(resting: LoopDriver) -> None:
    assert facts(resting.waiting, "what stage attempt") == ("rest", "rest", 3)
    assert resting.waiting.until - resting.clock.now() == 39 * SECOND
    resting.press("enter")
    resting.wait(38_000)
    resting.press("enter")
    assert resting.waiting.stage == "rest"
    resting.wait(1000)
    assert resting.waiting.stage == "attempt"
    resting.wait(600_000)
    assert resting.waiting.stage == "attempt", "the participant may rest as long as they like"


def test_rests_follow_every_so_many_attempts_but_not_the_last(resting: LoopDriver) -> None:
    resting.wait(40_000)
    for _ in range(2):
        resting.attempt()
    resting.wait(40_000)
    for _ in range(2):
        resting.attempt()
    assert resting.waiting.stage == "review"
    assert [each.attempt for each in resting.all(WAITING) if each.stage == "rest"] == [3, 5]


def test_time_in_a_pause_is_time_of_the_rest(resting: LoopDriver) -> None:
    resting.operate("pause")
    resting.wait(30_000)
    resting.operate("resume")
    assert resting.waiting.stage == "rest"
    resting.operate("pause")
    resting.wait(30_000)
    resting.operate("resume")
    assert resting.waiting.stage == "attempt"


@pytest.mark.parametrize("is_paused", [False, True])
def test_a_therapist_ends_a_rest(resting: LoopDriver, is_paused: bool) -> None:
    if is_paused:
        resting.operate("pause")
    resting.operate("skip")
    if is_paused:
        assert resting.waiting.stage == "paused", "the pause goes on until somebody ends it"
        resting.operate("resume")
    assert resting.waiting.stage == "attempt"
    resting.wait(60_000)
    assert [each.stage for each in resting.all(WAITING)][-1] == "attempt"


def test_the_agent_speaks_of_the_rest_and_of_its_end_but_reminds_of_no_other(
    new_session: NewSession,
) -> None:
    driver = new_session(rest_after_attempts=2, rest_seconds=40, rest_every=2, encouragement=False)
    driver.enter()
    driver.attempt()
    driver.attempt()
    driver.wait(40_000)
    said = [(each.text, each.face) for each in driver.all(PROPOSED) if each.kind == "rest"]
    assert [face for _, face in said] == ["sleeping", "happy"]
    assert "rest" in said[0][0]


def test_a_rest_begins_anew_after_an_interruption(
    new_session: NewSession, resting: LoopDriver
) -> None:
    timing = {"rest_after_attempts": 2, "rest_seconds": 40, "foreperiod_min_ms": 500}
    later = new_session(history=resting.records, attempts=6, **timing)
    assert (later.waiting.stage, later.waiting.reason) == ("paused", "interrupted")
    began = later.clock.now()
    later.press("enter")
    assert later.waiting.stage == "rest"
    assert later.waiting.until - began == 40 * SECOND
