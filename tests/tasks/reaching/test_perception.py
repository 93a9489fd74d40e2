"""Given a hand with a sensor and a space bar, when it reaches, rests or twitches, then each is told as it was."""

from typing import Any

import msgspec
import numpy as np
import pytest

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import SensorChanged
from sar_tui.framework.topics import ATTEMPT_ENDED, PROMPT, REACH, SENSOR, TRIAL, VOIDED
from sar_tui.inputs import sensor
from sar_tui.motion.analysis import Window, analyse
from sar_tui.motion.samples import Samples
from sar_tui.motion.shapes import ReachShape
from sar_tui.plugins import Catalogue
from tests.tasks.reaching.table import FLICK, REACH_OUT, Table, ms

SLOW = ReachShape(out_s=1.2, back_s=1.2, peak_out=0.8, peak_back=-0.8)
MIRRORED = ReachShape(out_s=0.5, back_s=0.5, peak_out=-1.5, peak_back=1.5)
FAST = ReachShape(out_s=0.25, back_s=0.25, peak_out=3.1, peak_back=-3.1)
TOO_FAST = ReachShape(out_s=0.4, back_s=0.4, peak_out=6.0, peak_back=-6.0)


def begun(**settings: Any) -> Table:
    """A table at which the first reach has just been started."""
    table = Table(**settings)
    table.sit_down()
    table.start()
    return table


def gagged(table: Table, milliseconds: float) -> None:
    """So long the sensor's samples are lost on their way."""
    sink = table.hand._sink
    table.hand._sink = lambda sample: None
    table.wait(milliseconds)
    table.hand._sink = sink


def again(table: Table, to_ns: int = 0) -> Any:
    """The last reach, analysed once more from the samples and the window that its details name."""
    details = table.last(TRIAL).details
    window = Window(
        from_ns=int(details["window_from_ns"] or 0),
        started_ns=int(details["window_started_ns"] or 0),
        to_ns=to_ns or int(details["window_to_ns"] or 0),
    )
    task: Any = table.session.task
    return analyse(table.samples, window, task.analysis())


# --- a reach between two presses -----------------------------------------------------------------------------------


def test_one_reach_between_two_presses_is_one_row_timed_by_the_hand_and_not_by_the_keys() -> None:
    table = begun()
    table.move(300)
    onset = table.clock.now() + 300 * MS
    table.wait(1700)
    table.press("space")
    pressed = table.clock.now()
    trial = table.to_row()
    assert (trial.correct, trial.response, trial.stimulus) == (True, "reach", "15 cm")
    assert ms(trial.onset - onset) == pytest.approx(0, abs=15)
    assert ms(trial.response_at - onset) == pytest.approx(1000, abs=15)
    assert trial.value == pytest.approx(1000, abs=20)
    assert trial.value == trial.details["reach_time_ms"] == pytest.approx(ms(trial.response_at - trial.onset), abs=0.01)
    assert trial.details["closed"] == "key"
    assert (table.percept.at, table.percept.end) == (trial.response_at, trial.response_at)
    assert trial.response_at < pressed
    assert table.all(VOIDED) == []
    assert len(table.all(REACH)) == 1


def test_a_reach_is_told_as_soon_as_the_hand_is_felt_to_rest_not_when_a_time_is_over() -> None:
    table = begun()
    table.move(300)
    table.wait(1300 + 2000)
    table.press("space")
    pressed = table.clock.now()
    table.to_row()
    assert ms(table.clock.now() - pressed) <= 20, "it had rested for long"


def test_a_second_press_before_the_hand_is_back_shortens_nothing() -> None:
    table = begun()
    table.move(300, SLOW)
    table.wait(300 + SLOW.duration_s * 1000 - 600)
    table.press("space")
    pressed = table.clock.now()
    trial = table.to_row()
    assert trial.value == pytest.approx(SLOW.duration_s * 1000, abs=30)
    assert trial.response_at > pressed
    assert (trial.details["closed"], trial.timing.flags) == ("key", ())


def test_a_hand_that_moves_on_and_on_after_the_second_press_is_asked_to_do_it_once_more() -> None:
    table = begun()
    table.move(300, ReachShape(out_s=5.0, back_s=5.0))
    table.wait(2000)
    table.press("space")
    pressed = table.clock.now()
    table.to_start()
    assert 4000 <= ms(table.clock.now() - pressed) <= 4020
    assert table.all(TRIAL) == []
    assert (table.last(VOIDED).reason, "still moving" in table.waiting.notice) == ("unfinished", True)


@pytest.mark.parametrize("between_ms", [90, 300, 600])
def test_a_key_that_is_held_ends_nothing_before_the_hand_has_moved(between_ms: float) -> None:
    table = begun()
    for _ in range(6):
        table.wait(between_ms)
        table.press("space")
    assert table.all(REACH) == []
    table.wait(800)
    table.move()
    table.wait(1500)
    table.press("space")
    assert table.to_row().value == pytest.approx(1000, abs=20)


def test_reaches_follow_each_other_each_with_its_own_window() -> None:
    table = Table(reaches_per_attempt=3, attempts=1)
    table.sit_down()
    values = []
    for number, shape in enumerate([REACH_OUT, SLOW, FAST], 1):
        trial = table.reach(shape)
        assert trial.trial == number
        values.append(trial.value)
        table.wait(500)
    assert values == [pytest.approx(shape.duration_s * 1000, rel=0.06) for shape in (REACH_OUT, SLOW, FAST)]
    assert table.last(ATTEMPT_ENDED).metric == pytest.approx(float(np.mean(values)))
    assert [trial.details["reaches"] for trial in table.all(TRIAL)] == [1, 1, 1]


def test_both_detectors_are_in_the_details_and_the_one_that_was_asked_for_scores() -> None:
    for name in ("robust", "thesis"):
        table = Table(detector=name)
        table.sit_down()
        trial = table.reach()
        details = trial.details
        assert details["detector"] == name
        assert trial.value == details["reach_time_ms"] == details[f"{name}_reach_time_ms"]
        assert details["robust_reach_time_ms"] != details["thesis_reach_time_ms"]
        assert details["thesis_reach_time_ms"] == pytest.approx(930, abs=15), "the time above 0.1 rad/s"
        parameters = msgspec.json.decode(str(details["detector_parameters"]))
        assert ("threshold_rad_s" in parameters) == (name == "thesis")


def test_what_is_kept_of_a_reach_is_what_is_declared() -> None:
    table = Table()
    table.sit_down()
    kept = table.reach().details
    declared = set(Catalogue().task("reaching").Details.__struct_fields__)
    assert set(kept) | {"mark"} == declared
    assert all(value is not None for value in kept.values())


def test_the_same_samples_and_window_give_the_same_details() -> None:
    table = Table(sensor="noisy")
    table.sit_down()
    trial = table.reach()
    found = again(table)
    assert found.details.items() <= trial.details.items()
    assert (found.onset_ns, found.turn_ns, found.end_ns) == (
        trial.onset,
        trial.details["turn_ns"],
        trial.response_at,
    )


# --- presses that are missing, doubled or early --------------------------------------------------------------------


@pytest.mark.parametrize("still_ms", [1500, 2500, 6000])
def test_a_forgotten_second_press_is_made_up_for_by_rest(still_ms: int) -> None:
    table = begun(still_ms=still_ms)
    table.move(300)
    end = table.clock.now() + 1300 * MS
    trial = table.to_row()
    assert (trial.correct, trial.details["closed"]) == (True, "stillness")
    assert trial.value == pytest.approx(1000, abs=20)
    assert still_ms - 100 <= ms(table.clock.now() - end) <= still_ms + 600


def test_a_hand_that_rests_before_its_reach_is_given_time() -> None:
    table = begun()
    table.wait(9000)
    assert table.all(REACH) == []
    table.move()
    assert table.to_row().correct


def test_a_hand_that_rests_at_the_marker_has_not_come_back() -> None:
    table = begun(still_ms=1000)
    table.move(100, ReachShape(out_s=0.5, dwell_s=1.8, back_s=0.5, peak_out=1.5, peak_back=-1.5))
    table.wait(100 + 500 + 1700)
    assert table.all(REACH) == []
    trial = table.to_row()
    assert trial.details["dwell_ms"] == pytest.approx(1800, abs=120)


def test_nothing_outlasts_the_time_out() -> None:
    table = begun(response_timeout_ms=5000)
    prompted = [record.at for record in table.records if record.topic is PROMPT][-1]
    trial = table.to_row()
    assert (trial.correct, trial.response, trial.value) == (False, None, None)
    assert (trial.details["closed"], trial.timing.flags) == ("timeout", ("no_reach",))
    assert ms(table.clock.now() - prompted) == 5000


def test_a_reach_that_the_time_out_finds_over_but_not_at_rest_is_kept() -> None:
    table = begun(response_timeout_ms=3000, still_ms=6000)
    table.move(300)
    trial = table.to_row()
    assert (trial.correct, trial.details["closed"]) == (True, "timeout")
    assert trial.value == pytest.approx(1000, abs=20)


def test_a_press_right_before_the_time_out_still_ends_the_reach() -> None:
    table = begun(response_timeout_ms=3000, sensor="tremor")
    table.move(1500)
    table.wait(2600)
    table.press("space")
    trial = table.to_row()
    assert (trial.correct, trial.details["closed"]) == (True, "key")
    assert trial.value == pytest.approx(1000, abs=60)


@pytest.mark.parametrize("after_ms", [40, 120, 240])
def test_a_start_that_is_pressed_twice_ends_nothing(after_ms: float) -> None:
    table = begun()
    table.wait(after_ms)
    table.press("space")
    table.wait(200)
    table.move()
    table.wait(1400)
    assert table.all(REACH) == []
    table.press("space")
    assert table.to_row().value == pytest.approx(1000, abs=20)


def test_an_end_that_is_pressed_twice_starts_nothing() -> None:
    table = begun(reaches_per_attempt=2)
    table.move(300)
    table.wait(1700)
    table.press("space")
    table.wait(200)
    table.press("space")
    table.to_row()
    assert table.percept.closed == "key"
    assert (table.waiting.what, table.waiting.trial) == ("start", 2)
    assert len(table.all(PROMPT)) == 1


@pytest.mark.parametrize("key", ["enter", "x", "s"])
def test_another_key_ends_no_reach(key: str) -> None:
    table = begun()
    table.move(300)
    table.wait(1500)
    table.press(key)
    table.wait(1500)
    assert table.all(REACH) == []


# --- movements that are none, or begin elsewhere ---------------------------------------------------------------------


def test_a_flick_of_the_wrist_is_no_reach() -> None:
    table = begun()
    table.move(300, FLICK)
    table.wait(1000)
    table.press("space")
    trial = table.to_row()
    assert (trial.correct, trial.response, trial.timing.flags) == (False, None, ("no_reach",))
    assert trial.details["robust_reach_time_ms"] is None
    assert trial.details["thesis_reach_time_ms"] == pytest.approx(300, abs=30), "for the thesis any motion is one"


def test_a_flick_does_not_end_the_wait_for_a_reach() -> None:
    table = begun()
    table.move(300, FLICK)
    table.wait(6000)
    assert table.all(REACH) == []
    table.move()
    table.wait(1500)
    table.press("space")
    trial = table.to_row()
    assert (trial.correct, trial.details["reaches"]) == (True, 1)
    assert trial.value == pytest.approx(1000, abs=20)


def test_of_two_reaches_the_larger_is_meant_and_it_is_flagged() -> None:
    table = begun()
    table.move(300, SLOW)
    table.move(4000)
    table.move(5700, SLOW)
    table.wait(8500)
    table.press("space")
    trial = table.to_row()
    assert (trial.timing.flags, trial.details["reaches"]) == (("several",), 3)
    assert trial.value == pytest.approx(1000, abs=20)


@pytest.mark.parametrize(("before_ms", "is_it"), [(50, True), (300, True), (450, True), (560, False), (900, False)])
def test_a_reach_that_began_up_to_half_a_second_before_the_press_is_this_reach(before_ms: float, is_it: bool) -> None:
    table = Table()
    table.sit_down()
    table.move(2000)
    onset = table.clock.now() + 2000 * MS
    table.wait(2000 + before_ms)
    table.start()
    table.wait(1500)
    table.press("space")
    trial = table.to_row()
    assert trial.correct is is_it
    if is_it:
        assert ms(trial.onset - onset) == pytest.approx(0, abs=15)
        assert trial.value == pytest.approx(1000, abs=20)


def test_a_reach_that_was_over_before_the_press_is_none_of_this_trial() -> None:
    table = Table()
    table.sit_down()
    table.move()
    table.wait(1500)
    table.start()
    table.wait(600)
    table.press("space")
    trial = table.to_row()
    assert (trial.correct, trial.details["reaches"]) == (False, 0)


# --- a signal to go --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reaction_ms", [180, 320])
def test_a_signal_to_go_gives_a_reaction_time(reaction_ms: float) -> None:
    table = begun(go_signal=True)
    table.move(reaction_ms)
    table.wait(reaction_ms + 1400)
    table.press("space")
    trial = table.to_row()
    assert trial.reaction_time_ms == pytest.approx(reaction_ms, abs=15)
    assert trial.value == pytest.approx(1000, abs=20)
    assert trial.timing.foreperiod_ms >= 500


def test_without_a_signal_there_is_no_reaction_time() -> None:
    table = Table()
    table.sit_down()
    assert table.reach().reaction_time_ms is None


def test_a_hand_that_moves_before_the_signal_has_anticipated_it() -> None:
    table = begun(go_signal=True)
    table.move(-200)
    table.wait(1400)
    table.press("space")
    trial = table.to_row()
    assert (trial.correct, trial.reaction_time_ms, trial.value) == (True, None, None)
    assert trial.timing.flags == ("anticipation",)


# --- hands and sensors -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("hand", "shape", "flagged"),
    [("right", REACH_OUT, False), ("left", MIRRORED, False), ("left", REACH_OUT, True), ("right", MIRRORED, True)],
)
def test_the_left_hand_turns_the_other_way(hand: str, shape: ReachShape, flagged: bool) -> None:
    table = Table(hand=hand)
    table.sit_down()
    trial = table.reach(shape)
    assert (trial.correct, trial.details["hand"]) == (True, hand)
    assert ("reversed" in trial.timing.flags) is flagged
    assert float(trial.details["peak_extension_rad_s"] or 0) > 1.3
    assert float(trial.details["peak_return_rad_s"] or 0) < -1.3
    assert trial.value == pytest.approx(1000, abs=20)


@pytest.mark.parametrize("name", ["clean", "noisy", "biased", "drifting", "tremor", "tilted", "lossy", "patient"])
def test_whatever_the_sensor_a_reach_is_found_and_timed(name: str) -> None:
    table = Table(sensor=name)
    table.sit_down()
    trial = table.reach()
    assert trial.correct
    assert trial.value == pytest.approx(1000, abs=60)


def test_a_reach_beyond_the_sensors_range_is_timed_but_its_peaks_are_not_known() -> None:
    table = Table(sensor="saturating")
    table.sit_down()
    trial = table.reach(FAST)
    assert trial.correct
    assert "saturated" in trial.timing.flags
    details = trial.details
    assert (details["peak_extension_rad_s"], details["peak_return_rad_s"], details["time_to_peak_ms"]) == (
        None,
        None,
        None,
    )
    assert trial.value == pytest.approx(500, abs=60)
    table.wait(300)
    table.begin()
    slower = table.reach()
    assert "saturated" not in slower.timing.flags, "what went wrong in one reach is not told of the next"
    assert slower.details["peak_extension_rad_s"] is not None


def test_a_reach_of_which_a_part_is_missing_is_done_again() -> None:
    table = begun()
    table.move(300)
    table.wait(600)
    gagged(table, 250)
    table.wait(1000)
    table.press("space")
    table.to_start()
    assert table.all(TRIAL) == []
    assert (table.last(VOIDED).reason, table.waiting.trial) == ("gap", 1)
    assert "missed a part" in table.waiting.notice
    table.wait(700)
    assert table.reach().correct
    assert table.last(TRIAL).timing.presentation == 2


def test_a_gap_while_the_hand_rests_spoils_nothing() -> None:
    table = begun()
    gagged(table, 250)
    table.wait(300)
    table.move()
    table.wait(1500)
    table.press("space")
    trial = table.to_row()
    assert trial.correct
    assert trial.value == pytest.approx(1000, abs=20)


def test_a_reach_of_which_nothing_was_measured_is_done_again() -> None:
    table = Table()
    table.sit_down()
    table.session.bus.publish(SENSOR, SensorChanged(state="attached", at=table.clock.now(), rate_hz=250.0))
    sink = table.hand._sink
    table.hand._sink = lambda sample: sink(sample) if sample.device_ms % 400 < 4 else None
    table.start()
    table.wait(1600)
    table.press("space")
    table.to_start()
    assert (table.percept.invalid, table.all(TRIAL)) == ("samples", [])
    assert "told us nothing" in table.waiting.notice


def test_a_sensor_that_is_too_slow_to_see_a_reach_says_so_and_breaks_nothing() -> None:
    table = begun(rate_hz=15.0)
    table.move(300)
    table.wait(1700)
    table.press("space")
    table.to_start()
    assert table.session.faults == []
    assert (table.percept.invalid, table.all(TRIAL)) == ("rate", [])
    assert "too slow" in table.waiting.notice


def test_a_sensor_that_comes_loose_in_a_reach_voids_it_and_old_samples_are_forgotten() -> None:
    table = begun()
    table.move(300)
    table.wait(800)
    for state in ("detached", "attached"):
        table.session.bus.publish(
            SENSOR,
            SensorChanged(state=state, at=table.clock.now(), rate_hz=250.0),  # type: ignore[arg-type]
        )
    attached = table.clock.now()
    assert (table.waiting.what, table.last(VOIDED).reason) == ("start", "sensor")
    table.wait(1000)
    trial = table.reach()
    assert trial.correct
    samples = table.samples
    window = (samples["at"] >= attached) & (samples["at"] < int(trial.details["window_to_ns"] or 0))
    assert trial.details["samples"] == pytest.approx(window.sum(), abs=3)


# --- whatever the blocks that samples come in -------------------------------------------------------------------------


def one_reach(monkeypatch: pytest.MonkeyPatch, drain_ms: float, press: bool) -> tuple[Any, Samples]:
    monkeypatch.setattr(sensor, "DRAIN", round(drain_ms * MS))
    table = begun(sensor="patient")
    table.move(300)
    table.wait(1700)
    if press:
        table.press("space")
    return table.to_row(), table.samples


@pytest.mark.parametrize("press", [True, False])
@pytest.mark.parametrize("drain_ms", [4, 30, 250])
def test_the_size_of_blocks_does_not_change_a_reach(
    monkeypatch: pytest.MonkeyPatch, drain_ms: float, press: bool
) -> None:
    usual, samples = one_reach(monkeypatch, 10, press)
    other, same_samples = one_reach(monkeypatch, drain_ms, press)
    both = min(len(samples), len(same_samples))
    assert samples[:both].tobytes() == same_samples[:both].tobytes()
    assert other.details["closed"] == usual.details["closed"]
    assert other.value == pytest.approx(usual.value, abs=3)
    assert ms(other.onset - usual.onset) == pytest.approx(0, abs=3)
    assert abs(other.details["window_to_ns"] - usual.details["window_to_ns"]) <= max(drain_ms, 10) * MS
