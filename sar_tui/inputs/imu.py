"""The contract of a motion sensor: sources, their samples and their statuses."""

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, Protocol

import msgspec

G = 9.80665
"""m/s² in a g."""
DEGREE = math.pi / 180
"""rad in a degree."""
RATE_UNITS = {"rad/s": 1.0, "deg/s": DEGREE}
ACCELERATION_UNITS = {"m/s2": 1.0, "g": G}

Vector = tuple[float, float, float]
NOTHING: Vector = (float("nan"),) * 3
"""Value of a quantity that the sensor does not measure."""


class Sample(NamedTuple):
    """One measurement, stamped on arrival.

    ``host_ns``: the host's monotonic clock (`loop.clock.host_now`), taken in the driver's callback.
    ``device_ms``: the sensor's own clock. ``acceleration`` in m/s², ``rate`` (angular) in rad/s,
    ``field`` (magnetic) in gauss; each along the sensor's x, y and z, or ``NOTHING``.
    """

    host_ns: int
    device_ms: float
    acceleration: Vector
    rate: Vector
    field: Vector = NOTHING


class Info(msgspec.Struct, frozen=True, kw_only=True):
    """Description of a sensor. ``rate_hz``: samples per second. Ranges are the largest values, 0 if
    unknown.
    """

    source: str
    model: str
    serial: str = ""
    rate_hz: float
    rate_range_rad_s: float = 0.0
    acceleration_range_m_s2: float = 0.0
    has_acceleration: bool = True
    has_field: bool = False


class Status(msgspec.Struct, frozen=True, kw_only=True):
    """A change of the sensor's state at ``at`` (ns, host clock).

    ``state``: ``attached`` (``info`` is available), ``detached``, ``error`` (``detail`` says what
    happened and what to do), ``gap`` (``count`` samples missing over ``duration_ms``),
    ``saturated`` (``count`` samples beyond the range), ``stalled`` (attached, but no samples),
    ``flowing`` (samples again), ``ended`` (the end of a recording).
    """

    state: Literal[
        "attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"
    ]
    at: int
    detail: str = ""
    count: int = 0
    duration_ms: float = 0.0


class ImuSource(Protocol):
    """A source of samples. It may call ``sink`` and ``on_status`` from its own thread, in the order
    of events.

    ``start`` never waits for the sensor, and never raises if it is missing: that is a status. A
    source can be started again after ``stop``. ``zero`` asks the sensor to measure its bias at
    rest, if it can.
    """

    @property
    def info(self) -> Info | None:
        """Description of the sensor; None until it is attached."""
        ...

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Start delivering samples."""
        ...

    def stop(self) -> None:
        """Stop delivering, and release the device. Harmless if it was not started."""
        ...

    def zero(self) -> None:
        """Take the present angular rate as zero."""
        ...


class SourceError(Exception):
    """A source cannot be made as requested. The message is one or two clear sentences."""
