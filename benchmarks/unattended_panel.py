"""Unattended operator's panel in a terminal of its own, which is read until the input ends.

Run it as ``python -m benchmarks.unattended_panel SESSION DATA [INVITATION]``, in a process of its
own so that reading its terminal does not disturb measurements.
"""

import select
import sys
import time
from pathlib import Path

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal


def panel(session: str, data: Path, invitation: str = "") -> Terminal:
    """Open the panel of a session in a terminal; with an invitation, of a home."""
    command = [sys.executable, "-m", "sar_tui", "wizard", session]
    if invitation:
        command += ["--link", invitation, "--data", str(data / "panel")]
    else:
        command += ["--data", str(data), "--name", "bench"]
    return Terminal(command, columns=100, rows=30)


def main() -> None:
    """Read the terminal until standard input ends."""
    session, data, *invitation = sys.argv[1:]
    with panel(session, Path(data), *invitation) as terminal:
        while not terminal.ended and not select.select([sys.stdin], [], [], 0)[0]:
            terminal.read(time.monotonic_ns() + 50 * MS)


if __name__ == "__main__":
    main()
