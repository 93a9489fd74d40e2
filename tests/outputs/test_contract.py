"""The contract of outputs: every output behaves alike when requested, stopped, themed or closed.

``RIGS`` names the outputs: each a context manager that yields a `Rig` of an output that is open.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from sar_tui.loop.clock import LiveClock
from tests.needs_speech import needs_speech
from tests.outputs.contract import CHECKS, Rig
from tests.outputs.ros_fixtures import ros_rig
from tests.outputs.screen_fixtures import screen_rig
from tests.outputs.servo_fixtures import servo_rig
from tests.outputs.voice_fixtures import (
    speech_in_real_time_rig,
    speech_rig,
    tones_in_real_time_rig,
    tones_rig,
)


@contextmanager
def threaded_servo_rig() -> Iterator[Rig]:
    """Provide the servo on the host's clock and on a thread of its own, as in a live session."""
    loop = asyncio.new_event_loop()
    try:
        with servo_rig(LiveClock(loop)) as rig:
            yield rig
    finally:
        loop.close()


RIGS: dict[str, Callable[[], AbstractContextManager[Rig]]] = {
    "ros": ros_rig,
    "screen": screen_rig,
    "servo": servo_rig,
    "speech": speech_rig,
    "speech in real time": speech_in_real_time_rig,
    "tones": tones_rig,
    "tones in real time": tones_in_real_time_rig,
    "servo on its thread": threaded_servo_rig,
}


IN_REAL_TIME = ("speech in real time", "tones in real time", "servo on its thread")
"""Outputs on the host's clock. They pass every check on a virtual clock, too, so `make test` tries
only two here.
"""
QUICK = (
    "each_part_ends_exactly_once_and_done_ones_began",
    "stop_of_one_that_is_under_way_leaves_the_one_that_waits",
)


def cases() -> Iterator[object]:
    for name in RIGS:
        for check in CHECKS:
            marks = [needs_speech] if name.startswith("speech") else []
            if name in IN_REAL_TIME and check.__name__ not in QUICK:
                marks.append(pytest.mark.slow)
            yield pytest.param(name, check, marks=marks, id=f"{name}-{check.__name__}")


@pytest.mark.parametrize(("name", "check"), list(cases()))
def test_the_contract_holds(name: str, check: Callable[[Rig], None]) -> None:
    with RIGS[name]() as rig:
        check(rig)
