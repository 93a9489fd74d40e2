"""Motion sensors of a session: opens and checks them, and makes their nodes. Imports numpy: import
it late.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.inputs.imu import ImuSource, SourceError
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.recorded import RecordedSource
from sar_tui.inputs.sensor import Imu, TrunkImu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.inputs.simulated_sensor import SimulatedSensor
from sar_tui.inputs.sources import open_source, simulated_hand, source_names
from sar_tui.loop.clock import Clock, VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.language import Sentence, error_text
from sar_tui.model.messages import BodyPart
from sar_tui.model.random_streams import RandomStreams
from sar_tui.motion.synthesis import ReachShape
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import TaskParameters
from sar_tui.simulation.participant import SimulatedMover, SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect

_EXCLUSIVE = ("lsl", "phidget", "phyphox", "ros", "serial", "udp")
"""Kinds of sensors that cannot be worn in two places."""
_TRUNK = "imu_trunk"
"""The parameter that names the sensor on the trunk."""


_BOTH_ON_ONE = (
    "Both sensors are named {address}. Say which belongs to whom: --imu phidget:SERIAL for the "
    "hand, --set {name}=phidget:SERIAL for the trunk."
)
_BOTH_FOR_TWO = (
    "Both sensors are named {address}. Say which belongs to whom: --imu phidget:SERIAL for the "
    "left, --set {name}=phidget:SERIAL for the right."
)


def open_sensors(
    task: type[Task], parameters: TaskParameters, seed: int, clock: Clock, folder: Path
) -> list[ImuFeed]:
    """Open the sensor of each seat that has one, in the order of the seats, and last one on the
    trunk.

    None is started yet.

    Raises:
        ParameterError: as ``open_sensor``, or two sensors name the same device.
        StoreError: as ``open_sensor``.
    """
    worn = _worn(parameters, task.sensor_seats(parameters))
    _check_distinct(parameters, worn)
    return [
        open_sensor(parameters, seed + number, clock, folder, seat, part)
        for number, (seat, part) in enumerate(worn)
    ]


def open_sensor(
    parameters: TaskParameters,
    seed: int,
    clock: Clock,
    folder: Path,
    seat: str = "A",
    part: BodyPart = "hand",
) -> ImuFeed:
    """Open the sensor that a parameter names, without starting it: ``imu``, for seat B ``imu_b``;
    ``imu_trunk``.

    The names are those of `inputs.sources.open_source`, and ``session:ID`` for the samples of an
    earlier session.

    Raises:
        ParameterError: there is no such sensor.
        StoreError: there is no such session, or it cannot be read.
    """
    virtual = clock if isinstance(clock, VirtualClock) else None
    kind, _, rest = _address(parameters, seat, part).partition(":")
    try:
        if kind == "session":
            source: ImuSource = _stored_source(rest, folder, virtual, seat, part)
        elif kind == "simulated" and part == "trunk":
            source = _simulated_trunk(seed, virtual, rest)
        else:
            source = open_source(f"{kind}:{rest}" if rest else kind, seed=seed, clock=virtual)
    except SourceError as error:
        raise ParameterError({sensor_parameter(seat, part): error_text(error)}) from error
    return ImuFeed(source, clock.now, seat, part)


def check_sensors(parameters: TaskParameters, seats: Sequence[str]) -> None:
    """Raise ParameterError if a parameter names a kind of sensor that does not exist, or two the
    same device.
    """
    known = [*source_names(), "session"]
    worn = _worn(parameters, seats)
    kinds = {
        sensor_parameter(*where): _address(parameters, *where).strip().partition(":")[0]
        for where in worn
    }
    problems = {
        name: Sentence(
            'There is no sensor "{kind}". Choose one of: {known}.', kind=kind, known=tuple(known)
        )
        for name, kind in kinds.items()
        if kind not in known
    }
    if problems:
        raise ParameterError(problems)
    _check_distinct(parameters, worn)


def _worn(parameters: TaskParameters, seats: Sequence[str]) -> list[tuple[str, BodyPart]]:
    """Return where sensors are worn: on the hand of each seat, and on the trunk if a sensor is
    named for it.
    """
    worn: list[tuple[str, BodyPart]] = [(seat, "hand") for seat in seats]
    return [*worn, ("A", "trunk")] if getattr(parameters, _TRUNK, "") else worn


def _check_distinct(parameters: TaskParameters, worn: Sequence[tuple[str, BodyPart]]) -> None:
    if len(worn) < 2 or (address := _address(parameters, *worn[0])) != _address(
        parameters, *worn[1]
    ):
        return
    if address.partition(":")[0] in _EXCLUSIVE:
        name = sensor_parameter(*worn[1])
        problem = _BOTH_ON_ONE if name == _TRUNK else _BOTH_FOR_TWO
        raise ParameterError({name: Sentence(problem, address=address, name=name)})


def sensor_parameter(seat: str, part: BodyPart = "hand") -> str:
    """Return the name of the parameter that names a sensor."""
    if part == "trunk":
        return _TRUNK
    return "imu" if seat == "A" else f"imu_{seat.lower()}"


def _address(parameters: TaskParameters, seat: str, part: BodyPart) -> str:
    return str(getattr(parameters, sensor_parameter(seat, part), "phidget"))


def _stored_source(
    name: str, folder: Path, clock: Clock | None, seat: str, part: BodyPart
) -> RecordedSource:
    """Open the samples of a stored session's last run that has any.

    They come in real time, or at once if the name is ``ID?speed=fast``. If the session has no
    sensor at this seat, the samples are those of seat A.
    """
    name, _, option = name.partition("?")
    database = connect(folder)
    try:
        session = sessions.find(database, folder, name)["id"]
        streams = sessions.rows(database, "imu_streams", session)
        runs = sorted({stream["run"] for stream in streams}, reverse=True)
        known = seat if seat in {stream["seat"] for stream in streams} else "A"
        recorded = [
            samples
            for run in runs
            if len(samples := imu.samples(database, session, run=run, seat=known, part=part))
        ]
    finally:
        database.close()
    if not recorded:
        raise SourceError(f"The session {session} holds no samples of a sensor on the {part}.")
    is_fast = option == "speed=fast"
    return RecordedSource(
        recorded[0], "fast" if is_fast else "real time", clock=clock, name=f"session {session}"
    )


def sensor_nodes(task: Task, seed: int, *feeds: ImuFeed) -> list[Node]:
    """Make the nodes of a live session's sensors; a simulated one moves like an average person's
    hand or trunk.
    """
    trunk = next((feed for feed in feeds if feed.part == "trunk"), None)
    nodes: list[Node] = []
    for feed in feeds:
        if feed is trunk:
            nodes.append(TrunkImu(feed, feed.seat))
            continue
        nodes.append(Imu(feed, feed.seat))
        move = _mover(feed.source)
        if trunk and trunk.seat == feed.seat:
            move = leaning(PEOPLE["average"], move, _mover(trunk.source))
        if move:
            nodes.append(SimulatedMover(PEOPLE["average"], task, seed, move, feed.seat))
    return nodes


def simulated_nodes(
    person: Person, task: Task, seed: int, clock: Clock, partner: Person
) -> list[Node]:
    """Make a simulated participant with a simulated sensor on the hand; in a task for two, also a
    partner.

    If a sensor is named for the trunk, it is simulated too.
    """
    if getattr(task.parameters, _TRUNK, ""):
        source = _simulated_trunk(seed + len(task.seats), clock)
        trunk: list[Node] = [TrunkImu(ImuFeed(source, clock.now, part="trunk"))]
        lean = _mover(source)
    else:
        trunk, lean = [], None
    if type(clock) is VirtualClock and not task.seats[1:]:
        sensor = SimulatedSensor(simulated_hand(person.hand, seed))
        return [
            SimulatedParticipant(person, task, seed, leaning(person, sensor.move, lean)),
            *trunk,
            sensor,
        ]
    hand = open_source(f"simulated:{person.hand}", seed=seed, clock=clock)
    move = leaning(person, _mover(hand), lean)
    nodes: list[Node] = [
        SimulatedParticipant(person, task, seed, move),
        *trunk,
        Imu(ImuFeed(hand, clock.now)),
    ]
    for seat in task.seats[1:]:
        other = open_source(f"simulated:{partner.hand}", seed=seed + 1, clock=clock)
        nodes.append(SimulatedPartner(partner, task, seed, _mover(other), seat))
        nodes.append(Imu(ImuFeed(other, clock.now), seat))
    return nodes


def _simulated_trunk(seed: int, clock: Clock | None, profile: str = "") -> SimulatedSource:
    """Make a simulated trunk: like a hand, as a sensor on it turns about one axis too."""
    return SimulatedSource(simulated_hand(profile or "steady", seed), clock, "Simulated trunk")


def _mover(source: ImuSource) -> Callable[[int, Any], None] | None:
    """Return the function that moves a simulated sensor; None for a real one."""
    return getattr(source, "move", None)


# --- a simulated trunk


Move = Callable[[int, ReachShape], None]
"""Makes a simulated body part move, with its onset at a time, ns."""
SPREAD = 0.15
"""Standard deviation of the logarithm of the lean from reach to reach."""
_PEAK = 1.875
"""Peak of a minimum-jerk movement's speed over its mean (Flash & Hogan 1985)."""


def leaning(person: Person, hand: Move | None, trunk: Move | None) -> Move | None:
    """Return a function that moves the hand, and with it the trunk; either may be absent."""
    if trunk is None:
        return hand

    def move(at_ns: int, shape: ReachShape) -> None:
        if hand:
            hand(at_ns, shape)
        trunk(at_ns, lean(person, shape))

    return move


def lean(person: Person, shape: ReachShape) -> ReachShape:
    """Return the movement of a person's trunk in a reach: smooth, as long as the reach, by about
    ``lean_deg``.
    """
    generator = RandomStreams(shape.seed, "trunk").generator("lean", person.name)
    angle = math.radians(person.lean_deg) * math.exp(generator.gauss(0.0, SPREAD))
    return msgspec.structs.replace(
        shape,
        peak_out=_PEAK * angle / shape.out_s,
        peak_back=-_PEAK * angle / shape.back_s,
        submovements=0,
        twitch=False,
    )
