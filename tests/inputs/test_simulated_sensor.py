"""Samples of a simulated sensor come in blocks of any size, and the session is the same as with 10
ms at a time.
"""

import random
from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.inputs.simulated_sensor import SimulatedSensor
from sar_tui.inputs.sources import simulated_hand
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.topics import IMU, KEY, REACH, STORED, TRIAL
from sar_tui.model.messages import ImuBlock, KeyPressed, Message, Stored
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import set_up
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.imu import StreamRows
from tests.examples import first

CATALOGUE = Catalogue()


class Presser(Node):
    """Presses keys at given times (ms)."""

    name = "presser"
    emits = (KEY,)

    def __init__(self, clock: VirtualClock, presses: dict[int, str]) -> None:
        super().__init__()
        for at_ms, key in presses.items():
            at = at_ms * MS
            clock.call_at(at, lambda at=at, key=key: self.emit(KEY, KeyPressed(key=key, at=at)))  # type: ignore[misc]


Nodes = Callable[[Any, VirtualClock], list[Node]]


def played(
    nodes: Nodes, parameters: dict[str, Any], seconds: float, divisions: list[int]
) -> list[Record]:
    """Return all messages of a session until then, with callbacks at ``divisions`` (ns) that only
    divide blocks.
    """
    kind = CATALOGUE.task("reaching")
    task = set_up(kind, kind.Parameters(**parameters))
    clock = VirtualClock()
    session = Session(task, CATALOGUE.theme("calm"), clock, 1, nodes(task, clock))
    records: list[Record] = []
    session.bus.tap(records.extend)
    session.bus.subscribe(
        TRIAL, lambda t: session.bus.publish(STORED, Stored(attempt=t.attempt, trial=t.trial))
    )
    for at in [*divisions, round(seconds * SECOND)]:
        clock.call_at(at, lambda: None)
    session.begin()
    while not session.ended and clock.step(round(seconds * SECOND)):
        pass
    session.detach()
    assert session.faults == []
    return records


def stored(records: list[Record]) -> tuple[list[tuple[int, int, str, Message]], Any]:
    """Return what is stored of messages: the events, and the rows of the sensor's samples."""
    events = [
        (seq, at, topic.name, message) for seq, at, topic, message in records if topic is not IMU
    ]
    streams, chunks, _ = StreamRows("S", 1).rows(records)
    return events, (streams, chunks)


def blocks(records: list[Record]) -> int:
    return sum(isinstance(record.message, ImuBlock) for record in records)


def divided(seed: int, number: int, seconds: float) -> list[int]:
    """Return random times (ns), some of them those at which samples are published."""
    draw = random.Random(seed)
    times = [draw.uniform(0, seconds) for _ in range(number)]
    return [
        round(time * (SECOND if number % 2 else 100)) * (1 if number % 2 else 10 * MS)
        for time in times
    ]


@pytest.mark.parametrize("seed", first(2, range(20)))
@pytest.mark.parametrize("user", sorted(PEOPLE))
def test_a_simulated_session_is_the_same_in_blocks_of_any_size(user: str, seed: int) -> None:
    person, draw, seconds = PEOPLE[user], random.Random(seed), 20.0
    presses = {draw.randrange(2000, 20_000): draw.choice(["space", "enter"]) for _ in range(5)}
    divisions = divided(seed, draw.randrange(300), seconds)
    parameters = {
        "attempts": 3,
        "go_signal": seed % 2 == 1,
        "response_timeout_ms": 20_000 if seed % 4 else 2500,
    }

    def in_steps(task: Any, clock: VirtualClock) -> list[Node]:
        source = SimulatedSource(simulated_hand(person.hand, seed), clock)
        participant = SimulatedParticipant(person, task, seed, source.move)
        return [participant, Presser(clock, presses), Imu(ImuFeed(source, clock.now))]

    def in_blocks(task: Any, clock: VirtualClock) -> list[Node]:
        sensor = SimulatedSensor(simulated_hand(person.hand, seed))
        participant = SimulatedParticipant(person, task, seed, sensor.move)
        return [participant, Presser(clock, presses), sensor]

    in_few = played(in_blocks, parameters, seconds, divisions)
    in_many = played(in_steps, parameters, seconds, [])
    assert stored(in_few) == stored(in_many)
    assert blocks(in_few) < blocks(in_many)
    assert any(record.topic is REACH for record in in_few)


def test_a_node_that_cannot_foresee_still_receives_ten_milliseconds_at_a_time() -> None:
    class Listener(Node):
        name = "listener"
        at: list[int] = []

        @on(IMU)
        def heard(self, _: ImuBlock) -> None:
            self.at.append(self.now)

    def nodes(task: Any, clock: VirtualClock) -> list[Node]:
        return [Listener(), SimulatedSensor(simulated_hand("steady", 1))]

    played(nodes, {}, 0.1, [])
    assert Listener.at == [10 * MS * n for n in range(2, 11)]
