"""Frames of a prompt: how exactly each is drawn at its time, read at the other end of a
pseudo-terminal.
"""

import gc
import json
import sqlite3
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.tasks.sequence.task import DURATIONS_MS, frame_text
from sar_tui.model.units import MS
from sar_tui.timing.closed_loop import FOREPERIOD_MS, QUIET_MS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.verdict import error_statistics

TASKS = Path(__file__).parent / "tasks"
PROMPTS = 20
"""Prompts of an attempt of the task."""
REFRESH_MS = 1000 / 60
MAX_MEDIAN_MS = 1.0
MAX_P99_MS = 4.0
_READING_S = 0.06


def steps(attempts: int) -> int:
    """Return the number of prompts of a measurement."""
    return 2 * attempts * PROMPTS


def measure(attempts: int, folder: Path, on_prompt: Callable[[], None]) -> dict[str, Any]:
    """Return statistics of the errors, and the checks.

    Beside what the terminal received are the program's own stamps, the wait for a prompt after its
    foreperiod, the frames of a bare loop, and the errors of a program that shows each frame for a
    whole number of refreshes of a monitor at 60 Hz, as programs that wait for the refresh do at
    best.

    Args:
        attempts: of `PROMPTS` prompts each.
        folder: on the disk to write to.
        on_prompt: called after each prompt.
    """
    with tempfile.TemporaryDirectory(prefix="sar-tui-", dir=folder) as own:
        read = _read_prompts(Path(own), attempts, on_prompt)
        stamped, waits = _stored(Path(own))
    bare = _read_bare(attempts * PROMPTS, on_prompt)
    errors = {
        "at the terminal": _errors(read),
        "a bare loop's": _errors(bare),
        "its stamps": _errors(stamped),
        "a foreperiod": waits,
        "refreshes at 60 Hz": [round(ms / REFRESH_MS) * REFRESH_MS - ms for ms in DURATIONS_MS],
    }
    figures = {name: error_statistics(found) for name, found in errors.items()}
    seen = figures["at the terminal"]
    drift = error_statistics([(shown[-1] - shown[0]) / MS - sum(DURATIONS_MS) for shown in read])
    return {
        "programs": {name: msgspec.structs.asdict(one) for name, one in figures.items()},
        "whole_prompt_ms": msgspec.structs.asdict(drift),
        "checks": {
            f"frames: |median| ≤ {MAX_MEDIAN_MS:g} ms": abs(seen.median_ms) <= MAX_MEDIAN_MS,
            f"frames: p99 ≤ {MAX_P99_MS:g} ms": seen.p99_ms <= MAX_P99_MS,
        },
    }


def _read_prompts(data: Path, attempts: int, on_prompt: Callable[[], None]) -> list[list[int]]:
    """Run the task, and return when each frame of each prompt was read (ns)."""
    shortest, longest = FOREPERIOD_MS
    settings = {
        "attempts": attempts,
        "foreperiod_min_ms": shortest,
        "foreperiod_max_ms": longest,
        "quiet_ms": QUIET_MS,
    }
    command = [
        sys.executable,
        "-m",
        "sar_tui",
        "run",
        "sequence",
        "-p",
        "BENCH",
        "--data",
        str(data),
        "--seed",
        "1",
    ]
    command += [
        "--new",
        "--tasks",
        str(TASKS),
        *(f"--set={name}={value}" for name, value in settings.items()),
    ]
    found = []
    with Terminal(command) as terminal:
        terminal.wait_for("Enter")
        terminal.settle()
        terminal.confirm()
        gc.collect()
        gc.disable()
        try:
            for _ in range(attempts):
                terminal.settle()
                since = len(terminal.output)
                terminal.confirm()
                for trial in range(1, PROMPTS + 1):
                    shown, since = _read_frames(terminal, trial, since)
                    found.append(shown)
                    on_prompt()
        finally:
            gc.enable()
        terminal.settle()
    return found


def _read_bare(prompts: int, on_prompt: Callable[[], None]) -> list[list[int]]:
    """Run the bare loop, and return when each frame of each prompt was read (ns)."""
    found, since = [], 0
    with Terminal([sys.executable, "-m", "benchmarks.bare_frames", str(prompts)]) as terminal:
        terminal.write(b"\n")
        for number in range(1, prompts + 1):
            shown, since = _read_frames(terminal, number, since, key="enter")
            found.append(shown)
            on_prompt()
        terminal.write(b"\n")
    return found


def _read_frames(
    terminal: Terminal, trial: int, since: int, key: str = "f"
) -> tuple[list[int], int]:
    """Read the frames of a prompt and answer it; return when each came, and where the output of the
    next begins.
    """
    shown = []
    for place in range(len(DURATIONS_MS) + 1):
        since = terminal.wait_for(frame_text(trial, place), since=since)
        shown.append(terminal.read_at)
    terminal.read(terminal.read_at + round(_READING_S * 1e9))
    terminal.press(key)
    return shown, since


def _stored(data: Path) -> tuple[list[list[int]], list[float]]:
    """Return the stamps of the frames of each prompt (ns), and how long each came after its
    foreperiod (ms).
    """
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        trials = database.execute(
            "SELECT attempt, trial, timing FROM trials ORDER BY attempt, trial"
        ).fetchall()
        prompts = database.execute(
            "SELECT message->>'attempt', message->>'trial', at_ns FROM events WHERE "
            "topic='event_handler/prompt'"
        ).fetchall()
    # of a repeated prompt the last
    requested = {(attempt, trial): at for attempt, trial, at in prompts}
    stamps = {
        (attempt, trial): json.loads(timing)["frame_onsets_ns"] for attempt, trial, timing in trials
    }
    return list(stamps.values()), [
        (shown[0] - requested[key]) / MS for key, shown in stamps.items()
    ]


def _errors(prompts: Sequence[Sequence[int]]) -> list[float]:
    """Return the time from each onset to the next, minus the frame's duration (ms)."""
    return [
        (later - sooner) / MS - ms
        for shown in prompts
        for (sooner, later), ms in zip(pairwise(shown), DURATIONS_MS, strict=True)
    ]
