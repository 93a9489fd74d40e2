"""The code that all Phidgets share."""

import subprocess
import sys
from pathlib import Path

import pytest

from sar_tui.drivers.phidget import usb_denied

pytest.importorskip("Phidget22.Phidget")

TWO_THREADS = """
import sys
from concurrent.futures import ThreadPoolExecutor
from sar_tui.drivers.phidget import new_channel

def make(kind):
    try:
        return type(new_channel(kind)).__name__
    except OSError:  # without the native library
        return kind

sys.setswitchinterval(1e-5)
with ThreadPoolExecutor(2) as pool:
    print(*pool.map(make, ("Spatial", "RCServo")))
"""


def test_two_threads_make_the_first_channels_at_once() -> None:
    done = subprocess.run(
        [sys.executable, "-c", TWO_THREADS], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("Spatial RCServo\n", "")


@pytest.mark.parametrize(
    ("may", "vendor", "denied"),
    [(False, "06c2", True), (True, "06c2", False), (False, "046d", False)],
)
def test_permissions_are_read_from_the_linux_device_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, may: bool, vendor: str, denied: bool
) -> None:
    device = tmp_path / "devices" / "1-2"
    device.mkdir(parents=True)
    for name, text in (("idVendor", vendor), ("busnum", "1"), ("devnum", "7")):
        (device / name).write_text(f"{text}\n")
    node = tmp_path / "bus" / "001" / "007"
    node.parent.mkdir(parents=True)
    node.touch()
    monkeypatch.setattr("os.access", lambda path, _mode: may or path != node)
    assert usb_denied(tmp_path / "devices", tmp_path / "bus") is denied
    assert not usb_denied(tmp_path / "nothing", tmp_path / "bus")
