"""Unattended operator's panel in a terminal of its own, which is read until the input ends.

Run it as ``python -m benchmarks.unattended_panel SESSION DATA``, in a process of its own so that
reading its terminal does not disturb measurements.
"""

import select
import sys
import time
from pathlib import Path

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal


def panel(session: str, data: Path) -> Terminal:
    """Open the panel of a session in a terminal."""
    command = [
        sys.executable,
        "-m",
        "sar_tui",
        "wizard",
        session,
        "--data",
        str(data),
        "--name",
        "bench",
    ]
    return Terminal(command, columns=100, rows=30)


def main() -> None:
    """Read the terminal until standard input ends."""
    with panel(sys.argv[1], Path(sys.argv[2])) as terminal:
        while not terminal.ended and not select.select([sys.stdin], [], [], 0)[0]:
            terminal.read(time.monotonic_ns() + 50 * MS)


if __name__ == "__main__":
    main()
