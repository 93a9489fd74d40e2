"""A sensor's stream through the whole program: lost samples and CPU time, with the session on the
screen.
"""

import json
import sqlite3
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from sar_tui.motion.samples import unpack
from sar_tui.store.database import FILE
from sar_tui.timing.closed_loop import LEAVE_KEYS
from sar_tui.timing.pty import Terminal

RUNS = ((250, 60.0), (1000, 300.0))
"""Sample rate (Hz) and duration (s) of each run."""
PATIENCE_S = 60.0


def measure(quick: bool, folder: Path, on_second: Callable[[], None]) -> dict[str, Any]:
    """Measure each rate, and check that every sample that was sent is in the database, in order."""
    runs = [
        _run(rate_hz, 5.0 if quick else seconds, folder / f"sensor-{rate_hz}", on_second)
        for rate_hz, seconds in RUNS
    ]
    checks = {
        f"all samples kept, {run['rate_hz']} Hz": run["lost"] == 0 and run["in_order"]
        for run in runs
    }
    return {"runs": runs, "checks": checks}


def total_seconds(quick: bool) -> int:
    """Return the total duration in s: the number of calls of ``on_second``."""
    return sum(5 if quick else round(seconds) for _, seconds in RUNS)


def _run(
    rate_hz: int, seconds: float, folder: Path, on_second: Callable[[], None]
) -> dict[str, Any]:
    folder.mkdir()
    result = folder / "result.json"
    command = [
        sys.executable,
        "-m",
        "benchmarks.sensor_app",
        str(rate_hz),
        str(seconds),
        str(folder),
        str(result),
    ]
    with Terminal(command) as terminal:
        for text in ("1044_1B", "Press Enter to go on", "Press Enter to begin"):
            terminal.wait_for(text)
            terminal.settle()
            terminal.confirm()
        terminal.wait_for("Press Space to start")
        deadline = time.monotonic() + seconds + PATIENCE_S
        ticks = 0
        began = time.monotonic()
        while not result.exists() and time.monotonic() < deadline:
            terminal.read(time.monotonic_ns() + 100_000_000)
            while ticks < min(seconds, time.monotonic() - began):
                ticks += 1
                on_second()
        terminal.settle()
        for key in LEAVE_KEYS:
            terminal.confirm(key)
        terminal.wait()
    took = json.loads(result.read_text())
    with closing(sqlite3.connect(folder / FILE)) as database:
        rows = database.execute("SELECT data FROM imu_chunks ORDER BY stream, seq").fetchall()
    stamps = np.concatenate([unpack(data)["device_ms"] for (data,) in rows])
    expected = round((took["last_ms"] - stamps[0]) * rate_hz / 1000) + 1
    own = took["cpu_share"] - took["pacing_share"]
    return {
        "rate_hz": rate_hz,
        "seconds": seconds,
        "samples": len(stamps),
        "lost": expected - len(stamps),
        "in_order": bool((np.diff(stamps) > 0).all()),
        "cpu_share": took["cpu_share"],
        "pacing_share": took["pacing_share"],
        "per_sample_us": 1e6 * own / rate_hz,
    }
