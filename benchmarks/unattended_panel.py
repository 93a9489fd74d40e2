"""An operator's panel that nobody sits at: in a terminal of its own, which is read all the time, until the input ends.

Used as ``python -m benchmarks.unattended_panel SESSION DATA``, in a process of its own so that reading the terminal
disturbs no measurement.
"""

import select
import sys
import time
from pathlib import Path

from sar_tui.framework.clock import MS
from sar_tui.timing.pty import Terminal


def panel(session: str, data: Path) -> Terminal:
    """The panel of a session, in a terminal."""
    command = [sys.executable, "-m", "sar_tui", "wizard", session, "--data", str(data), "--name", "bench"]
    return Terminal(command, columns=100, rows=30)


def main() -> None:
    """Read, and do nothing."""
    with panel(sys.argv[1], Path(sys.argv[2])) as terminal:
        while not terminal.ended and not select.select([sys.stdin], [], [], 0)[0]:
            terminal.read(time.monotonic_ns() + 50 * MS)


if __name__ == "__main__":
    main()
