"""A lost sensor pauses the session, which resumes when it returns."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.app.screens.waiting_text import waiting_text
from sar_tui.loop.topics import PROMPT, SENSOR, SESSION_ENDED, TRIAL, VOIDED, WAITING
from sar_tui.model.messages import SensorChanged, SensorState
from sar_tui.model.theme import Theme
from tests.lifting_task import Lift, LiftDriver, SensedLift

NewSession = Callable[..., LiftDriver]


@pytest.fixture
def new_session(calm: Theme) -> NewSession:
    """Start a session of two attempts of two lifts each, before anything is known of the sensor."""

    def start(task: type[Lift] = SensedLift, **settings: Any) -> LiftDriver:
        return LiftDriver(task, calm, **{"attempts": 2, **settings})

    return start


@pytest.fixture
def lifting(new_session: NewSession) -> LiftDriver:
    """Start a session with a working sensor, ready for the first lift."""
    driver = new_session()
    sensor(driver, "attached")
    driver.begin_lifts()
    return driver


def sensor(driver: LiftDriver, state: SensorState, detail: str = "") -> None:
    driver.session.bus.publish(
        SENSOR, SensorChanged(state=state, at=driver.clock.now(), detail=detail)
    )


def waiting_state(driver: LiftDriver) -> tuple[str, str, str]:
    return driver.waiting.what, driver.waiting.stage, driver.waiting.reason


LOST = ("sensor", "paused", "sensor")
AT_START = ("start", "trial", "")


def test_the_session_waits_for_the_sensor_after_the_instructions(new_session: NewSession) -> None:
    driver = new_session()
    assert waiting_state(driver) == ("enter", "instructions", "")
    driver.enter()
    assert waiting_state(driver) == LOST
    driver.press("enter")
    driver.wait(60_000)
    assert waiting_state(driver) == LOST
    sensor(driver, "attached")
    assert waiting_state(driver) == ("enter", "attempt", "")


def test_a_working_sensor_causes_no_pause(lifting: LiftDriver) -> None:
    lifting.lift()
    assert all(waiting.reason != "sensor" for waiting in lifting.all(WAITING))


def test_a_task_without_sensors_ignores_them(new_session: NewSession) -> None:
    driver = new_session(Lift)
    driver.begin_lifts()
    sensor(driver, "detached")
    assert waiting_state(driver) == AT_START
    driver.operate("pause")
    driver.operate("resume")
    assert waiting_state(driver) == AT_START


@pytest.mark.parametrize(
    ("loss", "cure"), [("detached", "attached"), ("stalled", "flowing"), ("ended", "attached")]
)
def test_a_lost_sensor_voids_the_trial(
    lifting: LiftDriver, loss: SensorState, cure: SensorState
) -> None:
    lifting.press("space")
    lifting.to_prompt()
    lifting.press("k")
    sensor(lifting, loss, "It is loose.")
    assert waiting_state(lifting) == LOST
    assert lifting.waiting.detail == "It is loose."
    assert (lifting.last(VOIDED).trial, lifting.last(VOIDED).reason) == (1, "sensor")
    lifting.wait(60_000)
    lifting.press("enter")
    lifting.press("space")
    assert waiting_state(lifting) == LOST
    sensor(lifting, cure)
    assert waiting_state(lifting) == AT_START
    assert lifting.waiting.detail == ""
    lifting.wait(1000)
    lifting.lift()
    assert [(trial.trial, trial.correct) for trial in lifting.all(TRIAL)] == [(1, True)]
    assert lifting.last(TRIAL).timing.presentation == 2


@pytest.mark.parametrize(
    ("loss", "says"),
    [("stalled", "The session goes on by itself once"), ("ended", "so the session cannot go on.")],
)
def test_the_screen_says_whether_the_sensor_can_come_back(
    lifting: LiftDriver, loss: SensorState, says: str
) -> None:
    sensor(lifting, loss)
    session = lifting.session
    shown = waiting_text(lifting.waiting, session.task, is_recording_over=session.is_recording_over)
    assert shown is not None
    assert says in shown.text


def test_a_new_reason_of_the_loss_is_published(lifting: LiftDriver) -> None:
    sensor(lifting, "stalled", "Nothing comes.")
    sensor(lifting, "error", "The cable is broken.")
    assert (waiting_state(lifting), lifting.waiting.detail) == (LOST, "The cable is broken.")


@pytest.mark.parametrize("state", ["gap", "saturated", "error"])
def test_a_sensor_error_without_loss_stops_nothing(lifting: LiftDriver, state: SensorState) -> None:
    lifting.press("space")
    lifting.to_prompt()
    said = len(lifting.all(WAITING))
    sensor(lifting, state, "something")
    assert len(lifting.all(WAITING)) == said
    assert lifting.all(VOIDED) == []


def test_a_sensor_lost_between_attempts_pauses_the_session(lifting: LiftDriver) -> None:
    lifting.lift()
    lifting.lift()
    sensor(lifting, "detached")
    assert waiting_state(lifting) == LOST
    lifting.press("enter")
    assert waiting_state(lifting) == LOST
    sensor(lifting, "attached")
    assert (waiting_state(lifting), lifting.waiting.attempt) == (("enter", "attempt", ""), 2)
    assert lifting.all(VOIDED) == []


def test_after_the_last_attempt_a_lost_sensor_is_ignored(new_session: NewSession) -> None:
    driver = new_session(attempts=1, lifts=1)
    sensor(driver, "attached")
    driver.begin_lifts()
    driver.lift()
    sensor(driver, "detached")
    assert waiting_state(driver) == ("enter", "review", "")
    driver.operate("pause")
    driver.operate("resume")
    assert waiting_state(driver) == ("enter", "review", "")
    driver.press("enter")
    assert [ended.status for ended in driver.all(SESSION_ENDED)] == ["completed"]


def test_a_sensor_lost_before_the_last_feedback_is_ignored(new_session: NewSession) -> None:
    driver = new_session(attempts=1, feedback_delay_ms=3000)
    sensor(driver, "attached")
    driver.begin_lifts()
    driver.lift()
    driver.lift()
    assert waiting_state(driver) == ("answer", "answer", "")
    sensor(driver, "detached")
    driver.operate("pause")
    driver.operate("resume")
    driver.wait(3000)
    assert waiting_state(driver) == ("enter", "review", "")
    driver.press("enter")
    assert driver.last(SESSION_ENDED).status == "completed"


def test_a_sensor_lost_in_the_instructions_pauses_after_them(new_session: NewSession) -> None:
    driver = new_session()
    sensor(driver, "attached")
    sensor(driver, "detached", "Gone.")
    assert waiting_state(driver) == ("enter", "instructions", "")
    driver.enter()
    assert (waiting_state(driver), driver.waiting.detail) == (LOST, "Gone.")


def test_a_persons_pause_is_not_ended_by_the_sensor(lifting: LiftDriver) -> None:
    lifting.operate("pause", reason="tired")
    paused = waiting_state(lifting)
    sensor(lifting, "detached")
    assert waiting_state(lifting) == paused
    sensor(lifting, "attached")
    assert waiting_state(lifting) == paused
    lifting.operate("resume")
    assert waiting_state(lifting) == AT_START


def test_resuming_with_a_lost_sensor_waits_for_the_sensor(lifting: LiftDriver) -> None:
    lifting.operate("pause")
    sensor(lifting, "stalled", "Nothing comes.")
    lifting.operate("resume")
    assert (waiting_state(lifting), lifting.waiting.detail) == (LOST, "Nothing comes.")
    sensor(lifting, "flowing")
    assert waiting_state(lifting) == AT_START
    assert [voided.reason for voided in lifting.all(VOIDED)] == ["pause"]


def test_a_pause_during_sensor_loss_outlasts_its_return(lifting: LiftDriver) -> None:
    sensor(lifting, "detached")
    lifting.operate("pause", reason="pain")
    assert waiting_state(lifting) == ("resume", "paused", "pain")
    sensor(lifting, "attached")
    assert waiting_state(lifting) == ("resume", "paused", "pain")


def test_a_session_that_waits_for_a_sensor_can_be_ended(lifting: LiftDriver) -> None:
    sensor(lifting, "detached")
    lifting.operate("end")
    assert [ended.status for ended in lifting.all(SESSION_ENDED)] == ["aborted"]
    sensor(lifting, "attached")
    assert lifting.waiting.stage == "ended"


def test_a_sensor_that_returns_during_a_disk_failure_starts_nothing(lifting: LiftDriver) -> None:
    sensor(lifting, "detached")
    lifting.disk(False)
    assert lifting.waiting.reason == "storage"
    sensor(lifting, "attached")
    assert (lifting.waiting.stage, lifting.waiting.reason) == ("paused", "storage")
    lifting.disk(True)
    assert waiting_state(lifting) == ("enter", "paused", "restored")
    lifting.press("enter")
    assert waiting_state(lifting) == AT_START


def test_after_a_disk_failure_the_session_waits_for_a_lost_sensor(lifting: LiftDriver) -> None:
    sensor(lifting, "detached")
    lifting.disk(False)
    sensor(lifting, "stalled")
    lifting.disk(True)
    assert waiting_state(lifting) == LOST
    sensor(lifting, "attached")
    assert waiting_state(lifting) == AT_START


def test_a_sensor_lost_during_a_disk_failure_is_waited_for_afterwards(lifting: LiftDriver) -> None:
    lifting.disk(False)
    sensor(lifting, "detached")
    assert lifting.waiting.reason == "storage"
    lifting.disk(True)
    assert waiting_state(lifting) == ("enter", "paused", "restored")
    lifting.press("enter")
    assert waiting_state(lifting) == LOST


@pytest.mark.parametrize("lost", [False, True])
def test_a_resumed_session_waits_for_enter_then_for_its_sensor(
    lifting: LiftDriver, calm: Theme, lost: bool
) -> None:
    lifting.lift()
    if lost:
        sensor(lifting, "detached")
    resumed = LiftDriver(SensedLift, calm, attempts=2, history=lifting.records)
    assert waiting_state(resumed) == ("enter", "paused", "interrupted")
    resumed.press("enter")
    assert waiting_state(resumed) == LOST, "the sensor of this run has not reported yet"
    sensor(resumed, "attached")
    assert (waiting_state(resumed), resumed.waiting.trial) == (AT_START, 2)
    assert resumed.all(PROMPT) == []


def test_a_resumed_session_with_a_working_sensor_only_waits_for_enter(
    lifting: LiftDriver, calm: Theme
) -> None:
    sensor(lifting, "detached")
    resumed = LiftDriver(SensedLift, calm, attempts=2, history=lifting.records)
    sensor(resumed, "attached")
    assert waiting_state(resumed) == ("enter", "paused", "interrupted")
    resumed.press("enter")
    assert waiting_state(resumed) == AT_START
