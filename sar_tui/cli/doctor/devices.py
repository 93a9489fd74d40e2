"""Checks of devices: motion sensors, servo motors, speech and sound, markers for other recorders."""

import os
import queue
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.finding import (
    Finding,
    Machine,
    advised,
    bad,
    capitalized,
    care,
    not_installed,
    ok,
)

if TYPE_CHECKING:
    from sar_tui.outputs.sound.protocol import Examined

_SENSOR_S = 0.5
"""Time to wait for a motion sensor; one that is plugged in attaches within 100 ms."""
_UDEV = tuple(
    map(
        Path,
        ("/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"),
    )
)
_NO_SENSOR = "Only tasks that measure movement need one; `--imu simulated` tries them without."
_SERVO_S = 0.5
"""Time to wait for a controller if a Phidget is plugged in."""
_NO_SERVO = "Only a robot that moves needs one; the screen draws each gesture."
_PATIENCE_S = 2.0
"""Time to wait for the child process, which answers within half a second."""
_LANGUAGES = {"en": "English", "es": "Spanish"}
_NO_WORDS = "Without it, the agent's words are on the screen only."
_NO_SOUND = (
    "Without it nothing is heard; `--speech file:FOLDER` writes what the agent says to WAV files."
)
_MARKERS = "Only `--markers` needs it."


def sensor_driver(_: Machine) -> Finding:
    """Check that the Phidget package and its native library load."""
    from sar_tui.drivers.phidget import new_channel
    from sar_tui.inputs.phidget import NO_LIBRARY, NO_PACKAGE

    try:
        new_channel("Spatial")
        from Phidget22.Phidget import Phidget

        return ok(str(Phidget.getLibraryVersion()))
    except ImportError:
        problem = NO_PACKAGE
    except OSError as error:
        problem = NO_LIBRARY.format(error)
    return advised(f"{problem}.".rsplit("; ", 1), _NO_SENSOR)


def motion_sensor(_: Machine) -> Finding:
    """Look for a PhidgetSpatial on a USB port. It is fine if there is none."""
    from sar_tui.drivers.phidget import usb_denied
    from sar_tui.inputs.imu import Status
    from sar_tui.inputs.phidget import NO_PERMISSION, PhidgetSource

    if usb_denied():
        found, advice = NO_PERMISSION.split(": ", 1)
        return bad(found, capitalized(advice))
    statuses: queue.SimpleQueue[Status] = queue.SimpleQueue()
    source = PhidgetSource()
    source.start(lambda sample: None, statuses.put)
    try:
        until = time.monotonic() + _SENSOR_S
        while (left := until - time.monotonic()) > 0:
            try:
                status = statuses.get(timeout=left)
            except queue.Empty:
                break
            if status.state == "attached" and (info := source.info):
                found = f"{info.model}, serial {info.serial}, {info.rate_hz:g} samples a second"
                return ok(found)
            if status.state == "error":
                return care(status.detail, _NO_SENSOR)
    finally:
        source.stop()
    found = (
        "none plugged in, or another program uses it, such as the Phidget Control Panel. "
        f"{_NO_SENSOR}"
    )
    if sys.platform != "linux":
        return ok(f"{found} No permission is needed on this system.")
    if os.geteuid() == 0 or _has_udev_rule():
        return ok(found)
    rule = NO_PERMISSION.partition(": ")[2].partition(", unplug")[0]
    return ok(found, f"To be allowed to use one, {rule}.")


def _has_udev_rule(folders: tuple[Path, ...] = _UDEV) -> bool:
    """Return True if this system has a udev rule for Phidgets."""
    rules = (rule for folder in folders for rule in folder.glob("*.rules"))
    return any(
        "06c2" in rule.read_text(errors="replace").lower()
        for rule in rules
        if os.access(rule, os.R_OK)
    )


def servo_controller(_: Machine) -> Finding:
    """Look for a controller of RC servos on a USB port. It is fine if there is none."""
    from sar_tui.drivers.phidget import describe, new_channel, plugged_in, usb_denied
    from sar_tui.outputs.servo.channel import FAILSAFE_MS, ServoChannel, parse

    if plugged_in() is False:
        return ok(f"none plugged in. {_NO_SERVO}")
    if usb_denied():
        return care("a Phidget is plugged in that you may not use", "See: Motion sensor.")
    address = parse("")
    changed = threading.Event()
    servo = ServoChannel(address.joint_channels[0], address, failsafe=True, changed=changed.set)
    try:
        servo.open(new_channel("RCServo"))
        changed.wait(_SERVO_S)
        found, attached = (f"{servo.model}, " if servo.attached else servo.trouble), servo.attached
    except Exception as error:
        return care(describe(error), f"See: Sensor driver. {_NO_SERVO}")
    finally:
        servo.close()
    if not attached:
        return ok(found or f"none plugged in, or another program uses it. {_NO_SERVO}")
    if servo.has_failsafe:
        return ok(
            f"{found}makes its motors limp {FAILSAFE_MS} ms after a program that uses it hangs"
        )
    advice = (
        "If the program is killed during a gesture, unplug the controller's power to make "
        "its motors limp."
    )
    return care(f"{found}has no failsafe", advice)


def examine_voice(program: Sequence[str] = (), backends: Sequence[str] = ()) -> "Examined":
    """Ask the child process that would speak and play what it can do. Raises SoundError if it does
    not answer.
    """
    from sar_tui.outputs.sound.child import VOICE
    from sar_tui.outputs.sound.mixer import examine

    return examine(program or VOICE, backends, _PATIENCE_S)


def speech_engine(here: Machine) -> Finding:
    """Check that there is a speech engine with a voice for each language that ships."""
    found = _answer(here)
    if isinstance(found, Finding):
        return found
    if found.no_voices:
        return advised(found.no_voices.split(": ", 1), _NO_WORDS)
    missing = [
        name
        for code, name in _LANGUAGES.items()
        if not any(voice.speaks(code) for voice in found.voices)
    ]
    count = f"{len(found.voices)} voice{'' if len(found.voices) == 1 else 's'}"
    if missing:
        advice = "Add such a voice in the system's speech settings, or install espeak-ng."
        return care(f"{count}, but none for {' or '.join(missing)}", advice)
    return ok(f"{count}, including {' and '.join(_LANGUAGES.values())}")


def sound_card(here: Machine) -> Finding:
    """Check that there is a working sound card."""
    found = _answer(here)
    if isinstance(found, Finding):
        return found
    if found.no_card:
        return advised(found.no_card.rsplit(": ", 1), _NO_SOUND)
    return ok(f"there is one, by {found.card}")


def _answer(here: Machine) -> "Examined | Finding":
    """Return what the child process answered, or the finding that it did not."""
    from sar_tui.outputs.sound.protocol import SoundError

    try:
        return here.voice()
    except SoundError as error:
        return care(str(error), f"Restart the computer, and try again. {_NO_WORDS}")


def lsl_markers(_: Machine) -> Finding:
    """Check that LSL is installed, and that its clock is the session's."""
    from importlib.util import find_spec

    from sar_tui.outputs.markers.lsl import SAME_CLOCK_NS, clock_offset_ns, library, no_package
    from sar_tui.outputs.markers.marker import MarkerError

    if find_spec("pylsl") is None:
        return not_installed(no_package(), _MARKERS)
    try:
        pylsl = library()
    except MarkerError as error:
        return care(str(error), _MARKERS)
    offset_ns = clock_offset_ns(pylsl)
    found = f"LSL {pylsl.library_version() / 100:.2f}"
    if abs(offset_ns) < SAME_CLOCK_NS:
        return ok(f"{found}; its clock is the session's (differs by {offset_ns} ns)")
    return ok(f"{found}; its clock is another one, {offset_ns} ns ahead, which is added to stamps")


def serial_markers(_: Machine) -> Finding:
    """Check that serial lines can be used, and name those that there are."""
    from importlib.util import find_spec

    from sar_tui.outputs.markers.serial_line import no_package

    if find_spec("serial") is None:
        return not_installed(no_package(), _MARKERS)
    from serial.tools.list_ports import comports

    ports = sorted(port.device for port in comports())
    return ok(f"ports: {', '.join(ports)}" if ports else "installed; there is no serial port now")
