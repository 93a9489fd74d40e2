"""Programs that are measured in turns, so that a change of the machine's speed meets all of
them.
"""

from collections.abc import Callable, Mapping
from statistics import median
from typing import Any


def measure_in_turns(
    programs: Mapping[str, list[str]],
    starts: int,
    seconds_of: Callable[[list[str]], float],
    on_start: Callable[[], None],
) -> dict[str, Any]:
    """Measure each program ``starts`` times, in turns, after one uncounted start of each.

    Args:
        programs: command lines by name.
        seconds_of: starts a program, and returns what is measured, in seconds.
        on_start: called after each start.
    """
    seconds: dict[str, list[float]] = {name: [] for name in programs}
    for start in range(starts + 1):
        for name, line in programs.items():
            taken = seconds_of(line)
            if start:
                seconds[name].append(taken)
            on_start()
    return {
        "starts": starts,
        "median_s": {name: median(taken) for name, taken in seconds.items()},
        "seconds": {name: [round(value, 4) for value in taken] for name, taken in seconds.items()},
    }
