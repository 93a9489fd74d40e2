"""Time from start to end of commands that only print, compared with that of Python itself; and of
the import of a task's names, compared with that of msgspec.
"""

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
IMPORTS = {
    "msgspec": "import msgspec",
    "a task's names": "from sar_tui.api.task import Metric, Result, Stimulus, Task",
    "and its settings'": "from sar_tui.api.task import Metric, Result, Task, TaskParameters",
}
PROGRAMS = (PYTHON, *COMMANDS, *IMPORTS)
MOST_TIMES_MSGSPEC = 1.3
_SESSIONS = 10
_TIMED = "import time; began = time.perf_counter(); {}; print(time.perf_counter() - began)"


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
    imports = {name: [sys.executable, "-c", _TIMED.format(it)] for name, it in IMPORTS.items()}
    imported = measure_in_turns(imports, starts, _seconds_of_import, on_start)
    base, names, _ = imported["median_s"].values()
    return measured | {
        "ratios": {name: medians[name] / medians[PYTHON] for name in COMMANDS},
        "imports": imported,
        "checks": {
            f"A task's names are imported in {MOST_TIMES_MSGSPEC} times the time of msgspec": names
            <= MOST_TIMES_MSGSPEC * base
        },
    }


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


def _seconds_of_import(line: list[str]) -> float:
    done = subprocess.run(line, stdin=subprocess.DEVNULL, capture_output=True, check=True)
    return float(done.stdout)
