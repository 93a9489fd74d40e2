"""Checks of timing: the clock, onset stamps, the process's priority, and stored measurements."""

import os
import sys
import time
from pathlib import Path
from typing import Literal

import msgspec

from sar_tui.cli.doctor.finding import Finding

_COARSE_S = 1e-3


def clock() -> Finding:
    """Check the resolution of the clock."""
    name: Literal["perf_counter", "monotonic"] = (
        "perf_counter" if sys.platform == "win32" else "monotonic"
    )
    info = time.get_clock_info(name)
    found = f"{info.implementation}, resolution {info.resolution * 1e9:g} ns"
    if info.resolution > _COARSE_S:
        return Finding(
            "Clock",
            "bad",
            found,
            "Reaction times need a clock finer than 1 ms: use another machine.",
        )
    return Finding("Clock", "ok", found)


def onset_stamps() -> Finding:
    """Check that Textual's driver has the file that the app watches; its name is private, so it may
    change.
    """
    if sys.platform == "win32":
        has_file = False
    else:
        from textual.drivers.linux_driver import LinuxDriver

        has_file = "_file" in LinuxDriver.__init__.__code__.co_names
    if has_file:
        return Finding(
            "Onset stamps", "ok", "taken as the prompt's frame is flushed to the terminal"
        )
    return Finding(
        "Onset stamps",
        "care",
        "taken after Textual's refresh, which is less accurate; each trial is marked with it",
        "Use Linux or macOS, and the version of Textual that sar-tui was released with, for timed "
        "sessions.",
    )


def priority() -> Finding:
    """Check the scheduling priority of the process."""
    if sys.platform == "win32":
        return Finding(
            "Priority", "care", "not checked on Windows", "Start it with: start /high sar-tui"
        )
    if sys.platform == "linux" and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR):
        return Finding("Priority", "ok", "real-time scheduling")
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    if nice < 0:
        return Finding("Priority", "ok", f"raised (nice {nice})")
    how = (
        "chrt --rr 10 sar-tui, or nice -n -10 sar-tui"
        if sys.platform == "linux"
        else "nice -n -10 sar-tui"
    )
    return Finding(
        "Priority",
        "care",
        f"ordinary (nice {nice}): now and then another program may delay a key by tens of ms",
        f"Close other programs; or, if you are allowed to, start it with {how}.",
    )


def measured_timing(folder: Path) -> Finding:
    """Report the figures that ``sar-tui timing`` stored in a data folder."""
    from sar_tui.cli.timing import FILE, VERDICTS

    path = folder / FILE
    if not path.is_file():
        return Finding("Measured timing", "care", "not measured here yet", "Run `sar-tui timing`.")
    try:
        figures = msgspec.json.decode(path.read_bytes())
        found = (
            f"{figures['verdict']}: error {figures['median_ms']:.2f} ms, robust SD "
            f"{figures['robust_sd_ms']:.2f} ms, "
            f"99th percentile {figures['p99_ms']:.2f} ms, on {figures['measured_at'][:10]}"
        )
    except (msgspec.DecodeError, KeyError, TypeError, ValueError):
        return Finding(
            "Measured timing", "care", f"{path} cannot be read.", "Run `sar-tui timing` again."
        )
    if figures["verdict"] == VERDICTS[0]:
        return Finding("Measured timing", "ok", found)
    return Finding("Measured timing", "care", found, "`sar-tui timing` says why.")
