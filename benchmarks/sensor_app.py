"""sar-tui's reaching task with a fake sensor: Phidget22's own channel, called back from a thread.

Run ``python -m benchmarks.sensor_app RATE_HZ SECONDS DATA_FOLDER RESULT_FILE`` in a terminal. The
seconds count from the start of an attempt.
"""

import json
import math
import sqlite3
import sys
import threading
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

from benchmarks.fake_phidget import FakeSpatial
from sar_tui.app.app import run_app
from sar_tui.drivers.phidget import new_channel
from sar_tui.inputs import sources
from sar_tui.inputs.phidget import PhidgetSource
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.store.database import FILE


def pace(rate_hz: int, seconds: float, do: Callable[[int], object], first: int = 0) -> float:
    """Call ``do`` at a rate, with numbers from ``first``, and return the CPU seconds of this
    thread.
    """
    cpu, start = time.thread_time(), time.perf_counter()
    for index in range(round(seconds * rate_hz)):
        due = start + index / rate_hz
        while (left := due - time.perf_counter()) > 0:
            time.sleep(left)
        do(first + index)
    return time.thread_time() - cpu


def _has_begun(folder: Path) -> bool:
    """Return True if an attempt has started: from then on every sample counts."""
    asked = "SELECT count(*) FROM events WHERE topic='event_handler/attempt_started'"
    with (
        suppress(sqlite3.Error),
        closing(sqlite3.connect(f"file:{folder / FILE}?mode=ro", uri=True)) as database,
    ):
        return bool(database.execute(asked).fetchone()[0])
    return False


def _drive(fake: FakeSpatial, rate_hz: int, seconds: float, folder: Path) -> dict[str, float]:
    """Attach, send samples until an attempt has started and then for ``seconds``, detach, and
    return the CPU shares.
    """

    def send(index: int) -> None:
        fake.send(index, (0.0, 0.0, 90 * math.sin(index / rate_hz)))

    time.sleep(1)
    pacing_s = min(5.0, seconds)
    pacing = pace(rate_hz, pacing_s, math.sin) / pacing_s
    fake.attach()
    sent = 0
    while not _has_begun(folder):
        pace(rate_hz, 0.2, send, sent)
        sent += round(0.2 * rate_hz)
    before = time.process_time()
    pace(rate_hz, seconds, send, sent)
    cpu = time.process_time() - before
    sent += round(seconds * rate_hz)
    fake.detach()
    return {
        "last_ms": (sent - 1) * 1000.0 / rate_hz,
        "cpu_share": cpu / seconds,
        "pacing_share": pacing,
    }


def main() -> int:
    """Run the app, and drive the sensor from a thread."""
    rate_hz, seconds, folder, result = (
        int(sys.argv[1]),
        float(sys.argv[2]),
        Path(sys.argv[3]),
        Path(sys.argv[4]),
    )
    fake = FakeSpatial(new_channel("Spatial"), 1000 // rate_hz)
    sources._SHIPPED["phidget"] = lambda text, seed, clock: PhidgetSource(
        make=lambda: fake.spatial, denied=lambda: False
    )

    def work() -> None:
        found = json.dumps(_drive(fake, rate_hz, seconds, folder))
        result.with_suffix(".part").write_text(found)
        result.with_suffix(".part").replace(result)

    threading.Thread(target=work, daemon=True).start()
    catalogue = Catalogue()
    return run_app(folder, catalogue, make_plan(catalogue, "reaching", ["BENCH"], seed=1))


if __name__ == "__main__":
    sys.exit(main())
