"""Time from start to end of commands that only print, compared with that of Python itself."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.turns import measure_in_turns
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE

PYTHON = "python -c pass"
COMMANDS = ("--version", "tasks", "sessions", "doctor")
PROGRAMS = (PYTHON, *COMMANDS)
_SESSIONS = 10


def measure(starts: int, folder: Path, on_start: Callable[[], None]) -> dict[str, Any]:
    """Measure the median time of each program, in turns, after one uncounted start of each."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        _record_sessions(Path(own))
        lines = {PYTHON: [sys.executable, "-c", "pass"]}
        for command in COMMANDS:
            options = [] if command.startswith("-") else ["--data", own]
            lines[command] = [sys.executable, "-m", "sar_tui", command, *options]
        measured = measure_in_turns(lines, starts, _seconds, on_start)
    medians = measured["median_s"]
    return measured | {"ratios": {name: medians[name] / medians[PYTHON] for name in COMMANDS}}


def _record_sessions(folder: Path) -> None:
    """Simulate short sessions, for `sar-tui sessions` to list."""
    catalogue = Catalogue()
    for seed in range(_SESSIONS):
        plan = make_plan(
            catalogue, "keyboard", ["BENCH"], {"attempts": 1}, seed=seed, mode="simulated"
        )
        simulate(plan, PEOPLE["average"], folder, catalogue)


def _seconds(line: list[str]) -> float:
    started = time.perf_counter()
    done = subprocess.run(
        line,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        check=False,
    )
    taken = time.perf_counter() - started
    if done.stderr:
        raise RuntimeError(f"{' '.join(line)}: {done.stderr.decode(errors='replace')}")
    return taken
