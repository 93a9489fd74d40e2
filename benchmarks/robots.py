"""Robots: time from a request to the first word, and from a stop until the robot has confirmed it.

The robots are servers on this computer that speak the protocols (``tests/fake_*.py``): what is
measured is this program and the protocol, without a network and a robot's own speech.
"""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from statistics import median
from typing import Any

from sar_tui.outputs.examination import STOP_LIMIT_MS, What, examine
from sar_tui.outputs.outputs import open_outputs
from sar_tui.plugins import Catalogue

_SENTENCE = "Well done, you were faster than before."
_LASTS_S = 1.0


class NotMeasured(RuntimeError):
    """A robot did not behave as expected."""


def measure(repeats: int, progress: Callable[[], None]) -> dict[str, Any]:
    """Have each robot speak and stop again and again.

    Raises:
        NotMeasured: one did not speak, or did not stop.
    """
    figures = {name: _measured(name, make, repeats, progress) for name, make in _robots().items()}
    worst = max(figure["stop_max_ms"] for figure in figures.values())
    return {
        "robots": figures,
        "checks": {
            f"Each robot confirms a stop within {STOP_LIMIT_MS:.0f} ms": worst <= STOP_LIMIT_MS
        },
    }


def names() -> int:
    """Return the number of robots."""
    return len(_robots())


def _robots() -> Mapping[str, Callable[[], AbstractContextManager[Any]]]:
    from tests.fake_furhat import furhat
    from tests.fake_reachy import reachy
    from tests.fake_rosbridge import ros_bridge

    return {
        "ros": lambda: ros_bridge("obliging", _LASTS_S),
        "ros4hri": lambda: ros_bridge("obliging", _LASTS_S),
        "furhat": lambda: furhat("obliging", _LASTS_S),
        "reachy": reachy,
    }


def _measured(
    name: str,
    make: Callable[[], AbstractContextManager[Any]],
    repeats: int,
    progress: Callable[[], None],
) -> dict[str, Any]:
    words: list[float] = []
    stops: list[float] = []
    theme = Catalogue().theme("calm")
    with make() as robot:
        address = f"{name}://{robot.host}"
        for _ in range(repeats):
            (node,) = open_outputs([address], "sound", theme)
            found = asyncio.run(
                examine(address, node.output, theme, What(say=_SENTENCE), lambda _: None)
            )
            if not (found.said and found.said.started_ms is not None):
                raise NotMeasured(f"{name} did not speak: {' '.join(found.problems)}")
            if not (found.stopped and found.stopped.took_ms is not None):
                raise NotMeasured(f"{name} did not stop: {' '.join(found.problems)}")
            words.append(found.said.started_ms)
            stops.append(found.stopped.took_ms)
            progress()
    return {
        "n": repeats,
        "first_word_ms": median(words),
        "first_word_max_ms": max(words),
        "stop_ms": median(stops),
        "stop_max_ms": max(stops),
    }
