"""Motion sensors: the driver, a sensor, and the permission to use it."""

import os
import queue
import sys
import time
from pathlib import Path

from sar_tui.cli.doctor.finding import Finding

_SENSOR_S = 0.5
"""Time to wait for a motion sensor; one that is plugged in attaches within 100 ms."""
_UDEV = tuple(
    map(
        Path,
        ("/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"),
    )
)
_NO_SENSOR = "Only tasks that measure movement need one; `--imu simulated` tries them without."


def sensor_driver() -> Finding:
    """Check that the Phidget package and its native library load."""
    from sar_tui.drivers.phidget import new_channel
    from sar_tui.inputs.phidget import NO_LIBRARY, NO_PACKAGE

    try:
        new_channel("Spatial")
        from Phidget22.Phidget import Phidget

        return Finding("Sensor driver", "ok", str(Phidget.getLibraryVersion()))
    except ImportError:
        problem = NO_PACKAGE
    except OSError as error:
        problem = NO_LIBRARY.format(error)
    found, _, advice = problem.rpartition("; ")
    return Finding("Sensor driver", "care", found, f"{_capitalized(advice)}. {_NO_SENSOR}")


def motion_sensor() -> Finding:
    """Look for a PhidgetSpatial on a USB port. It is fine if there is none."""
    from sar_tui.drivers.phidget import usb_denied
    from sar_tui.inputs.imu import Status
    from sar_tui.inputs.phidget import NO_PERMISSION, PhidgetSource

    if usb_denied():
        found, _, advice = NO_PERMISSION.partition(": ")
        return Finding("Motion sensor", "bad", found, _capitalized(advice))
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
                return Finding("Motion sensor", "ok", found)
            if status.state == "error":
                return Finding("Motion sensor", "care", status.detail, _NO_SENSOR)
    finally:
        source.stop()
    found = (
        "none plugged in, or another program uses it, such as the Phidget Control Panel. "
        f"{_NO_SENSOR}"
    )
    if sys.platform != "linux":
        return Finding("Motion sensor", "ok", f"{found} No permission is needed on this system.")
    if os.geteuid() == 0 or _has_udev_rule():
        return Finding("Motion sensor", "ok", found)
    rule = NO_PERMISSION.partition(": ")[2].partition(", unplug")[0]
    return Finding("Motion sensor", "ok", found, f"To be allowed to use one, {rule}.")


def _has_udev_rule(folders: tuple[Path, ...] = _UDEV) -> bool:
    """Return True if this system has a udev rule for Phidgets."""
    rules = (rule for folder in folders for rule in folder.glob("*.rules"))
    return any(
        "06c2" in rule.read_text(errors="replace").lower()
        for rule in rules
        if os.access(rule, os.R_OK)
    )


def _capitalized(text: str) -> str:
    return text[:1].upper() + text[1:]
