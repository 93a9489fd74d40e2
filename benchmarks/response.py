"""Recorded reaction times compared with the true ones, for a bare loop, a naive Textual app, and
sar-tui.
"""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.timing.closed_loop import BASELINE, SAR_TUI, Trial, python_program, take_turns
from sar_tui.timing.verdict import ErrorStatistics, error_statistics

NAIVE = python_program("naive Textual", "benchmarks.naive")
PROGRAMS = (BASELINE, NAIVE, SAR_TUI)
BLOCKS = 5

MAX_MEDIAN_MS = 0.5
MAX_IQR_RATIO = 1.5


def measure(trials: int, folder: Path, on_press: Callable[[str], None]) -> dict[str, Any]:
    """Return statistics by program, sar-tui's own timing quality, the checks, and every error.

    Args:
        trials: number of trials of each program.
        folder: a folder on the disk to write to.
        on_press: called with a program's name after each press.
    """
    measured = take_turns(PROGRAMS, trials, BLOCKS, folder, on_press)
    errors = {name: [trial.error_ms for trial in done] for name, done in measured.items()}
    figures = {name: error_statistics(of_program) for name, of_program in errors.items()}
    return {
        "programs": {
            name: msgspec.structs.asdict(of_program) for name, of_program in figures.items()
        },
        "quality": _quality(measured[SAR_TUI.name]),
        "checks": _checks(figures[SAR_TUI.name], figures[BASELINE.name]),
        "errors_ms": {
            name: [round(error, 4) for error in of_program] for name, of_program in errors.items()
        },
    }


def _quality(trials: list[Trial]) -> dict[str, Any]:
    """Summarise the timing quality that sar-tui stored: onset sources, delays of handlers and loop,
    flags.
    """
    kept = [trial.timing for trial in trials]
    late = {
        f"{name}_median": error_statistics([timing[name] for timing in kept]).median_ms
        for name in ("handler_delay_ms", "loop_lag_ms")
    }
    return {
        "onset_sources": Counter(timing["onset_source"] for timing in kept),
        "flags": Counter(flag for timing in kept for flag in timing["flags"]),
        "handler_delay_ms_max": max(timing["handler_delay_ms"] for timing in kept),
        "loop_lag_ms_max": max(timing["loop_lag_ms"] for timing in kept),
        **late,
    }


def _checks(own: ErrorStatistics, baseline: ErrorStatistics) -> dict[str, bool]:
    return {
        f"|median| ≤ {MAX_MEDIAN_MS} ms": abs(own.median_ms) <= MAX_MEDIAN_MS,
        f"IQR ≤ {MAX_IQR_RATIO} × bare loop": own.iqr_ms <= MAX_IQR_RATIO * baseline.iqr_ms,
    }
