"""The motion sensor of a session: found by its name, looked at, put on the bus. Loads numpy, and so is loaded late."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sar_tui.framework.clock import Clock, VirtualClock
from sar_tui.framework.declaration import ParameterError
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import TaskParameters
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

_WHICH = "Say which is whose: --imu phidget:SERIAL for the left, --set imu_b=phidget:SERIAL for the right."


def sensor(parameters: TaskParameters, seed: int, clock: Clock, folder: Path, seat: str = "A") -> ImuFeed:
    """The motion sensor that a task's ``imu`` parameter names, not started yet; of seat B, its ``imu_b``.

    As `inputs.sources.open_source` knows them; and ``session:ID``, what was measured in an earlier session.

    Raises:
        ParameterError: there is no such sensor.
        StoreError: there is no such session, or it cannot be read.
    """
    virtual = clock if isinstance(clock, VirtualClock) else None
    kind, _, name = _named(parameters, seat).partition(":")
    try:
        if kind == "session":
            source: ImuSource = _stored(name, folder, virtual, seat)
        else:
            source = open_source(f"{kind}:{name}" if name else kind, seed=seed, clock=virtual)
    except SourceError as error:
        raise ParameterError({_asked_in(seat): str(error)}) from error
    return ImuFeed(source, clock.now)


def check_sensors(parameters: TaskParameters, seats: Sequence[str]) -> None:
    """Raise ParameterError if there is no kind of sensor of a name that ``imu`` has, or ``imu_b`` for seat B.

    Or if two seats are to have the same one.
    """
    known = [*source_names(), "session"]
    kinds = {_asked_in(seat): _named(parameters, seat).strip().partition(":")[0] for seat in seats}
    problems = {
        name: f'There is no sensor "{kind}". There is: {", ".join(known)}.'
        for name, kind in kinds.items()
        if kind not in known
    }
    if problems:
        raise ParameterError(problems)
    _check_apart(parameters, seats)


def sensors(task: type[Task], parameters: TaskParameters, seed: int, clock: Clock, folder: Path) -> list[ImuFeed]:
    """The sensors of all seats that wear one, in their order; not started yet.

    Raises as ``sensor``, and ParameterError if two seats are to have the same one.
    """
    seats = task.sensed(parameters)
    _check_apart(parameters, seats)
    return [sensor(parameters, seed + number, clock, folder, seat) for number, seat in enumerate(seats)]


def _check_apart(parameters: TaskParameters, seats: Sequence[str]) -> None:
    """A device that two seats name would be anybody's: which is whose has to be said."""
    if len(seats) > 1 and (name := _named(parameters, seats[0])) == _named(parameters, seats[1]):
        kind = name.partition(":")[0]
        if kind in ("phidget", "ros"):
            raise ParameterError({_asked_in(seats[1]): f"Both sensors are named {name}. {_WHICH}"})


def _asked_in(seat: str) -> str:
    """The parameter that names the sensor of a seat."""
    return "imu" if seat == "A" else f"imu_{seat.lower()}"


def _named(parameters: TaskParameters, seat: str) -> str:
    return str(getattr(parameters, _asked_in(seat), "phidget"))


def _stored(name: str, folder: Path, clock: Clock | None, seat: str) -> RecordedSource:
    """The samples of a stored session's last run that has any, in real time or (``ID?speed=fast``) at once.

    Of two hands those of the seat; of one, that one's.
    """
    name, _, how = name.partition("?")
    database = connect(folder)
    try:
        session = sessions.find(database, folder, name)["id"]
        streams = sessions.rows(database, "imu_streams", session)
        runs = sorted({stream["run"] for stream in streams}, reverse=True)
        worn = seat if seat in {stream["seat"] for stream in streams} else "A"
        measured = [samples for run in runs if len(samples := imu.samples(database, session, run=run, seat=worn))]
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
    for seat, feed in zip(task.sensed(task.parameters), feeds, strict=True):
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
