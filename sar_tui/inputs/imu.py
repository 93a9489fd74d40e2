"""The contract of a motion sensor: what a source of samples is, and what it tells of itself."""

from collections.abc import Callable
from typing import Literal, NamedTuple, Protocol

import msgspec

Vector = tuple[float, float, float]
NOTHING: Vector = (float("nan"),) * 3
"""What a sensor tells of something it does not measure."""


class Sample(NamedTuple):
    """One measurement, stamped where it came in.

    ``host_ns``: this computer's steady clock (`framework.clock.host_now`), taken in the driver's callback.
    ``device_ms``: the sensor's own clock. ``acceleration`` in m/s², ``rate`` (angular) in rad/s, ``field`` (magnetic)
    in gauss; each about the sensor's x, y and z, or ``NOTHING``.
    """

    host_ns: int
    device_ms: float
    acceleration: Vector
    rate: Vector
    field: Vector = NOTHING


class Info(msgspec.Struct, frozen=True, kw_only=True):
    """What a sensor says of itself. ``rate_hz``: samples a second; ranges are the largest measurable, 0 if unknown."""

    source: str
    model: str
    serial: str = ""
    rate_hz: float
    rate_range_rad_s: float = 0.0
    acceleration_range_m_s2: float = 0.0
    has_acceleration: bool = True
    has_field: bool = False


class Status(msgspec.Struct, frozen=True, kw_only=True):
    """Something happened to the sensor, at ``at`` (ns, host clock).

    ``state``: ``attached`` (``info`` is known now), ``detached``, ``error`` (``detail`` says what, and what to do),
    ``gap`` (``count`` samples missing over ``duration_ms``), ``saturated`` (``count`` samples beyond its range),
    ``stalled`` (attached, but nothing comes), ``flowing`` (it comes again), ``ended`` (a recording is over).
    """

    state: Literal["attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"]
    at: int
    detail: str = ""
    count: int = 0
    duration_ms: float = 0.0


class ImuSource(Protocol):
    """A source of samples. It may call ``sink`` and ``on_status`` from a thread of its own, in the order of events.

    ``start`` never waits for the sensor and never raises for one that is missing: that is a status. ``start`` after
    ``stop`` begins anew. ``zero`` asks the sensor to take its present angular rate for rest, where it can.
    """

    @property
    def info(self) -> Info | None:
        """What the sensor is; None until it is attached."""
        ...

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Begin to deliver samples."""
        ...

    def stop(self) -> None:
        """Deliver nothing more; let go of the device. Harmless when it was not started."""
        ...

    def zero(self) -> None:
        """Take the present angular rate for rest."""
        ...


class SourceError(Exception):
    """A source cannot be made from what was asked for; one or two clear sentences."""
