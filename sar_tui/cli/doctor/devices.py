"""Checks of devices: motion sensors, servo motors, speech and sound, markers for other recorders;
and of how operators join.
"""

import os
import queue
import socket
import stat
import sys
import threading
import time
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from importlib.util import find_spec
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
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.model.language import BUNDLED

if TYPE_CHECKING:
    from sar_tui.link.authority import IssuedInvitation

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


def motion_sensor(_: Machine | None = None) -> Finding:
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
        for code, name in BUNDLED.items()
        if not any(voice.speaks(code) for voice in found.voices)
    ]
    *most, last = BUNDLED.values()
    count = f"{len(found.voices)} voice{'' if len(found.voices) == 1 else 's'}"
    if missing:
        advice = "Add such a voice in the system's speech settings, or install espeak-ng."
        return care(f"{count}, but none for {' or '.join(missing)}", advice)
    return ok(f"{count}, including {', '.join(most)} and {last}")


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

    from sar_tui.drivers.lsl import NoLibrary, clock_offset_ns, library, no_package
    from sar_tui.outputs.markers.lsl import SAME_CLOCK_NS

    if find_spec("pylsl") is None:
        return not_installed(no_package(), _MARKERS)
    try:
        pylsl = library()
    except NoLibrary as error:
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


# --- the link: operators on this machine, over the network, and in a browser


_SOON = timedelta(days=7)
"""Invitations that expire within this time are reported."""
_NO_OPERATOR = "Only sessions with an operator need it."


def operator_here(_: Machine) -> Finding:
    """Check whether an operator on this machine can join a session, by opening a socket in the
    folder.
    """
    from sar_tui.link.discovery import live_sessions, socket_path
    from sar_tui.link.errors import LinkError, need_packages

    try:
        need_packages()
    except LinkError as error:
        return not_installed(str(error), _NO_OPERATOR)
    try:
        path = socket_path(f"doctor-{os.getpid()}")
        found = live_sessions()
    except LinkError as error:
        return care(str(error), _NO_OPERATOR)
    try:
        with socket.socket(socket.AF_UNIX) as opened:
            opened.bind(str(path))
    except OSError as error:
        why = f"no socket can be opened in {path.parent}: {error.strerror}"
        return care(why, "Set XDG_RUNTIME_DIR to a folder of yours on a local disk.")
    finally:
        path.unlink(missing_ok=True)
    count = (
        "no session" if not found else "1 session" if len(found) == 1 else f"{len(found)} sessions"
    )
    return ok(f"through {path.parent}, private to you; {count} can be joined now")


def invitations(here: Machine) -> Finding:
    """Check the invitations to a data folder's sessions, their expiry, and whether its keys are
    private.
    """
    from sar_tui.link.authority import Authority
    from sar_tui.link.errors import LinkError
    from sar_tui.link.invitation import FOLDER

    folder = here.home.folder
    if not Authority.exists(folder):
        return ok("nobody is invited, so nobody can join over the network")
    try:
        issued = Authority.open(folder).invitations
    except LinkError as error:
        return bad(str(error), "Until then no session can listen on the network.")
    keys = folder / FOLDER
    if os.name == "posix" and stat.S_IMODE(keys.stat().st_mode) & 0o077:
        return care(
            f"other users can read {keys}, which holds the certificate authority",
            f"Run chmod 700 {keys}. If somebody may have read it, move it away and make all "
            "invitations again.",
        )
    return _check_expiry(issued, datetime.now(UTC))


def browser(_: Machine) -> Finding:
    """Check whether a panel can be shown in a browser."""
    from sar_tui.link.errors import LinkError, need_packages

    if find_spec("textual_serve") is None or find_spec("aiohttp") is None:
        return not_installed(pip_install_extra("serve"), "Only `sar-tui serve` needs it.")
    try:
        need_packages()
    except LinkError as error:
        return not_installed(str(error), "`sar-tui serve` needs the link.")
    return ok("`sar-tui serve` can show a panel")


def _check_expiry(issued: "tuple[IssuedInvitation, ...]", now: datetime) -> Finding:
    valid = [each for each in issued if each.state(now) == "good"]
    if not valid:
        return ok("none is valid now, so nobody can join over the network")
    found = f"{len(valid)} valid: {', '.join(str(each.guest) for each in valid)}"
    if soon := [each for each in valid if each.expires - now < _SOON]:
        ends = ", ".join(f"{each.name} on {each.expires:%Y-%m-%d}" for each in soon)
        return care(f"{found}; expiring soon: {ends}", "Invite them again under a new name.")
    return ok(found)
