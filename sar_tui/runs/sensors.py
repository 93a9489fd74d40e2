"""Motion sensors of a session: opens and checks them, and makes their nodes. Imports numpy: import it late."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sar_tui.framework.clock import Clock, VirtualClock
from sar_tui.framework.declaration import ParameterError
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.task import Task
from sar_tui.inputs.imu import ImuSource, SourceError
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.recorded import RecordedSource
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated_sensor import SimulatedSensor
from sar_tui.inputs.sources import open_source, simulated_hand, source_names
from sar_tui.simulation.participant import SimulatedMover, SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect

_EXCLUSIVE = ("phidget", "ros")
"""Kinds of sensors that two seats cannot share."""


def open_sensors(task: type[Task], parameters: TaskParameters, seed: int, clock: Clock, folder: Path) -> list[ImuFeed]:
    """Open the sensor of each seat that has one, in the order of the seats; none is started yet.

    Raises:
        ParameterError: as ``open_sensor``, or two seats name the same device.
        StoreError: as ``open_sensor``.
    """
    seats = task.sensor_seats(parameters)
    _check_distinct(parameters, seats)
    return [open_sensor(parameters, seed + number, clock, folder, seat) for number, seat in enumerate(seats)]


def open_sensor(parameters: TaskParameters, seed: int, clock: Clock, folder: Path, seat: str = "A") -> ImuFeed:
    """Open the sensor that the parameter ``imu`` names (for seat B: ``imu_b``), without starting it.

    The names are those of `inputs.sources.open_source`, and ``session:ID`` for the samples of an earlier session.

    Raises:
        ParameterError: there is no such sensor.
        StoreError: there is no such session, or it cannot be read.
    """
    virtual = clock if isinstance(clock, VirtualClock) else None
    kind, _, rest = _address(parameters, seat).partition(":")
    try:
        if kind == "session":
            source: ImuSource = _stored_source(rest, folder, virtual, seat)
        else:
            source = open_source(f"{kind}:{rest}" if rest else kind, seed=seed, clock=virtual)
    except SourceError as error:
        raise ParameterError({_parameter(seat): str(error)}) from error
    return ImuFeed(source, clock.now)


def check_sensors(parameters: TaskParameters, seats: Sequence[str]) -> None:
    """Raise ParameterError if a seat names a kind of sensor that does not exist, or two seats the same device."""
    known = [*source_names(), "session"]
    kinds = {_parameter(seat): _address(parameters, seat).strip().partition(":")[0] for seat in seats}
    problems = {
        name: f'There is no sensor "{kind}". Choose one of: {", ".join(known)}.'
        for name, kind in kinds.items()
        if kind not in known
    }
    if problems:
        raise ParameterError(problems)
    _check_distinct(parameters, seats)


def _check_distinct(parameters: TaskParameters, seats: Sequence[str]) -> None:
    if len(seats) < 2 or (address := _address(parameters, seats[0])) != _address(parameters, seats[1]):
        return
    if address.partition(":")[0] in _EXCLUSIVE:
        problem = (
            f"Both sensors are named {address}. Say which belongs to whom: --imu phidget:SERIAL for the left, "
            "--set imu_b=phidget:SERIAL for the right."
        )
        raise ParameterError({_parameter(seats[1]): problem})


def _parameter(seat: str) -> str:
    """Return the name of the parameter that names a seat's sensor."""
    return "imu" if seat == "A" else f"imu_{seat.lower()}"


def _address(parameters: TaskParameters, seat: str) -> str:
    return str(getattr(parameters, _parameter(seat), "phidget"))


def _stored_source(name: str, folder: Path, clock: Clock | None, seat: str) -> RecordedSource:
    """Open the samples of a stored session's last run that has any.

    They come in real time, or at once if the name is ``ID?speed=fast``. If the session has no sensor at this seat,
    the samples are those of seat A.
    """
    name, _, option = name.partition("?")
    database = connect(folder)
    try:
        session = sessions.find(database, folder, name)["id"]
        streams = sessions.rows(database, "imu_streams", session)
        runs = sorted({stream["run"] for stream in streams}, reverse=True)
        recorded_seat = seat if seat in {stream["seat"] for stream in streams} else "A"
        recorded = [
            samples for run in runs if len(samples := imu.samples(database, session, run=run, seat=recorded_seat))
        ]
    finally:
        database.close()
    if not recorded:
        raise SourceError(f"The session {session} holds no samples of a sensor.")
    is_fast = option == "speed=fast"
    return RecordedSource(recorded[0], "fast" if is_fast else "real time", clock=clock, name=f"session {session}")


def sensor_nodes(task: Task, seed: int, *feeds: ImuFeed) -> list[Node]:
    """Make the nodes of a live session's sensors, one per seat; a simulated one moves like an average hand."""
    nodes: list[Node] = []
    for seat, feed in zip(task.sensor_seats(task.parameters), feeds, strict=True):
        nodes.append(Imu(feed, seat))
        if move := _mover(feed.source):
            nodes.append(SimulatedMover(PEOPLE["average"], task, seed, move, seat))
    return nodes


def simulated_nodes(person: Person, task: Task, seed: int, clock: Clock, partner: Person) -> list[Node]:
    """Make a simulated participant with a simulated sensor on the hand; in a task for two, also a partner."""
    if type(clock) is VirtualClock and not task.seats[1:]:
        sensor = SimulatedSensor(simulated_hand(person.hand, seed))
        return [SimulatedParticipant(person, task, seed, sensor.move), sensor]
    hand = open_source(f"simulated:{person.hand}", seed=seed, clock=clock)
    nodes: list[Node] = [SimulatedParticipant(person, task, seed, _mover(hand)), Imu(ImuFeed(hand, clock.now))]
    for seat in task.seats[1:]:
        other = open_source(f"simulated:{partner.hand}", seed=seed + 1, clock=clock)
        nodes.append(SimulatedPartner(partner, task, seed, _mover(other), seat))
        nodes.append(Imu(ImuFeed(other, clock.now), seat))
    return nodes


def _mover(source: ImuSource) -> Callable[[int, Any], None] | None:
    """Return the function that moves a simulated sensor; None for a real one."""
    return getattr(source, "move", None)
