"""Simulated trials per second, with the database on, beside the least that a trial needs."""

import json
import sqlite3
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from statistics import median
from typing import Any

from sar_tui.motion.analysis import AnalysisParameters, Window, analyse
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import imu
from sar_tui.store.database import connect, transaction
from sar_tui.store.recorder import GROUP

RUNS = 3
"""Number of sessions of each task, each with its measurement beside it; the median of the ratios is
reported.
"""
TASKS = {
    "keyboard": {"attempts": 200, "prompts_per_attempt": 100},
    "reaching": {"attempts": 50, "reaches_per_attempt": 4},
}
"""Sessions so long that what happens once in each does not count."""
BESIDE = {"keyboard": "bare inserts", "reaching": "bare analysis"}
"""The events of the same session inserted into an empty table; the windows of its samples
analysed.
"""
_BARE = """
CREATE TABLE events (
    session TEXT, seq INTEGER, run INTEGER, at_ns INTEGER, topic TEXT, message TEXT,
    PRIMARY KEY (session, seq)
)
"""


def measure(quick: bool, folder: Path, on_session: Callable[[], None]) -> dict[str, Any]:
    """Measure the trials per second of long sessions, and the ratio of a trial to what is measured
    beside it.
    """
    return {task: _task(task, quick, folder, on_session) for task in TASKS}


def total_sessions(quick: bool) -> int:
    """Return the number of sessions: the number of calls of ``on_session``."""
    return len(TASKS) * (1 if quick else RUNS)


def _task(task: str, quick: bool, folder: Path, on_session: Callable[[], None]) -> dict[str, Any]:
    settings = TASKS[task] | ({"attempts": 5} if quick else {})
    trials = settings["attempts"] * settings.get(
        "prompts_per_attempt", settings.get("reaches_per_attempt", 1)
    )
    beside = {"keyboard": _insert_events, "reaching": _analyse_reaches}[task]
    _simulate(task, settings | {"attempts": 1}, folder)  # what is loaded or compiled once
    runs = []
    for _ in range(1 if quick else RUNS):
        with tempfile.TemporaryDirectory(dir=folder) as own:
            taken_s = _simulate(task, settings, Path(own))
            runs.append((taken_s, beside(Path(own))))
        on_session()
    taken_s = median(taken for taken, _ in runs)
    return {
        "trials": trials,
        "trials_per_s": trials / taken_s,
        "trial_ms": 1e3 * taken_s / trials,
        "beside_ms": 1e3 * median(bare for _, bare in runs) / trials,
        "ratio": median(taken / bare for taken, bare in runs),
    }


def _simulate(task: str, settings: dict[str, int], folder: Path) -> float:
    """Return the seconds that a session takes."""
    catalogue = Catalogue()
    plan = make_plan(catalogue, task, ["BENCH"], settings, seed=1, mode="simulated")
    started = time.perf_counter()
    simulate(plan, PEOPLE["average"], folder, catalogue)
    return time.perf_counter() - started


def _insert_events(folder: Path) -> float:
    """Return the seconds that SQLite takes to insert a session's events into an empty table, in the
    same groups.
    """
    with closing(connect(folder)) as database:
        events = database.execute(
            "SELECT session, seq, run, at_ns, topic, message FROM events"
        ).fetchall()
    with closing(sqlite3.connect(folder / "bare.db", isolation_level=None)) as bare:
        bare.execute("PRAGMA journal_mode=WAL")
        bare.execute("PRAGMA synchronous=FULL")
        bare.execute(_BARE)
        started = time.perf_counter()
        for first in range(0, len(events), GROUP):
            with transaction(bare):
                bare.executemany(
                    "INSERT INTO events VALUES (?,?,?,?,?,?)", events[first : first + GROUP]
                )
        return time.perf_counter() - started


def _analyse_reaches(folder: Path) -> float:
    """Return the seconds that the analysis of a session's stored samples takes, a window for each
    trial.
    """
    with closing(connect(folder)) as database:
        samples = imu.samples(database, _session(database))
        windows = [
            Window(
                from_ns=details["window_from_ns"],
                started_ns=details["window_started_ns"],
                to_ns=details["window_to_ns"],
            )
            for details in (
                json.loads(row[0]) for row in database.execute("SELECT details FROM trials")
            )
            if "window_from_ns" in details
        ]
    parameters = AnalysisParameters()
    at = samples["at"]
    parts = [(samples[(at >= window.from_ns) & (at < window.to_ns)], window) for window in windows]
    started = time.perf_counter()
    for part, window in parts:
        analyse(part, window, parameters)
    return time.perf_counter() - started


def _session(database: sqlite3.Connection) -> str:
    (session,) = database.execute("SELECT id FROM sessions").fetchone()
    return str(session)
