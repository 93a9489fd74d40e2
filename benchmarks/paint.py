"""Time from start to first paint: sar-tui's home screen compared with a minimal Textual app."""

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.turns import measure_in_turns
from sar_tui.timing.pty import Terminal, visible

_PATIENCE = 20_000_000_000


def first_paint(command: list[str]) -> float:
    """Return the seconds from the start of a program to its first visible output.

    Raises:
        TimeoutError: there is none.
    """
    with Terminal(command) as terminal:
        while not visible(bytes(terminal.output)):
            if not terminal.read(terminal.started_at + _PATIENCE):
                raise TimeoutError(f"{command} shows nothing.")
        painted = (terminal.read_at - terminal.started_at) / 1e9
        terminal.settle(seconds=2)
        terminal.press("ctrl+q")
        terminal.wait()
    return painted


def measure(starts: int, folder: Path, on_start: Callable[[], None]) -> dict[str, Any]:
    """Measure the median time of both programs, in turns, after one uncounted start of each."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        commands = {
            "empty Textual": [sys.executable, "-m", "benchmarks.empty"],
            "sar-tui": [sys.executable, "-m", "sar_tui", "--data", own],
        }
        measured = measure_in_turns(commands, starts, first_paint, on_start)
    medians = measured["median_s"]
    return measured | {"ratio": medians["sar-tui"] / medians["empty Textual"]}
