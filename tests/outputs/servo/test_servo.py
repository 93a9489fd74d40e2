"""Gestures by servo motors that are present, missing, pulled out or faulty."""

import threading
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.clock import LiveClock, VirtualClock
from sar_tui.model.gesture import JOINTS, REST, Gesture, Keyframe, Pose
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.servo import servo as servo_module
from sar_tui.outputs.servo.channel import JointChannel, ServoAddress, parse
from sar_tui.outputs.servo.servo import STEP_MS, Motion, Servo, StepTimer
from tests.drivers.fake_phidget import PhidgetError
from tests.model.test_gesture import gestures, poses
from tests.outputs.contract import THEME, Rig, host_clock
from tests.outputs.servo_fixtures import NOT_ATTACHED, UNSUPPORTED, ServoBench

BOTH = "?right_arm=0&nod=-5"
IO_ERROR = PhidgetError(5, "Input/Output Error")


@pytest.fixture
def bench() -> Iterator[ServoBench]:
    bench = ServoBench()
    yield bench
    bench.servo.close()


@pytest.fixture
def live_clock() -> Iterator[LiveClock]:
    with host_clock() as clock:
        yield clock


def make(bench: ServoBench, gesture: str = "wave", action: str = "a") -> str:
    """Perform a gesture to its end, if it is not under way; return its last state."""
    if (action, "gesture") not in bench.rig.asked:
        bench.rig.ask("gesture", action, gesture)
    return over(bench, action)[-1]


def over(bench: ServoBench, action: str = "a") -> list[str]:
    """Wait until a gesture is over, and return its states."""
    bench.rig.wait_for("gesture", action)
    return bench.rig.states(action, "gesture")


def why(bench: ServoBench, action: str = "a") -> str:
    return bench.rig.detail(action, "gesture")


def two_arms() -> ServoBench:
    """Two motors, both of which take part in a wave."""
    bench = ServoBench("?right_arm=0&left_arm=1")
    both = Gesture((Keyframe(at_ms=500, right_arm=1, left_arm=1), Keyframe(at_ms=900)))
    bench.servo.apply_theme(_with(wave=both))
    return bench


def begin(bench: ServoBench, action: str = "a") -> None:
    bench.rig.ask("gesture", action, "wave")
    bench.rig.wait(lambda: bench.channels[0].facts["Engaged"])
    bench.rig.clock.advance(100 * MS)


# --- a motor that is there


def test_a_motor_is_prepared_when_it_is_attached_and_stays_limp(bench: ServoBench) -> None:
    [motor] = bench.channels
    assert motor.facts == motor.facts | {
        **{"VelocityLimit": 180, "Acceleration": 1000, "SpeedRampingState": True},
        **{"TargetPosition": 90, "IsLocal": True, "IsRemote": False, "Channel": 0},
    }
    assert motor.sent("setEngaged") == []
    assert motor.sent("setDeviceSerialNumber") == []
    assert ServoBench("620002").channels[0].facts["DeviceSerialNumber"] == 620_002


def test_a_gesture_goes_from_the_middle_through_its_keyframes_and_back_in_fifty_steps_a_second(
    bench: ServoBench,
) -> None:
    assert make(bench) == "done"
    moments, degrees = zip(*bench.channels[0].targets, strict=True)
    assert (degrees[0], max(degrees), degrees[-1]) == (90, pytest.approx(90 + 0.6 * 45), 90)
    assert max(later - earlier for earlier, later in pairwise(moments)) <= 140
    assert 25 <= len(moments) <= 32
    calls = bench.channels[0].calls
    (began, _, on), (ended, _, off) = (call for call in calls if call[1] == "setEngaged")
    assert (on, off) == ((True,), (False,)), "it is limp before and after"
    assert ended - began == pytest.approx(700 * MS, abs=20 * MS)
    assert bench.rig.reports[-1].at == ended
    assert bench.channels[0].sent("enableFailsafe") == [], "the clock is virtual"
    assert not bench.rig.clock.step(), "no timer remains"


def test_only_the_joints_that_take_part_are_engaged_and_a_reversed_one_moves_the_other_way() -> (
    None
):
    bench = ServoBench(BOTH)
    assert make(bench, "nod") == "done"
    arm, head = sorted(bench.channels, key=lambda motor: motor.facts["Channel"])
    assert head.facts["Channel"] == 5
    assert arm.sent("setEngaged") == []
    assert head.sent("setEngaged") == [True, False]
    degrees = [target for _, target in head.targets]
    assert (min(degrees), max(degrees)) == (pytest.approx(90 - 0.4 * 45), 90)


def test_a_gesture_that_asks_for_too_much_speed_is_slowed_and_ends_when_it_is_at_rest() -> None:
    bench = ServoBench("?right_arm=0&speed=30&range=60")
    hasty = Gesture(
        (Keyframe(at_ms=100, right_arm=1), Keyframe(at_ms=500, right_arm=1), Keyframe(at_ms=600))
    )
    bench.servo.apply_theme(_with(hasty=hasty))
    assert bench.channels[0].facts["VelocityLimit"] == 30
    assert make(bench, "hasty") == "done"
    targets = bench.channels[0].targets
    assert targets[-1][1] == 90
    assert targets[-1][0] - targets[0][0] == pytest.approx(1050, abs=120)


def test_a_motor_with_a_small_range_stays_within_it() -> None:
    bench = ServoBench("?right_arm=0&range=90", plug=False)
    [motor] = bench.channels
    motor.facts.update(MinPosition=120.0, MaxPosition=100.0, MaxVelocityLimit=50.0)
    motor.plug_in()
    assert (motor.facts["TargetPosition"], motor.facts["VelocityLimit"]) == (110, 50)
    make(bench)
    assert max(target for _, target in motor.targets) == pytest.approx(116, abs=0.5)


def test_a_controller_without_limits_is_used_anyway_unless_no_joint_takes_part() -> None:
    bench = ServoBench(plug=False)
    for name in ("setSpeedRampingState", "setVelocityLimit", "setAcceleration"):
        bench.failing[name] = UNSUPPORTED
    bench.channels[0].plug_in()
    assert make(bench, "nod") == "done"
    assert over(bench) == ["started", "done"]
    assert "none of the joints" in why(bench)
    assert bench.channels[0].sent("setEngaged") == []
    assert make(bench, action="b") == "done"
    assert bench.channels[0].sent("setEngaged") == [True, False]


# --- stop


def test_stop_makes_every_motor_limp_before_any_time_has_passed_as_does_the_loss_of_one() -> None:
    bench = two_arms()
    begin(bench)
    asked = bench.rig.clock.now()
    bench.servo.stop()
    over(bench)
    for motor in bench.channels:
        assert motor.calls[-1] == (asked, "setEngaged", (False,))
    assert bench.rig.reports[-1][1:4] == ("gesture", "aborted", asked)

    begin(bench, "b")
    left, right = bench.channels
    left.failing = {}
    left.pull_out()
    over(bench, "b")
    assert right.facts["Engaged"] is False
    assert "left_arm" in why(bench, "b")


def test_after_a_stop_the_next_gesture_begins_where_the_motor_was_left_and_brings_it_to_rest(
    bench: ServoBench,
) -> None:
    begin(bench)
    bench.servo.stop()
    left = bench.channels[0].targets[-1][1]
    assert left > 95
    assert make(bench, "nod", "b") == "done"
    degrees = [target for _, target in bench.channels[0].targets]
    after = degrees[degrees.index(left) :]
    assert max(after) <= left
    assert after[-1] == 90


def test_a_motor_that_cannot_be_made_limp_is_reported_and_the_others_are() -> None:
    bench = two_arms()
    begin(bench)
    first, second = bench.channels
    first.failing = {"setEngaged": IO_ERROR}
    bench.servo.stop()
    over(bench)
    assert second.facts["Engaged"] is False
    assert (first.sent("close"), second.sent("close")) == ([None], [])
    assert over(bench) == ["started", "failed"]
    place = bench.servo._channels[0].place
    assert f"The servo for {place} could not be made limp (Input/Output Error)" in why(bench)
    assert why(bench).endswith("its channel was closed: unplug it.")


def test_a_motor_that_refuses_to_be_made_limp_is_reported_again(bench: ServoBench) -> None:
    begin(bench)
    [motor] = bench.channels
    motor.failing["setEngaged"] = PhidgetError(3, "Timed Out")
    tried: list[str] = []

    def fail_once_more() -> None:
        tried.append("first")
        motor.during["setEngaged"] = motor.failing.clear

    motor.during["setEngaged"] = fail_once_more
    bench.servo.stop()
    over(bench)
    assert tried == ["first"]
    assert motor.facts["Engaged"] is False
    assert motor.sent("close") == []
    assert (over(bench), why(bench)) == (["started", "aborted"], "")


@pytest.mark.parametrize("closes", [True, False])
def test_a_motor_that_cannot_be_made_limp_is_not_fed_any_more_until_it_is_to_move_again(
    live_clock: LiveClock, closes: bool
) -> None:
    bench = ServoBench(clock=live_clock)
    [motor] = bench.channels
    bench.rig.ask("gesture", "a", "wave")
    bench.rig.wait(lambda: motor.facts["Engaged"])
    motor.failing["setEngaged"] = IO_ERROR
    if not closes:
        motor.failing["close"] = IO_ERROR
    bench.servo.stop()
    over(bench)
    closed = "was closed" if closes else "could not be closed"
    assert f"its channel {closed}" in why(bench)
    assert why(bench).endswith("unplug it. Its failsafe releases it within some seconds.")
    fed = len(motor.sent("resetFailsafe"))
    bench.servo._channels[0].feed(live_clock.now() + 60 * SECOND)
    assert len(motor.sent("resetFailsafe")) == fed
    motor.failing.clear()
    motor.during["open"] = motor.plug_in
    bench.rig.ask("gesture", "b", "wave")
    assert over(bench, "b") == ["started", "done"]
    bench.servo.close()


def test_close_makes_the_motor_limp_ends_what_was_asked_for_and_closes_the_channel(
    bench: ServoBench,
) -> None:
    begin(bench)
    bench.rig.ask("gesture", "b")
    bench.servo.close()
    assert [call[1] for call in bench.channels[0].calls][-1] == "close"
    assert bench.channels[0].facts["Engaged"] is False
    assert over(bench) == ["started", "aborted"]
    assert over(bench, "b") == ["aborted"]
    assert set(bench.channels[0].handlers.values()) == {None}


def test_stop_and_close_return_while_a_call_to_the_device_hangs(
    monkeypatch: pytest.MonkeyPatch, live_clock: LiveClock
) -> None:
    monkeypatch.setattr(servo_module, "_CLOSE_S", 0.01)
    bench = ServoBench(clock=live_clock)
    free, hangs = threading.Event(), threading.Event()

    def hang() -> None:
        hangs.set()
        free.wait()

    bench.channels[0].during["setEngaged"] = hang
    bench.rig.ask("gesture", "a")
    bench.rig.wait(hangs.is_set)
    bench.servo.stop()
    bench.servo.close()
    assert bench.rig.reports == []
    free.set()
    bench.rig.wait(lambda: "servo" not in [thread.name for thread in threading.enumerate()])
    assert bench.rig.reports == []
    assert bench.channels[0].facts["Engaged"] is False
    assert bench.channels[0].sent("close") == [None]


# --- a motor that is lost


def test_a_motor_that_is_pulled_out_in_mid_gesture_fails_it_and_works_again_when_it_is_plugged_in(
    bench: ServoBench,
) -> None:
    begin(bench)
    bench.channels[0].pull_out()
    assert over(bench) == ["started", "failed"]
    assert "right_arm on channel 0 was lost while it moved. It was unplugged" in why(bench)
    assert make(bench, action="b") == "failed"
    assert "plug in its controller" in why(bench, "b")
    bench.channels[0].put_back()
    before = len(bench.channels[0].targets)
    assert make(bench, action="c") == "done"
    anew = [target for _, target in bench.channels[0].targets[before:]]
    assert (anew[0], anew[-1]) == (90, 90)


def test_a_motor_that_is_lost_before_its_detachment_is_reported_fails_the_gesture_and_is_limp(
    bench: ServoBench,
) -> None:
    begin(bench)
    bench.failing["setTargetPosition"] = bench.failing["setEngaged"] = NOT_ATTACHED
    assert over(bench) == ["started", "failed"]
    assert "lost while it moved" in why(bench)
    for code in (52, 59):
        other = ServoBench()
        begin(other)
        other.failing["setEngaged"] = PhidgetError(code, "Gone")
        other.servo.stop()
        assert over(other) == ["started", "aborted"]


@pytest.mark.parametrize("name", ["setEngaged", "setTargetPosition"])
def test_a_motor_that_refuses_fails_the_gesture_in_its_words(bench: ServoBench, name: str) -> None:
    bench.failing[name] = IO_ERROR
    assert make(bench) == "failed"
    assert "Input/Output Error" in why(bench)
    bench.failing.clear()
    bench.channels[0].during["open"] = bench.channels[0].plug_in
    assert make(bench, action="b") == "done"


def test_an_error_of_the_controller_is_reported_with_each_gesture_until_it_is_over(
    bench: ServoBench,
) -> None:
    bench.channels[0].err(4104, "No external power.")
    make(bench)
    assert why(bench) == "It reports: No external power."
    begin(bench, "b")
    bench.channels[0].pull_out()
    over(bench, "b")
    assert why(bench, "b").endswith("It was unplugged: plug it in again."), "not for that error"
    bench.channels[0].put_back()
    bench.channels[0].err(4096, "All is well.")
    make(bench, action="c")
    assert why(bench, "c") == ""


# --- no motor


def test_without_a_controller_a_gesture_fails_with_what_to_do_after_a_second_and_then_at_once() -> (
    None
):
    bench = ServoBench(plug=False)
    assert make(bench) == "failed"
    assert bench.rig.clock.now() == SECOND
    assert "right_arm on channel 0: plug in its controller" in why(bench)
    assert make(bench, action="b") == "failed"
    assert bench.rig.clock.now() == SECOND
    assert over(bench, "b") == ["failed"]


@pytest.mark.parametrize("opened", ["first", "again"])
def test_a_gesture_waits_for_a_motor_that_is_being_opened(opened: str) -> None:
    bench = ServoBench(plug=opened == "again")
    [motor] = bench.channels
    if opened == "again":
        bench.rig.clock.advance(5 * SECOND)
        motor.err(4108, "Failsafe condition detected.")
    bench.rig.ask("gesture", "a")
    bench.rig.clock.advance(300 * MS)
    motor.plug_in()
    assert over(bench) == ["started", "done"]


@pytest.mark.parametrize(
    ("reason", "says"),
    [
        ("in use", "Close the other program"),
        ("not set up", "cannot be set up: Input/Output Error"),
        ("denied", "/etc/udev/rules.d/70-phidget.rules"),
        ("not opened again", "cannot be opened again: Input/Output Error"),
    ],
)
def test_a_controller_that_cannot_be_used_is_reported_with_what_to_do(
    reason: str, says: str
) -> None:
    bench = ServoBench(plug=reason == "not opened again", denied=reason == "denied")
    if reason == "in use":
        bench.channels[0].err(2, "Channel is in use.")
    elif reason == "not set up":
        bench.failing["setTargetPosition"] = IO_ERROR
        bench.channels[0].plug_in()
    elif reason == "not opened again":
        bench.failing["open"] = IO_ERROR
        bench.channels[0].err(4108, "Failsafe condition detected.")
    assert make(bench) == "failed"
    assert says in why(bench)


@pytest.mark.parametrize(
    ("error", "cure"),
    [
        (ModuleNotFoundError("No module named 'Phidget22'"), "pip install phidget22"),
        (OSError("libusb-1.0.so.0: cannot open shared object file"), "libusb-package"),
        (PhidgetError(28, "Unexpected Error"), "The servo cannot be opened: Unexpected Error"),
    ],
)
def test_a_driver_that_is_missing_fails_gestures_at_once_with_how_to_get_it(
    error: Exception, cure: str
) -> None:
    def fail() -> Any:
        raise error

    rig = Rig(Servo(make=fail, denied=lambda: False), VirtualClock(), ["gesture"])
    rig.ask("gesture", "a")
    rig.wait_for("gesture", "a")
    assert rig.clock.now() == 0
    assert cure in rig.detail("a", "gesture")
    rig.output.close()


# --- the failsafe


@pytest.mark.parametrize(("least_ms", "set_ms"), [(500, 1000), (2000, 2000)])
def test_the_failsafe_is_fed_three_times_as_often_as_it_needs_also_while_nothing_is_under_way(
    live_clock: LiveClock, least_ms: int, set_ms: int
) -> None:
    bench = ServoBench(plug=False, clock=live_clock)
    [motor] = bench.channels
    motor.facts["MinFailsafeTime"] = least_ms
    bench.rig.wait(lambda: "Error" in motor.handlers)
    motor.plug_in()
    bench.rig.wait(lambda: len(motor.sent("resetFailsafe")) >= 3)
    bench.servo.close()
    assert motor.sent("enableFailsafe") == [set_ms]
    fed = [at for at, name, _ in motor.calls if name == "resetFailsafe"]
    assert min(later - earlier for earlier, later in pairwise(fed)) >= 249 * MS
    assert motor.sent("setEngaged") == []


@pytest.mark.parametrize("trip", ["event", "refusal"])
def test_a_motor_released_by_its_failsafe_is_reopened_and_works_again(
    bench: ServoBench, trip: str
) -> None:
    begin(bench)
    [motor] = bench.channels
    motor.during["open"] = lambda: (motor.failing.clear(), motor.plug_in())
    if trip == "event":
        motor.err(4108, "Failsafe condition detected.")
    else:
        motor.failing["setTargetPosition"] = PhidgetError(59, "Failsafe Triggered")
    assert over(bench) == ["started", "failed"]
    assert "failsafe released it" in why(bench)
    assert make(bench, action="b") == "done"
    assert [name for _, name, _ in motor.calls].count("open") == 2


def _with(**gestures: Gesture) -> Theme:
    return msgspec.structs.replace(THEME, gestures={**THEME.gestures, **gestures})


# --- an address


@pytest.mark.parametrize(
    ("text", "serial", "joints", "range_deg", "speed"),
    [
        ("", None, "right_arm 0", 45, 180),
        ("620001", 620_001, "right_arm 0", 45, 180),
        ("?speed=90&range=30.5", None, "right_arm 0", 30.5, 90),
        ("620001?right_arm=3&nod=0&left_arm=-2", 620_001, "nod 0,left_arm -2,right_arm 3", 45, 180),
        ("?turn=-0&lean=15", None, "turn -0,lean 15", 45, 180),
    ],
)
def test_an_address_says_which_controller_which_joints_and_how_far_and_fast(
    text: str, serial: int | None, joints: str, range_deg: float, speed: float
) -> None:
    wired = (joint.split() for joint in joints.split(","))
    channels = tuple(JointChannel(name, abs(int(at)), at.startswith("-")) for name, at in wired)
    assert parse(text) == ServoAddress(serial, channels, range_deg, speed)


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        ("left", '"left" is not a serial number'),
        ("-1 ١٢٣ //robot:5661", "not a serial number"),
        ("?tail=0", "tail"),
        ("?nod=first ?nod= ?nod=٣ ?nod=100", "nod"),
        ("?nod", "bad query field"),
        ("?nod=0&nod=1", "twice"),
        ("?nod=1&turn=-1", "same channel"),
        ("?range=4 ?range=91 ?range=nan", "range"),
        ("?speed=361 ?speed=fast", "speed"),
    ],
)
def test_an_invalid_address_is_refused_with_the_reason_and_the_allowed_forms(
    texts: str, why: str
) -> None:
    for text in texts.split():
        with pytest.raises(OutputError) as refused:
            parse(text)
        assert why in str(refused.value), text
        assert "servo:SERIAL?right_arm=0" in str(refused.value), text


# --- motion through a gesture


@given(gestures(), poses, st.floats(0.3, 72), st.lists(st.integers(1, 400), max_size=30))
def test_it_is_never_faster_than_it_may_be_stays_in_range_and_comes_to_rest(
    gesture: Gesture, start: Pose, speed: float, pauses: list[int]
) -> None:
    motion = Motion(gesture, start, speed)
    ms, last = 0, start
    pauses = [*pauses]
    latest = gesture.duration_ms + sum(pauses) + 2 * 1000 / speed + 2 * STEP_MS
    while not motion.over:
        pause = pauses.pop() if pauses else STEP_MS
        ms += pause
        pose = motion.step(ms)
        for joint in JOINTS:
            most = speed * min(pause, 2 * STEP_MS) / 1000
            assert abs(getattr(pose, joint) - getattr(last, joint)) <= most + 1e-9
            assert -1 <= getattr(pose, joint) <= 1
        last = pose
        assert ms <= latest
    assert motion.pose == REST


def test_a_gesture_that_is_slow_enough_is_followed_exactly_to_its_end() -> None:
    gesture = Gesture((Keyframe(at_ms=200), Keyframe(at_ms=1000, nod=1), Keyframe(at_ms=2000)))
    motion = Motion(gesture, REST, speed=4)
    for ms in range(STEP_MS, 2001, STEP_MS):
        assert not motion.over, "nor before it has moved"
        assert motion.step(ms) == gesture.pose_at(ms)
    assert motion.over


def test_the_joints_it_moves_are_those_of_its_keyframes_and_those_that_are_not_at_rest() -> None:
    gesture = Gesture((Keyframe(at_ms=100, nod=1), Keyframe(at_ms=200)))
    assert Motion(gesture, REST, 4).joints == {"nod"}
    assert Motion(gesture, Pose(left_arm=0.2), 4).joints == {"nod", "left_arm"}


# --- its steps


def test_steps_come_at_their_time_and_at_once_when_woken() -> None:
    clock = VirtualClock()
    steps: list[int] = []

    def step() -> int | None:
        steps.append(clock.now() // MS)
        return 20 * MS if len(steps) < 4 else None

    pace = StepTimer(clock, step, lambda: None)
    pace.start()
    clock.advance(25 * MS)
    pace.wake()
    clock.advance(1000 * MS)
    assert steps == [0, 20, 25, 45]


def test_once_finished_there_is_one_last_call_and_no_step_whoever_wakes_it() -> None:
    clock = VirtualClock()
    called: list[str] = []
    pace = StepTimer(clock, lambda: called.append("step"), lambda: called.append("last"))
    pace.start()
    clock.advance(MS)
    for _ in range(2):
        pace.finish(1)
    pace.wake()
    clock.advance(MS)
    assert called == ["step", "last"]
