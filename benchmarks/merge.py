"""Seconds of a merge, of a second one that finds nothing new, and peak memory, at two sizes a
factor ten apart.

The growth is that of the CPU's seconds: the disk's depend on what else it writes.
"""

import json
import shutil
import statistics
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from benchmarks.many_sessions import fill
from sar_tui.plugins import Catalogue
from sar_tui.store import sites
from sar_tui.store.database import FILE, connect

RUNS = 3
MOST_GROWTH = 15.0
"""Largest ratio of the CPU's seconds at ten times the size."""
MOST_MEMORY_RATIO = 1.25
_MERGE = """
import json, sys, time
from sar_tui.cli import main

began = time.perf_counter()
sys.argv = ["sar-tui", "merge", sys.argv[2], "--data", sys.argv[1], "--json"]
try:
    main()
except SystemExit as ended:
    assert not ended.code
memory = None
if sys.platform != "win32":
    import resource

    units_per_mb = 1024 if sys.platform == "linux" else 2**20
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / units_per_mb
print(json.dumps([time.perf_counter() - began, time.process_time(), memory]))
"""


def measure(few: int, many: int, folder: Path, measured: Callable[[], None]) -> dict[str, Any]:
    """Measure the merge of few and of many sessions of 400 trials each into a database of as many
    others.
    """
    sizes = []
    for count in (few, many):
        here, there = (
            _site(folder / f"merge-{count}-{code}", code, count, ids)
            for code, ids in (("HERE", "c0de"), ("THERE", "d0de"))
        )
        runs = []
        for number in range(RUNS):
            data = folder / f"merge-{count}-{number}"
            shutil.copytree(here, data)
            first_s, cpu_s, memory = _merge(data, there)
            again_s, *_ = _merge(data, there)
            runs.append((first_s, cpu_s, again_s, memory))
            shutil.rmtree(data)
            measured()
        first_s, cpu_s, again_s, memory = (
            statistics.median(values) for values in zip(*runs, strict=True)
        )
        sizes.append(
            {
                "sessions": count,
                "trials": 400 * count,
                "megabytes": (there / FILE).stat().st_size / 1e6,
                "merge_s": first_s,
                "cpu_s": cpu_s,
                "again_s": again_s,
                "memory_mb": memory,
            }
        )
    small, large = sizes
    factor = many / few
    return {
        "sizes": sizes,
        "checks": {
            f"merge: {factor:g} times the sessions in at most {MOST_GROWTH / 10 * factor:g} times "
            "the CPU's seconds": (large["cpu_s"] <= MOST_GROWTH / 10 * factor * small["cpu_s"]),
            f"merge: memory of {factor:g} times the sessions at most {MOST_MEMORY_RATIO} x": (
                large["memory_mb"] <= MOST_MEMORY_RATIO * small["memory_mb"]
            ),
        },
    }


def steps() -> int:
    """Return the number of calls of ``measured``."""
    return 2 * RUNS


def _site(data: Path, code: str, count: int, ids: str) -> Path:
    fill(data, Catalogue(), count, ids)
    with closing(connect(data)) as database:
        sites.set_own(database, code)
    return data


def _merge(data: Path, other: Path) -> tuple[float, float, float]:
    """Return the seconds and CPU seconds that the command takes, and its peak memory in MB; 0 if it
    is not known.
    """
    command = [sys.executable, "-c", _MERGE, str(data), str(other / FILE)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    taken_s, cpu_s, memory = json.loads(done.stdout.splitlines()[-1])
    return float(taken_s), float(cpu_s), float(memory or 0)
