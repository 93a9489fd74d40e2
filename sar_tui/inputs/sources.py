"""Motion sensors by name: the included ones, and those of plug-ins (entry points of the group
``sar_tui.inputs``).
"""

from collections.abc import Callable
from math import isfinite, nan
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar
from urllib.parse import parse_qsl

import msgspec

from sar_tui.inputs.imu import ImuSource, Info, Sample, SourceError, Status, Vector
from sar_tui.loop.clock import Clock, host_now
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugin_loader import Group

if TYPE_CHECKING:
    from sar_tui.motion.synthesis import SimulatedHand

_INSTALLED = Group("sar_tui.inputs", "sensor", SourceError)
SIMULATED_RATE_HZ = 250.0
_KIND = "kind="


def source_names() -> list[str]:
    """Return the names that ``open_source`` knows. Each source defines the text after the colon."""
    return sorted({*_SHIPPED, *_INSTALLED.names()})


def plug_in_names() -> list[str]:
    """Return the names of the sensors of plug-ins."""
    return sorted(_INSTALLED.names())


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
    - ``phyphox://HOST[:PORT]``: a phone with the app phyphox;
    - ``udp://[HOST]:PORT``, ``serial://PORT[@BAUD]``: lines of text;
    - ``lsl://NAME``: a stream of LSL;
    - any other: the entry point of that name, called with the text after the colon.

    A plug-in takes precedence, so that it keeps working when a source of its name is included.

    Args:
        seed: the seed of a simulated hand's noise.
        clock: the clock of simulated hands and recordings; the host's if None.
    """
    kind, _, text = name.strip().partition(":")

    def made(make: Callable[[str], ImuSource]) -> ImuSource:
        source = make(text)
        parts = ("start", "stop", "zero", "info")
        if missing := [part for part in parts if not hasattr(source, part)]:
            raise SourceError(f"The sensor {kind} is not a source: it lacks {', '.join(missing)}.")
        return source

    if (source := _INSTALLED.load(kind, made)) is not None:
        return GuardedSource(source, kind)
    if kind in _SHIPPED:
        return _SHIPPED[kind](text, seed, clock)
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
        from sar_tui.motion.trajectories import SimulatedArm

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


def _phyphox(text: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.phyphox import PhyphoxSource

    return PhyphoxSource(text)


def _udp(text: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.lines import UdpSource

    return UdpSource(text)


def _serial(text: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.lines import SerialSource

    return SerialSource(text)


def _lsl(text: str, _seed: int, _clock: Clock | None) -> ImuSource:
    from sar_tui.inputs.lsl import LslSource

    return LslSource(text)


_SHIPPED: dict[str, Callable[[str, int, Clock | None], ImuSource]] = {
    "lsl": _lsl,
    "phidget": _phidget,
    "phyphox": _phyphox,
    "recorded": _recorded,
    "ros": _ros,
    "serial": _serial,
    "simulated": _simulated,
    "udp": _udp,
}


_T = TypeVar("_T", bound=msgspec.Struct)
_LAST_NS = 2**63 - 1
_UNREADABLE = Sample(0, nan, (), (), ())  # type: ignore[arg-type]
"""Stands for a sample of a wrong type: the feed leaves it out, and reports it, as any sample of a
wrong length.
"""


class GuardedSource:
    """A source that keeps its contract, whatever the source of a plug-in does.

    Args:
        plug_in: the source of the plug-in.
        name: its name, for the reports.

    Attributes:
        keeps_bias: True if the source says that it cannot take the present rate as zero.
    """

    def __init__(self, plug_in: ImuSource, name: str) -> None:
        self.plug_in = plug_in
        self.keeps_bias = bool(getattr(plug_in, "keeps_bias", False))
        self._name = name
        self._report: Callable[[Status], None] = lambda status: None

    @property
    def info(self) -> Info | None:
        """Description of the sensor; None until it is attached, or if it cannot be read."""
        try:
            return _read_info(self.plug_in.info)
        except PLUGIN_ERRORS:
            return None

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Start delivering samples; a failure is a status."""
        self._report = on_status

        def deliver(sample: object) -> None:
            sink(_read_sample(sample))

        try:
            self.plug_in.start(deliver, self._status)
        except PLUGIN_ERRORS as error:
            self._fail("cannot be started", error)

    def stop(self) -> None:
        """Stop delivering; a failure is a status."""
        try:
            self.plug_in.stop()
        except PLUGIN_ERRORS as error:
            self._fail("cannot be stopped", error)

    def zero(self) -> None:
        """Take the present angular rate as zero; a failure is a status."""
        try:
            self.plug_in.zero()
        except PLUGIN_ERRORS as error:
            self._fail("cannot be zeroed", error)

    def _status(self, status: Any) -> None:
        """Pass a status on if it can be read, and the description of a sensor that is attached,
        too.
        """
        try:
            read = _read_status(status)
            if read.state == "attached":
                _read_info(self.plug_in.info)
        except PLUGIN_ERRORS as error:
            self._fail("does not keep its contract", error)
        else:
            self._report(read)

    def _fail(self, what: str, error: BaseException) -> None:
        why = f"{type(error).__name__}: {error}"
        self._report(
            Status(state="error", at=host_now(), detail=f"The sensor {self._name} {what} ({why}).")
        )


def _read_info(info: Any) -> Info | None:
    """Return a description with every field of its type. Raises an error if it is none."""
    if info is None:
        return None
    read = _converted(info, Info)
    if not all(map(isfinite, (read.rate_hz, read.rate_range_rad_s, read.acceleration_range_m_s2))):
        raise ValueError("a number in its Info is not finite")
    return read


def _read_status(status: Any) -> Status:
    """Return a status with every field of its type. Raises an error if it is none."""
    read = _converted(status, Status)
    if abs(read.at) > _LAST_NS or abs(read.count) > _LAST_NS or not isfinite(read.duration_ms):
        raise ValueError("a number in its Status is too large")
    return read


def _converted(value: Any, kind: type[_T]) -> _T:
    if not isinstance(value, kind):
        raise TypeError(f"{type(value).__name__} in place of {kind.__name__}")
    fields = {name: _plain(each) for name, each in msgspec.structs.asdict(value).items()}
    return msgspec.convert(fields, kind)


def _plain(value: Any) -> Any:
    """Return a number of a library as Python's."""
    if isinstance(value, Integral):
        return value if isinstance(value, bool) else int(value)
    return float(value) if isinstance(value, Real) else value


def _read_sample(sample: Any) -> Sample:
    """Return a sample of numbers of Python, or one that the feed leaves out."""
    try:
        host_ns, device_ms, acceleration, rate, field = sample
        if (
            isinstance(host_ns, Integral)
            and isinstance(device_ms, Real)
            and 0 <= int(host_ns) <= _LAST_NS
        ):
            vectors = _vector(acceleration), _vector(rate), _vector(field)
            return Sample(int(host_ns), float(device_ms), *vectors)
    except (TypeError, ValueError, OverflowError):
        pass
    return _UNREADABLE._replace(host_ns=host_now())


def _vector(values: Any) -> Vector:
    """Return three floats. Raises TypeError or ValueError if they are not three numbers."""
    if not all(isinstance(value, Real) for value in values):
        raise TypeError
    x, y, z = values
    return float(x), float(y), float(z)
