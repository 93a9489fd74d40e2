"""Rows a second and peak memory of exports of a million trials and of an hour of sensor samples,
and how both grow.
"""

import csv
import json
import shutil
import sqlite3
import subprocess
import sys
import time
import zlib
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.many_sessions import fill
from sar_tui.motion.samples import SAMPLE, pack
from sar_tui.plugins import Catalogue
from sar_tui.store import imu, participants, sessions
from sar_tui.store.database import FILE, connect

FORMATS = ("csv", "bids", "parquet")
LARGER = 10
"""The larger data have so many times the rows of the smaller ones."""
SESSION_TRIALS = 400
MOST_MEMORY_RATIO = {"csv": 1.25, "bids": 2.0, "parquet": 1.25}
"""BIDS has some files a session: the manifest, which has all their names, grows with the
sessions.
"""
MOST_TIME_RATIO = 1.25 * LARGER
_BARE = "a bare loop"
_TABLES = ("sessions", "runs", "attempts", "trials", "actions", "notes")
"""The tables of the bare loop: those that hold most rows."""
_BLOCK = 250
_EXPORT = """
import json, sys, time
from sar_tui.cli import main

began = time.perf_counter()
_, data, to, format = sys.argv
sys.argv = ["sar-tui", "export", "--all", "--to", to, "--data", data, "--format", format]
try:
    main()
except SystemExit as ended:
    assert not ended.code
memory = None
# what getrusage tells begins with the memory of the program that started this one
if sys.platform == "linux":
    memory = int(open("/proc/self/status").read().partition("VmHWM:")[2].split()[0]) / 1024
elif sys.platform != "win32":
    import resource

    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
print(json.dumps([time.perf_counter() - began, memory]))
"""


class Kind(NamedTuple):
    """Data to export: the name of a row, their number in the larger database, and what makes a
    database of so many.
    """

    rows: str
    most: int
    make: Callable[[Path, int], None]


def measure(
    trials: int, samples: int, folder: Path, measured: Callable[[], None]
) -> dict[str, Any]:
    """Measure exports of so many trials, and of so many samples, and of a tenth of them, in each
    format.
    """
    exports = []
    for kind in (Kind("trials", trials, _store_trials), Kind("samples", samples, _store_samples)):
        sizes: dict[str, list[dict[str, Any]]] = {}
        for count in (kind.most // LARGER, kind.most):
            data = folder / "data"
            kind.make(data, count)
            for name in FORMATS:
                taken_s, memory = _export(data, folder / "exported", name)
                sizes.setdefault(name, []).append(
                    {"rows": count, "s": taken_s, "memory_mb": memory}
                )
                measured()
            if kind.rows == "trials":
                sizes.setdefault(_BARE, []).append(
                    {"rows": count, "s": _bare(data / FILE, folder), "memory_mb": 0}
                )
            shutil.rmtree(data)
        exports += [{"what": kind.rows, "as": name, "sizes": both} for name, both in sizes.items()]
    return {"exports": exports, "checks": _checks(exports)}


def _checks(exports: list[dict[str, Any]]) -> dict[str, bool]:
    found = {}
    for each in exports:
        small, large = each["sizes"]
        name = f"export of {LARGER} times the {each['what']} as {each['as']}"
        if each["as"] != _BARE:
            most = MOST_MEMORY_RATIO[each["as"]]
            found[f"{name}: memory at most {most} x"] = (
                large["memory_mb"] <= most * small["memory_mb"]
            )
            found[f"{name}: time at most {MOST_TIME_RATIO} x"] = (
                large["s"] <= MOST_TIME_RATIO * small["s"]
            )
    return found


def steps() -> int:
    """Return the number of calls of ``measured``."""
    return 2 * 2 * len(FORMATS)


def _store_trials(data: Path, count: int) -> None:
    """Store sessions with this many trials together, and with their messages."""
    fill(data, Catalogue(), count // SESSION_TRIALS)


def _store_samples(data: Path, count: int) -> None:
    """Store a session with this many samples of a sensor that measures 1,000 a second."""
    with closing(connect(data)) as database:
        participants.add(database, "BENCH")
        sessions.create(
            database, "5a3b1e", task="reaching", theme="calm", participant="BENCH", seed=1,
            parameters={}, software={}, machine={}, mode="live",
        )  # fmt: skip
        sessions.begin_run(database, "5a3b1e", software={}, machine={}, clock_ns=0)
        stream = (
            "5a3b1e",
            1,
            "A",
            1,
            "simulated",
            "model",
            "1",
            1000,
            35,
            80,
            imu.layout(),
            0,
            "hand",
        )
        database.execute(imu.INSERT_STREAM, stream)
        database.execute("BEGIN")
        database.executemany(imu.INSERT_CHUNK, map(_chunk, range(count // _BLOCK)))
        database.execute("COMMIT")


def _chunk(number: int) -> tuple[Any, ...]:
    random = np.random.default_rng(number)
    samples = np.zeros(_BLOCK, SAMPLE)
    at = np.arange(number * _BLOCK, (number + 1) * _BLOCK)
    samples["at"] = at * 1_000_000 + random.integers(0, 9999, _BLOCK)
    samples["host"] = samples["at"] + 300_000
    samples["device_ms"] = at + random.random(_BLOCK)
    for name in ("acceleration", "rate"):
        samples[name] = random.normal(0, 5, (_BLOCK, 3))
    samples["field"] = np.nan
    data = pack(samples)
    first, last = int(samples["at"][0]), int(samples["at"][-1])
    return "5a3b1e", 1, number + 1, _BLOCK, first, last, number + 1, last, zlib.crc32(data), data


def _export(data: Path, to: Path, format: str) -> tuple[float, float]:
    """Return the seconds that the command takes, and its peak memory in MB; 0 where that is not
    known.
    """
    command = [sys.executable, "-c", _EXPORT, str(data), str(to), format]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    shutil.rmtree(to)
    taken_s, memory = json.loads(done.stdout.splitlines()[-1])
    return float(taken_s), float(memory or 0)


def _bare(database: Path, folder: Path) -> float:
    """Return the seconds of the least that an export does: all rows of the tables through Python's
    csv.
    """
    began = time.perf_counter()
    with closing(sqlite3.connect(database)) as connection:
        for table in _TABLES:
            with (folder / f"{table}.csv").open("w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows(connection.execute(f"SELECT * FROM {table}"))
    return time.perf_counter() - began
