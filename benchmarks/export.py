"""Rows a second of an export as CSV, beside a bare loop over the same tables, and its peak memory."""

import csv
import json
import sqlite3
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from benchmarks.many_sessions import fill
from sar_tui.plugins import Catalogue
from sar_tui.store.database import FILE

RUNS = 3
MOST_MEMORY_RATIO = 1.25
_TABLES = ("sessions", "runs", "attempts", "trials", "actions", "notes")
"""The tables that hold most rows."""
_EXPORT = """
import json, sys, time
from sar_tui.cli import main

began = time.perf_counter()
sys.argv = ["sar-tui", "export", "--all", "--to", sys.argv[2], "--data", sys.argv[1]]
try:
    main()
except SystemExit as ended:
    assert not ended.code
memory = None
if sys.platform != "win32":
    import resource

    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform == "linux" else 2**20)
print(json.dumps([time.perf_counter() - began, memory]))
"""


def measure(few: int, many: int, folder: Path, measured: Callable[[], None]) -> dict[str, Any]:
    """Measure the export of few and of many sessions of 400 trials each."""
    sizes = []
    for count in (few, many):
        data = folder / f"export-{count}"
        fill(data, Catalogue(), count)
        runs = []
        for _ in range(RUNS):
            bare_s = _bare(data / FILE, folder / "bare")
            runs.append((*_export(data, folder / f"exported-{count}"), bare_s))
            measured()
        taken_s, memory, bare_s = (statistics.median(values) for values in zip(*runs, strict=True))
        rows = _rows(data / FILE)
        sizes.append({"sessions": count, "rows": rows, "rows_per_s": rows / taken_s, "bare_rows_per_s": rows / bare_s,
                      "ratio": taken_s / bare_s, "memory_mb": memory})  # fmt: skip
    small, large = (size["memory_mb"] for size in sizes)
    flat = f"export: memory of {many // few} times the rows at most {MOST_MEMORY_RATIO} x"
    return {"sizes": sizes, "checks": {flat: large <= MOST_MEMORY_RATIO * small}}


def steps() -> int:
    """Return the number of calls of ``measured``."""
    return 2 * RUNS


def _export(data: Path, to: Path) -> tuple[float, float]:
    """Return the seconds that the command takes, and its peak memory in MB; 0 where that is not known."""
    command = [sys.executable, "-c", _EXPORT, str(data), str(to)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    taken_s, memory = json.loads(done.stdout.splitlines()[-1])
    return float(taken_s), float(memory or 0)


def _bare(database: Path, folder: Path) -> float:
    """Return the seconds of the least that an export does: all rows of the tables through Python's csv."""
    folder.mkdir(exist_ok=True)
    began = time.perf_counter()
    with closing(sqlite3.connect(database)) as connection:
        for table in _TABLES:
            with (folder / f"{table}.csv").open("w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows(connection.execute(f"SELECT * FROM {table}"))
    return time.perf_counter() - began


def _rows(database: Path) -> int:
    with closing(sqlite3.connect(database)) as connection:
        return sum(connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in _TABLES)
