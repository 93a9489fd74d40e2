"""A lost sensor pauses the session, which resumes when it returns."""

from typing import Any

import pytest

from sar_tui.app.screens.waiting_text import waiting_text
from sar_tui.loop import topics as t
from sar_tui.model.messages import SensorChanged, SensorState
from tests.facts import each, facts
from tests.lifting_task import Lift, LiftDriver, SensedLift, lifting

LOST = ("sensor", "paused", "sensor")
AT_START = ("start", "trial", "")
AT_REVIEW = ("enter", "review", "")
RESTORED = ("enter", "paused", "restored")


def sensed(at: str = "start", **settings: Any) -> LiftDriver:
    """Start a session with a working sensor, by default ready for the first lift."""
    driver = lifting("instructions", SensedLift, **settings)
    sensor(driver, "attached")
    if at == "start":
        driver.begin_lifts()
    return driver


def sensor(driver: LiftDriver, state: SensorState, detail: str = "") -> None:
    changed = SensorChanged(state=state, at=driver.clock.now(), detail=detail)
    driver.session.bus.publish(t.SENSOR, changed)


def place(driver: LiftDriver) -> tuple[Any, ...]:
    return facts(driver.waiting, "what stage reason")


def test_the_session_waits_for_the_sensor_after_the_instructions() -> None:
    driver = lifting("instructions", SensedLift)
    assert place(driver) == ("enter", "instructions", "")
    driver.enter()
    assert place(driver) == LOST
    driver.press("enter")
    driver.wait(60_000)
    assert place(driver) == LOST
    sensor(driver, "attached")
    assert place(driver) == ("enter", "attempt", "")


def test_a_task_without_sensors_ignores_them() -> None:
    driver = lifting("start", Lift)
    sensor(driver, "detached")
    assert place(driver) == AT_START
    driver.operate("pause")
    driver.operate("resume")
    assert place(driver) == AT_START


@pytest.mark.parametrize(
    ("loss", "cure"), [("detached", "attached"), ("stalled", "flowing"), ("ended", "attached")]
)
def test_a_lost_sensor_voids_the_trial(loss: SensorState, cure: SensorState) -> None:
    driver = sensed()
    driver.to_lift()
    driver.press("k")
    sensor(driver, loss, "It is loose.")
    assert (place(driver), driver.waiting.detail) == (LOST, "It is loose.")
    assert facts(driver.last(t.VOIDED), "trial reason") == (1, "sensor")
    driver.wait(60_000)
    driver.press("enter")
    driver.press("space")
    assert place(driver) == LOST
    sensor(driver, cure)
    assert (place(driver), driver.waiting.detail) == (AT_START, "")
    assert not driver.session.is_recording_over
    driver.wait(1000)
    driver.lift()
    assert each(driver.all(t.TRIAL), "trial correct timing.presentation") == [(1, True, 2)]


@pytest.mark.parametrize(("loss", "says"), [("stalled", "by itself"), ("ended", "cannot go on")])
def test_the_screen_says_whether_the_sensor_can_come_back(loss: SensorState, says: str) -> None:
    driver = sensed()
    sensor(driver, loss)
    over = driver.session.is_recording_over
    shown = waiting_text(driver.waiting, driver.session.task, is_recording_over=over)
    assert shown is not None
    assert says in shown.text


def test_a_new_reason_of_the_loss_is_published() -> None:
    driver = sensed()
    sensor(driver, "stalled", "Nothing comes.")
    sensor(driver, "error", "The cable is broken.")
    assert (place(driver), driver.waiting.detail) == (LOST, "The cable is broken.")


@pytest.mark.parametrize("state", ["gap", "saturated", "error"])
def test_a_sensor_error_without_loss_stops_nothing(state: SensorState) -> None:
    driver = sensed()
    driver.to_lift()
    said = len(driver.all(t.WAITING))
    sensor(driver, state, "something")
    assert (len(driver.all(t.WAITING)), driver.all(t.VOIDED)) == (said, [])


def test_a_sensor_lost_between_attempts_pauses_the_session() -> None:
    driver = sensed()
    driver.lift()
    driver.lift()
    sensor(driver, "detached")
    driver.press("enter")
    assert place(driver) == LOST
    sensor(driver, "attached")
    assert (place(driver), driver.waiting.attempt) == (("enter", "attempt", ""), 2)
    assert driver.all(t.VOIDED) == []


@pytest.mark.parametrize("delay_ms", [0, 3000])
def test_after_the_last_attempt_a_lost_sensor_is_ignored(delay_ms: int) -> None:
    driver = sensed(attempts=1, lifts=1, feedback_delay_ms=delay_ms)
    driver.lift()
    assert place(driver) == (("answer", "answer", "") if delay_ms else AT_REVIEW)
    sensor(driver, "detached")
    driver.operate("pause")
    driver.operate("resume")
    driver.wait(delay_ms)
    assert place(driver) == AT_REVIEW
    driver.press("enter")
    assert each(driver.all(t.SESSION_ENDED), "status") == ["completed"]


def test_a_sensor_lost_in_the_instructions_pauses_after_them() -> None:
    driver = sensed("instructions")
    sensor(driver, "detached", "Gone.")
    assert place(driver) == ("enter", "instructions", "")
    driver.enter()
    assert (place(driver), driver.waiting.detail) == (LOST, "Gone.")


def test_resuming_with_a_lost_sensor_waits_for_the_sensor() -> None:
    driver = sensed()
    driver.operate("pause")
    sensor(driver, "stalled", "Nothing comes.")
    driver.operate("resume")
    assert (place(driver), driver.waiting.detail) == (LOST, "Nothing comes.")
    sensor(driver, "flowing")
    assert place(driver) == AT_START
    assert each(driver.all(t.VOIDED), "reason") == ["pause"]


def test_a_pause_during_sensor_loss_outlasts_its_return() -> None:
    driver = sensed()
    sensor(driver, "detached")
    driver.operate("pause", reason="pain")
    assert place(driver) == ("resume", "paused", "pain")
    sensor(driver, "attached")
    assert place(driver) == ("resume", "paused", "pain")


# --- with a disk that fails, too


def test_a_sensor_that_returns_during_a_disk_failure_starts_nothing() -> None:
    driver = sensed()
    sensor(driver, "detached")
    driver.disk(False)
    assert driver.waiting.reason == "storage"
    sensor(driver, "attached")
    assert facts(driver.waiting, "stage reason") == ("paused", "storage")
    driver.disk(True)
    assert place(driver) == RESTORED
    driver.press("enter")
    assert place(driver) == AT_START


def test_after_a_disk_failure_the_session_waits_for_a_lost_sensor() -> None:
    driver = sensed()
    sensor(driver, "detached")
    driver.disk(False)
    sensor(driver, "stalled")
    driver.disk(True)
    assert place(driver) == LOST
    sensor(driver, "attached")
    assert place(driver) == AT_START


# --- after a resume


@pytest.mark.parametrize("lost", [False, True])
@pytest.mark.parametrize("reports", ["before Enter", "after Enter"])
def test_a_resumed_session_waits_for_enter_then_for_its_sensor(lost: bool, reports: str) -> None:
    driver = sensed()
    driver.lift()
    if lost:
        sensor(driver, "detached")
    resumed = lifting("instructions", SensedLift, history=driver.records)
    if reports == "before Enter":
        sensor(resumed, "attached")
    assert place(resumed) == ("enter", "paused", "interrupted")
    resumed.press("enter")
    if reports == "after Enter":
        assert place(resumed) == LOST, "the sensor of this run has not reported yet"
        sensor(resumed, "attached")
    assert (place(resumed), resumed.waiting.trial) == (AT_START, 2)
    assert resumed.all(t.PROMPT) == []
