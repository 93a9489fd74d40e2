"""A minimal reaction task with `os.write` and `os.read` on a terminal in raw mode. POSIX only.

No Python program can time a key in this terminal better, so sar-tui's own timing is compared with
it. Run as ``python -m sar_tui.timing.baseline FILE``; each trial is written to FILE as a line of
JSON.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

from sar_tui.model.random_streams import RandomStreams

if sys.platform != "win32":
    import termios
    import tty


class Procedure:
    """The trials of a minimal reaction task, as set on its command line, and the file that records
    them.

    Attributes:
        prompts: number of trials.
    """

    def __init__(self) -> None:
        parser = argparse.ArgumentParser()
        parser.add_argument("file", type=Path)
        parser.add_argument("--prompts", type=int, default=20)
        parser.add_argument("--seed", type=int, default=1)
        parser.add_argument("--shortest-ms", type=float, default=500)
        parser.add_argument("--longest-ms", type=float, default=1500)
        given = parser.parse_args()
        self.prompts: int = given.prompts
        self._shortest: float = given.shortest_ms / 1000
        self._longest: float = given.longest_ms / 1000
        self._seed: int = given.seed
        self._file = given.file.open("w")

    def key(self, trial: int) -> str:
        """Return the key that a trial (0, 1, …) asks for."""
        return RandomStreams(self._seed, trial).choice("fj", "order")

    def foreperiod(self, trial: int) -> float:
        """Return the foreperiod of a trial in s."""
        share = RandomStreams(self._seed, trial).uniform("foreperiod")
        return self._shortest + share * (self._longest - self._shortest)

    def record(self, trial: int, response: str, reaction_time_ms: float) -> None:
        """Write a trial to the file."""
        row = {
            "stimulus": self.key(trial),
            "response": response,
            "correct": response == self.key(trial),
        }
        self._file.write(json.dumps(row | {"reaction_time_ms": reaction_time_ms}) + "\n")
        self._file.flush()


def main() -> None:
    """Wait for Enter, and run the trials."""
    procedure = Procedure()
    before = termios.tcgetattr(0)
    tty.setraw(0)
    try:
        os.write(1, b"\x1b[2JPress Enter to begin\r\n")
        while os.read(0, 1) != b"\r":
            pass
        for trial in range(procedure.prompts):
            os.write(1, b"\x1b[2J")
            time.sleep(procedure.foreperiod(trial))
            termios.tcflush(0, termios.TCIFLUSH)
            os.write(1, f"Press: {procedure.key(trial)}\r\n".encode())
            onset = time.monotonic_ns()
            pressed = os.read(0, 16)
            response = time.monotonic_ns()
            procedure.record(trial, pressed.decode(), (response - onset) / 1e6)
    finally:
        termios.tcsetattr(0, termios.TCSADRAIN, before)


if __name__ == "__main__":
    main()
