"""Phidget22's own ``RCServo``: it behaves like the fake one, with callbacks from another thread."""

import threading
from typing import Any

import pytest

from benchmarks.fake_phidget import SERVO_LIMITS
from sar_tui.drivers.phidget import new_channel
from sar_tui.outputs.servo.servo import Servo
from tests.outputs.contract import Rig, host_clock


class FakeServo:
    """A real channel with a fake device; commands to the device are in ``calls``."""

    def __init__(self) -> None:
        self.servo = new_channel("RCServo")
        self.calls: list[tuple[str, Any]] = []
        device = {"DeviceName": "PhidgetAdvancedServo 8-Motor", "DeviceSKU": "1061_1B"}
        for name, answer in {**device, "DeviceSerialNumber": 1, **SERVO_LIMITS}.items():
            setattr(self.servo, f"get{name}", lambda answer=answer: answer)
        settings = "SpeedRampingState VelocityLimit Acceleration TargetPosition Engaged"
        for name in settings.split():
            note = lambda value, name=name: self.calls.append((name, value))  # noqa: E731
            setattr(self.servo, f"set{name}", note)
        self.servo.enableFailsafe = lambda ms: self.calls.append(("enableFailsafe", ms))
        self.servo.resetFailsafe = lambda: self.calls.append(("resetFailsafe", None))

    def attach(self) -> None:
        _elsewhere(self.servo._onAttach, None, None)

    def detach(self) -> None:
        _elsewhere(self.servo._onDetach, None, None)

    def err(self, code: int, description: bytes) -> None:
        _elsewhere(self.servo._onError, None, None, code, description)


def _elsewhere(callback: Any, *arguments: Any) -> None:
    driver = threading.Thread(target=callback, args=arguments)
    driver.start()
    driver.join()


def test_a_motor_is_set_up_moved_detached_reattached_and_released(
    capfd: pytest.CaptureFixture[str],
) -> None:
    fake = FakeServo()
    with host_clock() as clock:
        use(fake, Rig(Servo(make=lambda: fake.servo, denied=lambda: False), clock, ["gesture"]))
    assert not fake.servo.getIsOpen()
    assert capfd.readouterr().err == ""


def use(fake: FakeServo, rig: Rig) -> None:
    """Move a motor to the end, lose it, find it in use, find it again, stop it and close it."""
    rig.wait(lambda: fake.servo._onError is not None)
    fake.attach()
    rig.wait(lambda: ("enableFailsafe", 1000) in fake.calls)
    rig.ask("gesture", "whole")
    rig.wait_for("gesture", "whole")
    assert rig.states("whole", "gesture") == ["started", "done"]
    targets = [value for name, value in fake.calls if name == "TargetPosition"]
    assert len(targets) > 10
    assert (targets[0], targets[-1]) == (90, 90)
    assert 100 < max(targets) <= 117
    assert [value for name, value in fake.calls if name == "Engaged"] == [True, False]

    rig.ask("gesture", "lost")
    rig.wait_for_start("gesture", "lost")
    fake.detach()
    rig.wait_for("gesture", "lost")
    assert rig.states("lost", "gesture") == ["started", "failed"]

    fake.err(2, b"Channel in use.")
    rig.ask("gesture", "in use")
    rig.wait_for("gesture", "in use")
    assert "Close the other program" in rig.detail("in use", "gesture")

    fake.attach()
    rig.ask("gesture", "found")
    rig.wait_for_start("gesture", "found")
    rig.output.stop()
    rig.wait_for("gesture", "found")
    assert rig.states("found", "gesture") == ["started", "aborted"]
    assert next(value for name, value in reversed(fake.calls) if name == "Engaged") is False

    rig.output.close()
