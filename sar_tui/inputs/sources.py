"""Motion sensors by name: the included ones, and those of plug-ins (entry points of the group
``sar_tui.inputs``).
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from urllib.parse import parse_qsl

import msgspec

from sar_tui.inputs.guarded_source import GuardedSource
from sar_tui.inputs.imu import ImuSource, SourceError
from sar_tui.loop.clock import Clock
from sar_tui.plugin_loader import Group

if TYPE_CHECKING:
    from sar_tui.motion.synthesis import SimulatedHand

_INSTALLED = Group("sar_tui.inputs", "sensor", SourceError)
SIMULATED_RATE_HZ = 250.0
_KIND = "kind="


def source_names() -> list[str]:
    """Return the names that ``open_source`` knows. Each source defines the text after the colon."""
    return sorted({*_SHIPPED, *_INSTALLED.names()})


def open_source(name: str, *, seed: int = 0, clock: Clock | None = None) -> ImuSource:
    """Make a source of samples by name; it is not started. Raises SourceError, with the fault in
    the name.

    - ``phidget``, ``phidget:SERIAL``, ``phidget://HOST:PORT``: a PhidgetSpatial,
      `phidget.PhidgetSource`;
    - ``simulated``, ``simulated:PROFILE``: a simulated hand, with one of
      `motion.synthesis.PROFILES`;
    - ``simulated:kind=KIND``: one whose reaches turn it about many axes, of one of
      `motion.reach_kinds.KINDS`;
    - ``recorded:FILE``, ``recorded:FILE?rate=deg/s&acceleration=g&speed=fast&loop=yes``: a
      recording;
    - ``ros://HOST[:PORT]/TOPIC[?rate=HZ]``: a sensor on a ROS system, over rosbridge;
    - any other: the entry point of that name, called with the text after the colon.

    Args:
        seed: the seed of a simulated hand's noise.
        clock: the clock of simulated hands and recordings; the host's if None.
    """
    kind, _, text = name.strip().partition(":")
    if kind in _SHIPPED:
        return _SHIPPED[kind](text, seed, clock)

    def made(make: Callable[[str], ImuSource]) -> ImuSource:
        source = make(text)
        parts = ("start", "stop", "zero", "info")
        if missing := [part for part in parts if not hasattr(source, part)]:
            raise SourceError(f"The sensor {kind} is not a source: it lacks {', '.join(missing)}.")
        return source

    if (source := _INSTALLED.load(kind, made)) is not None:
        return GuardedSource(source, kind)
    raise SourceError(f'There is no sensor "{name}". Choose one of: {", ".join(source_names())}.')


class _Playing(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options after the question mark of a recording."""

    acceleration: Literal["m/s2", "g"] = "m/s2"
    rate: Literal["rad/s", "deg/s"] = "rad/s"
    speed: Literal["real time", "fast"] = "real time"
    loop: Literal["yes", "no"] = "no"


def _phidget(address: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.phidget import PhidgetSource

    return PhidgetSource(address)


def simulated_hand(profile: str, seed: int) -> "SimulatedHand":
    """Make a simulated hand by the name of its profile, or by ``kind=`` and a kind of reach about
    many axes.

    Raises SourceError if there is none of that name.
    """
    from sar_tui.motion.synthesis import PROFILES, SimulatedHand

    if profile.startswith(_KIND):
        from sar_tui.motion.reach_kinds import KINDS
        from sar_tui.motion.simulated_arm import SimulatedArm

        kind = profile.removeprefix(_KIND)
        if kind not in KINDS:
            raise SourceError(
                f'There is no kind of reach "{kind}". Choose one of: {", ".join(KINDS)}.'
            )
        return SimulatedArm(kind, PROFILES["steady"], SIMULATED_RATE_HZ, seed)
    if (profile or "clean") not in PROFILES:
        raise SourceError(
            f'There is no simulated hand "{profile}". Choose one of: {", ".join(PROFILES)}.'
        )
    return SimulatedHand(PROFILES[profile or "clean"], SIMULATED_RATE_HZ, seed)


def _simulated(profile: str, seed: int, clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.simulated import SimulatedSource

    return SimulatedSource(simulated_hand(profile, seed), clock)


def _recorded(text: str, _seed: int, clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.recorded import RecordedSource
    from sar_tui.inputs.recording_file import Units, read_recording, refuse_degrees

    file, _, query = text.partition("?")
    if not file:
        raise SourceError("Name a recording: recorded:FILE.csv or recorded:FILE.npz.")
    try:
        options = dict(
            parse_qsl(query.replace("²", "2"), keep_blank_values=True, strict_parsing=bool(query))
        )
        playing = msgspec.convert(options, _Playing)
    except (ValueError, msgspec.ValidationError) as error:
        raise SourceError(
            f'"?{query}" is not valid ({error}). Options after the file: '
            "rate=rad/s or deg/s, acceleration=m/s2 or g, speed=real time or fast, loop=yes or "
            "no; with & between two."
        ) from error
    path = Path(file)
    samples = read_recording(path, Units(acceleration=playing.acceleration, rate=playing.rate))
    refuse_degrees(path, samples)
    return RecordedSource(
        samples, playing.speed, playing.loop == "yes", clock=clock, name=path.name
    )


def _ros(text: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.ros import RosImuSource

    return RosImuSource(text)


_SHIPPED: dict[str, Callable[[str, int, Clock | None], ImuSource]] = {
    "phidget": _phidget,
    "recorded": _recorded,
    "ros": _ros,
    "simulated": _simulated,
}
