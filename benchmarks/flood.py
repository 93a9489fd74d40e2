"""A megabyte that nobody types, at the home screen: how long it takes to be read, and F1 in the
middle of it.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sar_tui.timing.pty import Terminal

SIZE, PART = 1_000_000, 10_000
UNITS = {
    "escape sequences": b"\x1b[A",
    "letters": b"abcdefghij",
    "coloured text": b"\x1b[31mhello\x1b[0m",
}
LONGEST_S, LONGEST_F1_S = 5.0, 0.2
AFTER_S = 1.0
"""Time after which a key is no part of what came before it."""
_HELP = "Press Enter to close this."


def measure(folder: Path, on_flood: Callable[[], None]) -> dict[str, Any]:
    """Measure each kind of input, and check both times."""
    figures = {}
    for name, unit in UNITS.items():
        figures[name] = _flood(folder, unit * (PART // len(unit)))
        on_flood()
    checks = {
        f"a megabyte is read within {LONGEST_S:g} s": all(
            one["read_s"] <= LONGEST_S for one in figures.values()
        ),
        f"F1 answers within {LONGEST_F1_S:g} s in it": all(
            one["f1_s"] <= LONGEST_F1_S for one in figures.values()
        ),
    }
    return {"kinds": figures, "checks": checks}


def _flood(folder: Path, part: bytes) -> dict[str, float]:
    command = [sys.executable, "-m", "sar_tui", "--data", str(folder / "flood")]
    with Terminal(command) as terminal:
        terminal.wait_for("New participant")
        terminal.settle()
        began, asked, answered = time.monotonic_ns(), 0, 0
        for number in range(SIZE // PART):
            terminal.write(part)
            terminal.read(time.monotonic_ns())
            if number == SIZE // PART // 2:
                since, asked = len(terminal.output), terminal.press("f1")
                terminal.wait_for(_HELP, since=since)
                answered = terminal.read_at
        read_s = (time.monotonic_ns() - began - (answered - asked)) / 1e9
        terminal.settle()
        time.sleep(AFTER_S)
        terminal.press("ctrl+c")
        terminal.wait()
    return {"read_s": read_s, "f1_s": (answered - asked) / 1e9}
