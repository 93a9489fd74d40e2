"""Simulated trials per second, each on the disk before the next, compared with bare commits."""

import sqlite3
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE


def measure(attempts: int, folder: Path, on_attempt: Callable[[], None]) -> dict[str, Any]:
    """Measure the trials per second of a simulated session, and the ratio of a trial to a bare commit."""
    catalogue = Catalogue()
    plan = make_plan(catalogue, "keyboard", ["BENCH"], {"attempts": attempts}, seed=1, mode="simulated")
    with tempfile.TemporaryDirectory(dir=folder) as own:
        started = time.perf_counter()
        simulate(plan, PEOPLE["average"], Path(own), catalogue, lambda attempt: on_attempt())
        taken = time.perf_counter() - started
        trials = attempts * plan.task(plan.parameters).trials_per_attempt
        commit = _commit(Path(own), trials)
    return {
        "trials": trials,
        "trials_per_s": trials / taken,
        "trial_ms": 1e3 * taken / trials,
        "commit_ms": 1e3 * commit,
        "ratio": taken / trials / commit,
    }


def _commit(folder: Path, commits: int) -> float:
    """Return the seconds that SQLite takes for one synced commit of one row, with sar-tui's settings."""
    with closing(sqlite3.connect(folder / "commits.db", isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode=WAL")
        database.execute("PRAGMA synchronous=FULL")
        database.execute("CREATE TABLE rows (number INTEGER PRIMARY KEY, text TEXT)")
        started = time.perf_counter()
        for number in range(commits):
            database.execute("INSERT INTO rows VALUES (?, 'a row of some forty characters, or nearly')", (number,))
        return (time.perf_counter() - started) / commits
