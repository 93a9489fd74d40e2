"""Code that all Phidgets share: library, USB permissions, error messages."""

import ctypes
import importlib
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

UDEV_RULE = 'SUBSYSTEM=="usb", ATTRS{idVendor}=="06c2", TAG+="uaccess"'
"""Rule that lets the user of a Linux desktop use a Phidget they plug in."""
_VENDOR = "06c2"
_DEVICES = Path("/sys/bus/usb/devices")
_NODES = Path("/dev/bus/usb")
_IMPORTING = threading.Lock()
"""Held while Phidget22 is imported: its modules import each other in a circle, which fails in two
threads at once.
"""


def new_channel(kind: str) -> Any:
    """Make a channel of Phidget22, such as ``Spatial`` or ``RCServo``.

    Raises ImportError without the package, OSError without its native libraries.
    """
    if sys.platform == "linux":
        with suppress(ImportError, OSError):
            import libusb_package

            ctypes.CDLL(str(libusb_package.get_library_path()))
    with _IMPORTING:
        devices = importlib.import_module(f"Phidget22.Devices.{kind}")
        from Phidget22.Phidget import Phidget

    # Fails before there is an object, whose destructor would print a second error.
    Phidget.getLibraryVersion()
    return getattr(devices, kind)()


def plugged_in(devices: Path = _DEVICES) -> bool | None:
    """Return True if a Phidget is on a USB port; None if the system does not list USB devices (any
    except Linux).
    """
    return any(_phidgets(devices)) if devices.is_dir() else None


def usb_denied(devices: Path = _DEVICES, nodes: Path = _NODES) -> bool:
    """Return True if a Phidget is on a USB port that this user may not open. Always False except on
    Linux.

    Args:
        devices: the system's folder of USB devices.
        nodes: the folder of their device files.
    """
    for folder in _phidgets(devices):
        with suppress(OSError, ValueError):
            bus, device = (int((folder / number).read_text()) for number in ("busnum", "devnum"))
            node = nodes / f"{bus:03}" / f"{device:03}"
            if node.exists() and not os.access(node, os.R_OK | os.W_OK):
                return True
    return False


def describe(error: Exception) -> str:
    """Return the message of an exception, of Phidget22 or any other."""
    said = (str(getattr(error, part, "") or "").strip() for part in ("description", "details"))
    return ": ".join(filter(None, said)) or f"{type(error).__name__}: {error}"


def _phidgets(devices: Path) -> Iterator[Path]:
    """Yield the folders of the Phidgets on USB ports."""
    for vendor in devices.glob("*/idVendor"):
        with suppress(OSError):
            if vendor.read_text().strip() == _VENDOR:
                yield vendor.parent
