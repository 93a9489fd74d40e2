"""The doctor reports in one line a servo controller that is present, missing or faulty."""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.cli.doctor import servo
from sar_tui.cli.doctor.servo import servo_controller
from sar_tui.drivers import phidget
from sar_tui.loop.clock import VirtualClock
from tests.outputs.servo_fixtures import UNSUPPORTED, FakeServo


@pytest.fixture
def motor(monkeypatch: pytest.MonkeyPatch) -> FakeServo:
    """Fake motor that the doctor finds."""
    motor = FakeServo(VirtualClock())
    monkeypatch.setattr(servo, "_SERVO_S", 0.001)
    monkeypatch.setattr(phidget, "new_channel", lambda _kind: motor)
    monkeypatch.setattr(phidget, "plugged_in", lambda: None)
    monkeypatch.setattr(phidget, "usb_denied", lambda: False)
    return motor


def test_a_controller_with_a_failsafe_is_ok(motor: FakeServo) -> None:
    motor.during["open"] = motor.plug_in
    finding = servo_controller()
    assert finding.state == "ok"
    assert finding.found.startswith(
        "16x RC Servo Phidget (RCC1000_0), serial 620001, makes its motors limp 1000 ms"
    )
    assert motor.sent("setEngaged") == []
    assert motor.sent("close") == [None]


def test_a_controller_without_a_failsafe_is_reported_with_the_consequence(motor: FakeServo) -> None:
    motor.during["open"] = motor.plug_in
    motor.failing["enableFailsafe"] = UNSUPPORTED
    finding = servo_controller()
    assert finding.state == "care"
    assert "has no failsafe" in finding.found
    assert "limp" in finding.advice


def test_a_missing_controller_is_no_fault(motor: FakeServo) -> None:
    finding = servo_controller()
    assert (finding.state, finding.advice) == ("ok", "")
    assert finding.found.startswith("none plugged in, or another program uses it.")
    assert motor.sent("close") == [None]


def test_no_controller_is_waited_for_if_the_system_lists_none(
    motor: FakeServo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(phidget, "plugged_in", lambda: False)
    assert servo_controller().state == "ok"
    assert motor.calls == []


@pytest.mark.parametrize(("vendor", "found"), [("06c2", True), ("046d", False)])
def test_an_attached_controller_is_known_by_its_vendor(
    tmp_path: Path, vendor: str, found: bool
) -> None:
    assert phidget.plugged_in(tmp_path) is False
    device = tmp_path / "1-2"
    device.mkdir()
    (device / "idVendor").write_text(f"{vendor}\n")
    assert phidget.plugged_in(tmp_path) is found
    assert phidget.plugged_in(tmp_path / "none") is None


def test_missing_permission_is_reported_with_where_to_fix_it(
    motor: FakeServo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(phidget, "usb_denied", lambda: True)
    finding = servo_controller()
    assert (finding.state, finding.advice) == ("care", "See: Motion sensor.")
    assert motor.calls == []


def test_a_driver_that_does_not_load_is_reported_with_where_to_fix_it(
    motor: FakeServo, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_kind: str) -> Any:
        raise OSError("libusb-1.0.so.0: cannot open shared object file")

    monkeypatch.setattr(phidget, "new_channel", fail)
    finding = servo_controller()
    assert finding.state == "care"
    assert "libusb-1.0.so.0" in finding.found
    assert "Sensor driver" in finding.advice


def test_a_controller_in_use_by_another_program_is_reported(motor: FakeServo) -> None:
    motor.during["open"] = lambda: motor.err(2, "Channel is in use.")
    finding = servo_controller()
    assert finding.state == "ok"
    assert "Close the other program" in finding.found
