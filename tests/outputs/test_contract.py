"""Given any output, when it is asked, stopped, dressed or closed, then it does what every output does.

``RIGS`` names the outputs: each a context manager that yields a `Rig` of an output that is open.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from sar_tui.framework.clock import LiveClock
from tests.needs_speech import needs_speech
from tests.outputs.contract import CHECKS, Rig
from tests.outputs.ros_fixtures import ros_rig
from tests.outputs.screen_fixtures import screen_rig
from tests.outputs.servo_fixtures import servo_rig
from tests.outputs.voice_fixtures import speech_in_real_time_rig, speech_rig, tones_rig


@contextmanager
def threaded_servo_rig() -> Iterator[Rig]:
    """The servo by the host's clock, on the thread of its own that it has in front of a person."""
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
    "servo on its thread": threaded_servo_rig,
}


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs_speech) if name.startswith("speech") else name for name in RIGS]
)
def test_the_contract_holds(name: str, check: Callable[[Rig], None]) -> None:
    with RIGS[name]() as rig:
        check(rig)
