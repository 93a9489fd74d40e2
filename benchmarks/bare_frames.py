"""Frames without a framework: sleeps until each is due, and writes it. Run with the number of
prompts.
"""

import sys
import time

from benchmarks.tasks.sequence.task import DURATIONS_MS, frame_text

_WAIT_S = 0.15


def main() -> None:
    """Show each prompt after a key."""
    for number in range(int(sys.argv[1])):
        sys.stdin.read(1)
        due = time.monotonic_ns() + round(_WAIT_S * 1e9)
        for place, ms in enumerate((*DURATIONS_MS, 0)):
            time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
            sys.stdout.write(f"\x1b[H\x1b[2J{frame_text(number + 1, place)}")
            sys.stdout.flush()
            due += round(ms * 1e6)
    sys.stdin.read(1)


if __name__ == "__main__":
    main()
