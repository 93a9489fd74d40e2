"""A hand with a sensor and a space bar: reaches, rests and twitches are perceived as such."""

from itertools import pairwise
from typing import Any

import pytest

from sar_tui.inputs import sensor
from sar_tui.loop.topics import PROMPT, REACH, SENSOR, TRIAL, VOIDED
from sar_tui.model.messages import SensorChanged
from sar_tui.model.units import MS
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach_kinds import end_of
from sar_tui.motion.samples import Samples
from sar_tui.motion.synthesis import ReachShape
from sar_tui.motion.trajectories import SimulatedArm
from sar_tui.plugins import Catalogue
from tests.examples import first
from tests.tasks.reaching.reaching_driver import (
    FLICK,
    REACH_OUT,
    ReachingDriver,
    arm_that_holds,
    ms,
)

pytestmark = pytest.mark.usefixtures("fewer_blocks")

SLOW = ReachShape(out_s=1.2, back_s=1.2, peak_out=0.8, peak_back=-0.8)
MIRRORED = ReachShape(out_s=0.5, back_s=0.5, peak_out=-1.5, peak_back=1.5)
FAST = ReachShape(out_s=0.25, back_s=0.25, peak_out=3.1, peak_back=-3.1)
TOO_FAST = ReachShape(out_s=0.4, back_s=0.4, peak_out=6.0, peak_back=-6.0)


@pytest.fixture
def usual_blocks(fewer_blocks: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Send samples in blocks of 10 ms, as in a session."""
    monkeypatch.setattr("sar_tui.inputs.simulated.STEP", 10 * MS)
    monkeypatch.setattr("sar_tui.inputs.sensor.DRAIN", 10 * MS)


WITHIN_MS = 30
"""Largest difference between the time of a simulated reach of one second, from stillness to
stillness, and its result: the hand is slower than 1 % of its peak in the first and last 13 ms of
each way.
"""


def ready(**settings: Any) -> ReachingDriver:
    """A table at which the first reach can be started."""
    driver = ReachingDriver(**settings)
    driver.start_session()
    return driver


def started(**settings: Any) -> ReachingDriver:
    """A table at which the first reach has just been started."""
    driver = ready(**settings)
    driver.start()
    return driver


def about(value: float, within: float = WITHIN_MS) -> Any:
    return pytest.approx(value, abs=within)


def muted(driver: ReachingDriver, milliseconds: float) -> None:
    """So long the sensor's samples are lost on their way."""
    sink = driver.hand._sink
    driver.hand._sink = lambda sample: None
    driver.wait(milliseconds)
    driver.hand._sink = sink


# --- a hand that goes again


def six_reaches(
    hold_s: float, *, own_rest_ms: float | None = None, **settings: Any
) -> ReachingDriver:
    """A session of six reaches with a hold at the marker, each started as soon as the one before is
    a row.

    ``own_rest_ms``: a reach of one's own before each, nobody asked for it, with so much rest after
    it.
    """
    arm, shape = arm_that_holds("point-and-hold", hold_s)
    driver = ready(sensor=arm, attempts=1, reaches_per_attempt=6, **settings)
    while len(driver.all(TRIAL)) < 6:
        driver.to_start()
        if own_rest_ms is not None:
            driver.move(0, shape)
            driver.wait(shape.duration_s * 1000 + own_rest_ms)
        driver.wait(400)
        driver.start()
        driver.move(200, shape)
        driver.wait(200 + shape.duration_s * 1000 + 300)
        driver.press("space")
        driver.to_row()
    return driver


def found(driver: ReachingDriver) -> list[bool]:
    """Return of each reach whether it was found with about its duration."""
    arm = driver.hand.hand
    assert isinstance(arm, SimulatedArm)
    duration_s = end_of(arm._person.back)
    return [
        trial.correct and trial.value == pytest.approx(1000 * duration_s, rel=0.15)
        for trial in driver.all(TRIAL)
    ]


@pytest.mark.parametrize("hold_s", [0.3, 4.0])
def test_six_of_six_reaches_are_found_of_a_person_who_holds_at_the_marker_and_goes_again(
    hold_s: float,
) -> None:
    driver = six_reaches(hold_s)
    assert found(driver) == [True] * 6
    reaches = driver.all(TRIAL)
    for before, after in pairwise(reaches):
        assert after.details["window_from_ns"] >= before.response_at


def test_a_movement_of_ones_own_before_the_start_key_is_no_part_of_the_reach() -> None:
    assert found(six_reaches(0.8, own_rest_ms=400)) == [True] * 6


# --- a reach between two presses


def test_a_reach_is_one_row_timed_by_the_hand_not_by_the_keys() -> None:
    driver = started()
    driver.move(300)
    onset = driver.clock.now() + 300 * MS
    driver.wait(1700)
    driver.press("space")
    pressed = driver.clock.now()
    trial = driver.to_row()
    assert (trial.correct, trial.response, trial.stimulus) == (True, "reach", "15 cm")
    assert ms(trial.onset - onset) == about(0, 15)
    assert ms(trial.response_at - onset) == about(1000, 15)
    assert trial.value == about(1000)
    assert trial.value == about(ms(trial.response_at - trial.onset), 0.01)
    assert trial.value == trial.details["reach_time_ms"]
    assert trial.details["closed"] == "key"
    assert trial.reaction_time_ms is None, "there was no signal"
    assert (driver.percept.at, driver.percept.end) == (trial.response_at, trial.response_at)
    assert trial.response_at < pressed
    assert driver.all(VOIDED) == []
    assert len(driver.all(REACH)) == 1


@pytest.mark.usefixtures("usual_blocks")
def test_a_reach_is_reported_as_soon_as_the_hand_rests() -> None:
    driver = started()
    driver.move(300)
    driver.wait(1300 + 2000)
    driver.press("space")
    pressed = driver.clock.now()
    driver.to_row()
    assert ms(driver.clock.now() - pressed) <= 20, "it had rested for long"


def test_a_second_press_before_the_return_does_not_shorten_the_reach() -> None:
    driver = started()
    driver.move(300, SLOW)
    driver.wait(300 + SLOW.duration_s * 1000 - 600)
    driver.press("space")
    pressed = driver.clock.now()
    trial = driver.to_row()
    assert trial.value == about(SLOW.duration_s * 1000, 3 * WITHIN_MS)
    assert trial.response_at > pressed
    assert (trial.details["closed"], trial.timing.flags) == ("key", ())


@pytest.mark.usefixtures("usual_blocks")
def test_a_hand_that_keeps_moving_after_the_second_press_repeats_the_trial() -> None:
    driver = started()
    driver.move(300, ReachShape(out_s=5.0, back_s=5.0))
    driver.wait(2000)
    driver.press("space")
    pressed = driver.clock.now()
    driver.to_start()
    assert 4000 <= ms(driver.clock.now() - pressed) <= 4020
    assert driver.all(TRIAL) == []
    assert driver.last(VOIDED).reason == "unfinished"
    assert "still moving" in driver.waiting.notice


@pytest.mark.parametrize("presses", first(2, [(1, 40), (6, 90), (1, 240), (6, 300), (6, 600)]))
def test_a_held_or_doubled_key_does_not_end_a_trial_before_the_hand_has_moved(
    presses: tuple[int, float],
) -> None:
    count, between_ms = presses
    driver = started()
    for _ in range(count):
        driver.wait(between_ms)
        driver.press("space")
    assert driver.all(REACH) == []
    driver.wait(800)
    driver.move()
    assert driver.finish(1500).value == about(1000)


def test_a_key_that_is_tapped_all_the_time_ends_the_reach_once_the_hand_has_moved() -> None:
    driver = started()
    driver.move(300)
    for _ in range(8):
        driver.wait(500)
        driver.press("space")
    trial = driver.last(TRIAL)
    assert (trial.details["closed"], trial.value) == ("key", about(1000))


def test_a_reach_stores_the_declared_details() -> None:
    stored = ready().reach(SLOW).details
    declared = set(Catalogue().task("reaching").Details.__struct_fields__)
    assert set(stored) | {"mark", "trunk_excursion_deg", "compensation_share"} == declared
    assert [name for name, value in stored.items() if value is None] == ["tremor_rest_hz"]


# --- presses that are missing, doubled or early


@pytest.mark.parametrize("still_ms", first(1, [1500, 2500, 6000]))
def test_rest_replaces_a_forgotten_second_press(still_ms: int) -> None:
    driver = started(still_ms=still_ms)
    driver.move(300)
    end = driver.clock.now() + 1300 * MS
    trial = driver.to_row()
    assert (trial.correct, trial.details["closed"]) == (True, "stillness")
    assert trial.value == about(1000)
    assert still_ms - 100 <= ms(driver.clock.now() - end) <= still_ms + 600


def test_rest_before_the_reach_does_not_end_it() -> None:
    driver = started()
    driver.wait(9000)
    assert driver.all(REACH) == []
    driver.move()
    assert driver.to_row().correct


def test_rest_at_the_marker_does_not_end_the_reach() -> None:
    driver = started(still_ms=1000)
    driver.move(100, ReachShape(out_s=0.5, dwell_s=1.8, back_s=0.5, peak_out=1.5, peak_back=-1.5))
    driver.wait(100 + 500 + 1700)
    assert driver.all(REACH) == []
    trial = driver.to_row()
    assert trial.details["dwell_ms"] == about(1800, 120)


def test_every_trial_ends_at_the_time_out() -> None:
    driver = started(response_timeout_ms=5000)
    prompted = [record.at for record in driver.records if record.topic is PROMPT][-1]
    trial = driver.to_row()
    assert (trial.correct, trial.response, trial.value) == (False, None, None)
    assert (trial.details["closed"], trial.timing.flags) == ("timeout", ("no_reach",))
    assert ms(driver.clock.now() - prompted) == 5000


def test_a_reach_completed_at_the_time_out_without_rest_is_stored() -> None:
    driver = started(response_timeout_ms=3000, still_ms=6000)
    driver.move(300)
    trial = driver.to_row()
    assert (trial.correct, trial.details["closed"], trial.value) == (True, "timeout", about(1000))


def test_a_press_right_before_the_time_out_still_ends_the_reach() -> None:
    driver = started(response_timeout_ms=3000, sensor="tremor")
    driver.move(1500)
    trial = driver.finish(2600)
    assert (trial.correct, trial.details["closed"], trial.value) == (True, "key", about(1000, 60))


def test_a_double_press_at_the_end_does_not_start_a_trial() -> None:
    driver = started(reaches_per_attempt=2)
    driver.move(300)
    driver.wait(1700)
    driver.press("space")
    driver.wait(200)
    driver.press("space")
    driver.to_row()
    assert driver.percept.closed == "key"
    assert (driver.waiting.what, driver.waiting.trial) == ("start", 2)
    assert len(driver.all(PROMPT)) == 1


def test_another_key_does_not_end_a_reach() -> None:
    driver = started()
    driver.move(300)
    driver.wait(1500)
    driver.press("enter")
    driver.wait(1500)
    assert driver.all(REACH) == []


# --- movements that are none, or begin elsewhere


def test_a_flick_of_the_wrist_is_no_reach() -> None:
    driver = started()
    driver.move(300, FLICK)
    trial = driver.finish(1000)
    assert (trial.correct, trial.response, trial.timing.flags) == (False, None, ("no_reach",))
    assert trial.details["single_axis_reach_time_ms"] is None
    assert trial.details["fixed_threshold_reach_time_ms"] == about(300), (
        "for the thesis any motion is one"
    )


def test_a_flick_does_not_end_the_wait_for_a_reach() -> None:
    driver = started()
    driver.move(300, FLICK)
    driver.wait(6000)
    assert driver.all(REACH) == []
    driver.move()
    trial = driver.finish(1500)
    assert (trial.correct, trial.details["reaches"]) == (True, 1)
    assert trial.value == about(1000)


def test_the_larger_of_two_reaches_is_used_and_flagged() -> None:
    driver = started()
    driver.move(300, SLOW)
    driver.move(4000)
    driver.move(5700, SLOW)
    trial = driver.finish(8500)
    assert (trial.timing.flags, trial.details["reaches"]) == (("several",), 3)
    assert trial.value == about(1000)


@pytest.mark.parametrize(
    ("before_ms", "is_it"), [(50, True), (300, True), (450, True), (560, False), (900, False)]
)
def test_a_reach_may_begin_up_to_half_a_second_before_the_press(
    before_ms: float, is_it: bool
) -> None:
    driver = ready()
    driver.move(2000)
    onset = driver.clock.now() + 2000 * MS
    driver.wait(2000 + before_ms)
    driver.start()
    trial = driver.finish(1500)
    assert trial.correct is is_it
    if is_it:
        assert ms(trial.onset - onset) == about(0, 15)
        assert trial.value == about(1000)


def test_a_reach_that_ended_before_the_press_is_ignored() -> None:
    driver = ready()
    driver.move()
    driver.wait(1500)
    driver.start()
    trial = driver.finish(600)
    assert (trial.correct, trial.details["reaches"]) == (False, 0)


# --- a signal to go


def test_with_a_go_signal_there_is_a_reaction_time() -> None:
    driver = started(go_signal=True)
    driver.move(320)
    trial = driver.finish(320 + 1400)
    assert trial.reaction_time_ms == about(320, 15)
    assert trial.value == about(1000)
    assert trial.timing.foreperiod_ms >= 500


def test_movement_before_the_signal_is_an_anticipation() -> None:
    driver = started(go_signal=True)
    driver.move(-200)
    trial = driver.finish(1400)
    assert (trial.correct, trial.reaction_time_ms, trial.value) == (True, None, None)
    assert trial.timing.flags == ("anticipation",)


# --- hands and sensors


@pytest.mark.parametrize(("shape", "is_reversed"), [(REACH_OUT, True), (MIRRORED, False)])
def test_the_left_hand_turns_the_other_way(shape: ReachShape, is_reversed: bool) -> None:
    trial = ready(hand="left").reach(shape)
    assert (trial.correct, trial.details["hand"]) == (True, "left")
    assert ("reversed" in trial.timing.flags) is is_reversed
    assert float(trial.details["peak_extension_rad_s"] or 0) > 1.3
    assert float(trial.details["peak_return_rad_s"] or 0) < -1.3
    assert trial.value == about(1000)


@pytest.mark.parametrize("name", ["single-axis", "fixed-threshold"])
def test_the_selected_detector_scores(name: DetectorName) -> None:
    trial = ready(detector=name).reach()
    assert trial.details["detector"] == name
    assert trial.value == trial.details[f"{COLUMN_NAMES[name]}_reach_time_ms"]


def test_a_reach_beyond_the_range_is_timed_without_peaks() -> None:
    driver = ready(sensor="saturating")
    trial = driver.reach(FAST)
    assert trial.correct
    assert "saturated" in trial.timing.flags
    for name in ("peak_extension_rad_s", "peak_return_rad_s", "time_to_peak_ms"):
        assert trial.details[name] is None, name
    assert trial.value == about(500, 60)
    driver.wait(300)
    driver.begin()
    slower = driver.reach()
    assert "saturated" not in slower.timing.flags, "a flag of one reach is not carried to the next"
    assert slower.details["peak_extension_rad_s"] is not None


def test_a_reach_with_missing_samples_is_repeated() -> None:
    driver = started()
    driver.move(300)
    driver.wait(600)
    muted(driver, 250)
    driver.wait(1000)
    driver.press("space")
    driver.to_start()
    assert driver.all(TRIAL) == []
    assert (driver.last(VOIDED).reason, driver.waiting.trial) == ("gap", 1)
    assert "missed a part" in driver.waiting.notice
    driver.wait(700)
    assert driver.reach().correct
    assert driver.last(TRIAL).timing.presentation == 2


def test_a_gap_at_rest_does_not_affect_the_reach() -> None:
    driver = started()
    muted(driver, 250)
    driver.wait(300)
    driver.move()
    trial = driver.finish(1500)
    assert trial.correct
    assert trial.value == about(1000)


@pytest.mark.usefixtures("usual_blocks")
def test_a_reach_without_samples_is_repeated() -> None:
    driver = ready()
    driver.session.bus.publish(
        SENSOR, SensorChanged(state="attached", at=driver.clock.now(), rate_hz=250.0)
    )
    sink = driver.hand._sink
    driver.hand._sink = lambda sample: sink(sample) if sample.device_ms % 400 < 4 else None
    driver.start()
    driver.wait(1600)
    driver.press("space")
    driver.to_start()
    assert (driver.percept.invalid, driver.all(TRIAL)) == ("samples", [])
    assert "sent nothing" in driver.waiting.notice


def test_a_sensor_too_slow_for_a_reach_is_reported() -> None:
    driver = started(rate_hz=15.0)
    driver.move(300)
    driver.wait(1700)
    driver.press("space")
    driver.to_start()
    assert driver.session.faults == []
    assert (driver.percept.invalid, driver.all(TRIAL)) == ("rate", [])
    assert "too slow" in driver.waiting.notice


@pytest.mark.usefixtures("usual_blocks")
def test_a_sensor_detached_during_a_reach_voids_it_and_old_samples_are_dropped() -> None:
    driver = started()
    driver.move(300)
    driver.wait(800)
    for state in ("detached", "attached"):
        driver.session.bus.publish(
            SENSOR,
            SensorChanged(state=state, at=driver.clock.now(), rate_hz=250.0),  # type: ignore[arg-type]
        )
    attached = driver.clock.now()
    assert (driver.waiting.what, driver.last(VOIDED).reason) == ("start", "sensor")
    driver.wait(1000)
    trial = driver.reach()
    assert trial.correct
    assert int(trial.details["window_from_ns"] or 0) >= attached


# --- whatever the blocks that samples come in


def one_reach(monkeypatch: pytest.MonkeyPatch, drain_ms: float, press: bool) -> tuple[Any, Samples]:
    monkeypatch.setattr(sensor, "DRAIN", round(drain_ms * MS))
    driver = started(sensor="patient")
    driver.move(300)
    driver.wait(1700)
    if press:
        driver.press("space")
    return driver.to_row(), driver.samples


@pytest.mark.usefixtures("usual_blocks")
@pytest.mark.parametrize("press", [True, False])
@pytest.mark.parametrize("drain_ms", first(1, [4, 30, 250]))
def test_the_size_of_blocks_does_not_change_a_reach(
    monkeypatch: pytest.MonkeyPatch, drain_ms: float, press: bool
) -> None:
    usual, samples = one_reach(monkeypatch, 10, press)
    other, same_samples = one_reach(monkeypatch, drain_ms, press)
    both = min(len(samples), len(same_samples))
    assert samples[:both].tobytes() == same_samples[:both].tobytes()
    assert other.details["closed"] == usual.details["closed"]
    assert other.value == about(usual.value, 3)
    assert ms(other.onset - usual.onset) == about(0, 3)
    assert (
        abs(other.details["window_to_ns"] - usual.details["window_to_ns"]) <= max(drain_ms, 10) * MS
    )
