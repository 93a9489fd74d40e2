"""What `sar-tui doctor` finds of servo motors: a controller, and whether it lets go of them by itself."""

import threading

from sar_tui.cli.doctor.check import Finding

_SERVO_S = 0.5
"""How long a controller is waited for, where a Phidget is plugged in at all."""
_NAME = "Servo controller"
_NO_SERVO = "Only a robot that moves needs one; the screen draws each gesture."


def servo_controller() -> Finding:
    """Whether there is a controller of RC servos on a USB port. None is no fault."""
    from sar_tui.drivers.phidget import describe, new_channel, plugged_in, usb_denied
    from sar_tui.outputs.servo.address import parse
    from sar_tui.outputs.servo.channel import FAILSAFE_MS, ServoChannel

    if plugged_in() is False:
        return Finding(_NAME, "ok", f"none plugged in. {_NO_SERVO}")
    if usb_denied():
        return Finding(_NAME, "care", "a Phidget is plugged in that you may not use", "See: Motion sensor.")
    address = parse("")
    told = threading.Event()
    servo = ServoChannel(address.wires[0], address, failsafe=True, changed=told.set)
    try:
        servo.open(new_channel("RCServo"))
        told.wait(_SERVO_S)
        found, attached = (f"{servo.model}, " if servo.attached else servo.trouble), servo.attached
    except Exception as error:
        return Finding(_NAME, "care", describe(error), f"See: Sensor driver. {_NO_SERVO}")
    finally:
        servo.close()
    if not attached:
        return Finding(_NAME, "ok", found or f"none plugged in, or another program uses it. {_NO_SERVO}")
    if servo.has_failsafe:
        return Finding(_NAME, "ok", f"{found}lets go of its motors {FAILSAFE_MS} ms after a program that uses it hangs")
    mend = "Should the program be killed in mid-gesture, unplug the controller's power to make its motors limp."
    return Finding(_NAME, "care", f"{found}has no failsafe", mend)
