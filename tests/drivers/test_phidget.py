"""The code that all Phidgets share."""

import subprocess
import sys

import pytest

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
