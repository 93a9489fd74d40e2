"""A motion sensor on a ROS system: ``sensor_msgs/Imu``, through the rosbridge protocol."""

import math
from collections.abc import Callable
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from sar_tui.drivers.address import AddressError, parse
from sar_tui.drivers.rosbridge import PORT, Bridge, TopicName
from sar_tui.inputs.delivery import Delivery
from sar_tui.inputs.imu import NOTHING, Info, Sample, SourceError, Status, Vector
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND
from sar_tui.model.visible_text import visible

IMU = "sensor_msgs/Imu"
_TOO_LARGE = 1e30
_EXAMPLE = (
    "ros://HOST/TOPIC or ros://HOST:PORT/TOPIC, such as ros://192.0.2.7/imu/data, and after it, "
    "if you know how many samples come a second, ?rate=NUMBER"
)
_NO_RATE = (
    "The sensor on {} reports that it does not measure angular rate (its covariance begins with "
    "-1), so it cannot show how a hand turns. Use one with a gyroscope."
)
_NO_SAMPLE = "The messages on {} are not sensor_msgs/Imu ({}); such messages are left out."
_NOT_RISING = (
    "The time stamps on {} do not increase, so the sample rate is unknown: set it with "
    "?rate=NUMBER."
)


class _Options(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Options after the question mark. ``rate``: samples per second."""

    rate: Annotated[float, Meta(gt=0, le=10_000)] | None = None


class _Axes(msgspec.Struct, frozen=True):
    """A ``geometry_msgs/Vector3``. JSON has no not-a-number: rosbridge sends null."""

    x: float | None
    y: float | None
    z: float | None

    @property
    def vector(self) -> Vector:
        return _number(self.x), _number(self.y), _number(self.z)


_Seconds = Annotated[int, Meta(ge=-(2**31), lt=2**32)]
_Nanoseconds = Annotated[int, Meta(ge=0, lt=2**32)]


class _Stamp(msgspec.Struct, frozen=True):
    """A time: ``secs`` and ``nsecs`` in ROS 1, ``sec`` and ``nanosec`` in ROS 2."""

    secs: _Seconds = 0
    nsecs: _Nanoseconds = 0
    sec: _Seconds = 0
    nanosec: _Nanoseconds = 0

    @property
    def ns(self) -> int:
        return (self.secs + self.sec) * SECOND + self.nsecs + self.nanosec


class _Header(msgspec.Struct, frozen=True):
    stamp: _Stamp
    frame_id: str = ""


class _Imu(msgspec.Struct, frozen=True):
    header: _Header
    angular_velocity: _Axes
    linear_acceleration: _Axes
    angular_velocity_covariance: tuple[float | None, ...] = ()
    linear_acceleration_covariance: tuple[float | None, ...] = ()


class RosImuSource:
    """A topic of ``sensor_msgs/Imu`` (rad/s, m/s²) as a source of samples.

    The device's clock is the header's stamp, counted from the first sample of each connection; if a
    driver leaves it at zero, this computer's clock is used. The sensor is attached when its rate is
    known: from the stamps of the first samples, none of which is lost, or at once if the address
    gives it. A covariance that begins with -1 means that the quantity is not measured.

    Args:
        address: ``//HOST[:PORT]/TOPIC[?rate=HZ]``, with or without ``ros:``. Raises SourceError for
            anything else.
    """

    keeps_bias = True
    """ROS has no common service to take the present rate as zero."""

    def __init__(self, address: str) -> None:
        try:
            self._address = parse(address, "ros", PORT, _EXAMPLE)
            self._topic: str = msgspec.convert(self._address.path, TopicName)
            rate_hz = msgspec.convert(self._address.options, _Options, strict=False).rate
        except AddressError as error:
            raise SourceError(str(error)) from error
        except msgspec.ValidationError as error:
            raise SourceError(
                f'The sensor "{address}" is not valid ({error}). Use {_EXAMPLE}.'
            ) from error
        self._bridge: Bridge | None = None
        self._delivery = Delivery(self._described, _NOT_RISING.format(self._topic), rate_hz)
        self._begin()

    @property
    def info(self) -> Info | None:
        """Description of the sensor; None until it is attached."""
        return self._delivery.info

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Connect in the background, and deliver samples."""
        self.stop()
        self._delivery.begin(sink, on_status)
        self._begin()
        self._delivery.wait(f"Waiting for the ROS bridge at {self._address}.")
        bridge = Bridge(
            self._address,
            {},
            {self._topic: (IMU, lambda message: self._received(bridge, message))},
            lambda: self._changed(bridge),
        )
        self._bridge = bridge
        bridge.open()

    def stop(self) -> None:
        """Stop delivering, and disconnect. Takes at most a second if the bridge hangs."""
        bridge, self._bridge = self._bridge, None
        if bridge is not None:
            bridge.close()
        self._delivery.forget()

    def zero(self) -> None:
        """Do nothing: the sensor keeps its bias."""

    def _begin(self) -> None:
        self._delivery.forget()
        self._origin_ns: int | None = None
        self._frame = ""

    def _changed(self, bridge: Bridge) -> None:
        if bridge is not self._bridge:
            return
        self._begin()
        if bridge.problem:
            self._delivery.complain(bridge.problem)
        elif bridge.is_connected:
            self._delivery.wait(
                f"Waiting for samples on {self._topic} of the ROS bridge at {self._address}."
            )
        else:
            self._delivery.wait(
                f"The connection to the ROS bridge at {self._address} was lost. Waiting for it."
            )

    def _received(self, bridge: Bridge, message: Any) -> None:
        host_ns = host_now()
        if bridge is not self._bridge:
            return
        try:
            imu = msgspec.convert(message, _Imu)
        except msgspec.ValidationError as error:
            self._delivery.complain(_NO_SAMPLE.format(self._topic, error))
            return
        if not _measures(imu.angular_velocity_covariance):
            self._delivery.complain(_NO_RATE.format(self._topic))
            return
        self._frame = visible(imu.header.frame_id)[:40]
        self._delivery.put(self._sample(host_ns, imu), stamped=imu.header.stamp.ns != 0)

    def _sample(self, host_ns: int, imu: _Imu) -> Sample:
        device_ns = imu.header.stamp.ns or host_ns
        if self._origin_ns is None:
            self._origin_ns = device_ns
        return Sample(
            host_ns,
            (device_ns - self._origin_ns) / 1e6,
            imu.linear_acceleration.vector
            if _measures(imu.linear_acceleration_covariance)
            else NOTHING,
            imu.angular_velocity.vector,
        )

    def _described(self, rate_hz: float, has_acceleration: bool) -> Info:
        return Info(
            source=f"ros://{self._address.host}:{self._address.port}{self._topic}",
            model=f"{IMU} ({self._frame})" if self._frame else IMU,
            rate_hz=rate_hz,
            has_acceleration=has_acceleration,
        )


def _measures(covariance: tuple[float | None, ...]) -> bool:
    return not covariance or covariance[0] != -1


def _number(value: float | None) -> float:
    return value if value is not None and abs(value) < _TOO_LARGE else math.nan
