"""The motion sensor of a session: found by its name, looked at, put on the bus. Loads numpy, and so is loaded late."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from sar_tui.framework.clock import Clock, VirtualClock
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import ParameterError, TaskParameters
from sar_tui.framework.task import Task
from sar_tui.inputs.feed import ImuFeed
from sar_tui.inputs.imu import ImuSource, SourceError
from sar_tui.inputs.recorded import RecordedSource
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.sources import open_source, source_names
from sar_tui.simulation.participant import SimulatedMover, SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.person import PEOPLE, Person
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect


def sensor(parameters: TaskParameters, seed: int, clock: Clock, folder: Path, seat: str = "A") -> ImuFeed:
    """The motion sensor that a task's ``imu`` parameter names, not started yet; of seat B, its ``imu_b``.

    As `inputs.sources.open_source` knows them; and ``session:ID``, what was measured in an earlier session.

    Raises:
        ParameterError: there is no such sensor.
        StoreError: there is no such session, or it cannot be read.
    """
    virtual = clock if isinstance(clock, VirtualClock) else None
    asked_in = "imu" if seat == "A" else f"imu_{seat.lower()}"
    kind, _, name = str(getattr(parameters, asked_in, "phidget")).partition(":")
    try:
        if kind == "session":
            source: ImuSource = _stored(name, folder, virtual)
        else:
            source = open_source(f"{kind}:{name}" if name else kind, seed=seed, clock=virtual)
    except SourceError as error:
        raise ParameterError({asked_in: str(error)}) from error
    return ImuFeed(source, clock.now)


def check_sensor(parameters: TaskParameters) -> None:
    """Raise ParameterError if there is no kind of sensor of the name that ``imu`` has."""
    kind = str(getattr(parameters, "imu", "phidget")).strip().partition(":")[0]
    known = [*source_names(), "session"]
    if kind not in known:
        raise ParameterError({"imu": f'There is no sensor "{kind}". There is: {", ".join(known)}.'})


def _stored(name: str, folder: Path, clock: Clock | None) -> RecordedSource:
    """The samples of a stored session's last run that has any, in real time or (``ID?speed=fast``) at once."""
    name, _, how = name.partition("?")
    database = connect(folder)
    try:
        session = sessions.find(database, folder, name)["id"]
        runs = sorted({stream["run"] for stream in sessions.rows(database, "imu_streams", session)}, reverse=True)
        measured = [samples for run in runs if len(samples := imu.samples(database, session, run=run))]
    finally:
        database.conn.close()
    if not measured:
        raise SourceError(f"The session {session} holds no samples of a sensor.")
    return RecordedSource(
        measured[0], "fast" if how == "speed=fast" else "real time", clock=clock, name=f"session {session}"
    )


def sensing(task: Task, seed: int, *feeds: ImuFeed) -> list[Node]:
    """The nodes of a live session's motion sensors, one a seat; a simulated hand moves as an average person's would."""
    nodes: list[Node] = []
    for seat, feed in zip(task.seats, feeds, strict=False):
        nodes.append(Imu(feed, seat))
        if move := _movable(feed.source):
            nodes.append(SimulatedMover(PEOPLE["average"], task, seed, move, seat))
    return nodes


def _movable(source: ImuSource) -> Callable[[int, Any], None] | None:
    return getattr(source, "move", None)


def simulated(person: Person, task: Task, seed: int, clock: Clock, partner: Person) -> list[Node]:
    """A simulated participant with a sensor on the hand, and that sensor; and a partner's, in a task for two."""
    hand = open_source(f"simulated:{person.hand}", seed=seed, clock=clock)
    nodes: list[Node] = [SimulatedParticipant(person, task, seed, _movable(hand)), Imu(ImuFeed(hand, clock.now))]
    for seat in task.seats[1:]:
        other = open_source(f"simulated:{partner.hand}", seed=seed + 1, clock=clock)
        nodes.append(SimulatedPartner(partner, task, seed, seat, _movable(other)))
        nodes.append(Imu(ImuFeed(other, clock.now), seat))
    return nodes
