"""Servo motors: a controller, and its failsafe."""

import threading

from sar_tui.cli.doctor.finding import Finding

_SERVO_S = 0.5
"""Time to wait for a controller if a Phidget is plugged in."""
_NAME = "Servo controller"
_NO_SERVO = "Only a robot that moves needs one; the screen draws each gesture."


def servo_controller() -> Finding:
    """Look for a controller of RC servos on a USB port. It is fine if there is none."""
    from sar_tui.drivers.phidget import describe, new_channel, plugged_in, usb_denied
    from sar_tui.outputs.servo.address import parse
    from sar_tui.outputs.servo.channel import FAILSAFE_MS, ServoChannel

    if plugged_in() is False:
        return Finding(_NAME, "ok", f"none plugged in. {_NO_SERVO}")
    if usb_denied():
        return Finding(
            _NAME, "care", "a Phidget is plugged in that you may not use", "See: Motion sensor."
        )
    address = parse("")
    changed = threading.Event()
    servo = ServoChannel(address.joint_channels[0], address, failsafe=True, changed=changed.set)
    try:
        servo.open(new_channel("RCServo"))
        changed.wait(_SERVO_S)
        found, attached = (f"{servo.model}, " if servo.attached else servo.trouble), servo.attached
    except Exception as error:
        return Finding(_NAME, "care", describe(error), f"See: Sensor driver. {_NO_SERVO}")
    finally:
        servo.close()
    if not attached:
        return Finding(
            _NAME, "ok", found or f"none plugged in, or another program uses it. {_NO_SERVO}"
        )
    if servo.has_failsafe:
        return Finding(
            _NAME,
            "ok",
            f"{found}makes its motors limp {FAILSAFE_MS} ms after a program that uses it hangs",
        )
    advice = (
        "If the program is killed during a gesture, unplug the controller's power to make "
        "its motors limp."
    )
    return Finding(_NAME, "care", f"{found}has no failsafe", advice)
