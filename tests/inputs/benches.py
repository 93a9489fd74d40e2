"""Devices that a test plays to the included sources, for the contract of sensors."""

import os
import socket
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from sar_tui.api.testing import SensorBench
from sar_tui.inputs import lines
from sar_tui.inputs.imu import DEGREE, G, ImuSource, Vector
from sar_tui.inputs.line_format import HEADER
from sar_tui.inputs.lines import SerialSource, UdpSource
from sar_tui.inputs.lsl import LslSource
from sar_tui.inputs.phidget import PhidgetSource
from sar_tui.inputs.phyphox import PhyphoxSource
from sar_tui.inputs.ros import RosImuSource
from sar_tui.model.units import MS, SECOND
from tests.fake_rosbridge import RosBridge, ros_bridge
from tests.inputs.fake_phone import REST, Phone, phone
from tests.inputs.test_lsl_in import outlet
from tests.inputs.test_phidget import FakeSpatial
from tests.inputs.test_ros import BORN_NS, TOPIC, imu
from tests.outputs.markers.receivers import Line, serial_line, udp_receiver

PATIENCE_S = 60.0


class PhidgetBench(SensorBench):
    """A fake channel of the driver."""

    rate_hz = 250.0
    patience_s = PATIENCE_S

    def __init__(self) -> None:
        super().__init__()
        self._channel: FakeSpatial | None = None
        self._is_there = False

    def make(self) -> ImuSource:
        return PhidgetSource(make=self._make, denied=lambda: False)

    def _make(self) -> FakeSpatial:
        self._channel = FakeSpatial()
        return self._channel

    def plug_in(self) -> None:
        assert self._channel
        self._channel.plug_in()
        self._is_there = True

    def unplug(self) -> None:
        if self._is_there and self._channel and self._channel.handlers.get("Detach"):
            self._channel.pull_out()
        self._is_there = False

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        assert self._channel
        in_g = [axis / G for axis in acceleration]
        self._channel.send(in_g, [axis / DEGREE for axis in rate], [0.0, 0.0, 0.0], device_ms)


class PhoneBench(SensorBench):
    """A phone with phyphox, whose clock runs on while it is away."""

    patience_s = PATIENCE_S

    def __init__(self, phone: Phone) -> None:
        super().__init__()
        self._phone = phone
        self._is_there = True
        self._asked = 0
        self._began_s = 0.0

    def make(self) -> ImuSource:
        return PhyphoxSource(f"//127.0.0.1:{self._phone.port}", self._phone.now)

    def plug_in(self) -> None:
        if not self._is_there:
            self._phone.arrive()
        self._is_there = True
        self._asked = len(self._phone.requests)

    def is_heard(self) -> bool:
        asked = sum(path.startswith("/get") for path in self._phone.requests[self._asked :])
        self._began_s = self._phone.now_s
        return self._phone.measuring and asked > 2

    def unplug(self) -> None:
        if self._is_there:
            self._phone.leave()
            self._phone.measuring = False
        self._is_there = False

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        after = self._began_s + (device_ms + 1000 / self.rate_hz) / 1000 - self._phone.now_s
        self._phone.measure(1, after, lambda t: rate, lambda t: acceleration)

    def now(self) -> int:
        return self._phone.now()

    def wait(self, until: Callable[[], bool]) -> bool:
        def passed() -> bool:
            if not self._is_there:
                self._phone.measure(1, 0.01, lambda t: REST)
            return until()

        return super().wait(passed)


class RosBench(SensorBench):
    """A topic behind a rosbridge server."""

    patience_s = PATIENCE_S

    def __init__(self, server: RosBridge) -> None:
        super().__init__()
        self._server = server
        self._is_there = True

    def make(self) -> ImuSource:
        return RosImuSource(f"//{self._server.host}{TOPIC}")

    def plug_in(self) -> None:
        if not self._is_there:
            self._server.arrive()
        self._is_there = True

    def is_heard(self) -> bool:
        return self._server.has_subscriber(TOPIC)

    def unplug(self) -> None:
        if self._is_there:
            self._server.leave()
        self._is_there = False

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        stamp = BORN_NS + round(device_ms * MS)
        self._server.publish(TOPIC, imu(stamp, rate, acceleration))


class LinesBench(SensorBench):
    """A board that sends lines; one that is unplugged sends none."""

    patience_s = PATIENCE_S

    def is_heard(self) -> bool:
        return self.statuses[-1:] != [] and self.statuses[-1].state == "detached"

    @abstractmethod
    def write(self, text: bytes) -> None:
        """Send lines."""

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        values = [*(axis / DEGREE for axis in rate), *(axis / G for axis in acceleration)]
        numbers = ",".join(f"{value:.6f}" for value in values)
        self.write(f"{HEADER}\n{device_ms * 1000:.0f},{numbers}\n".encode())


class UdpBench(LinesBench):
    """A board with a network. A source notices its absence by its silence."""

    def __init__(self, port: int) -> None:
        super().__init__()
        self._port = port
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def make(self) -> ImuSource:
        return UdpSource(f"//:{self._port}")

    def plug_in(self) -> None:
        lines.SILENCE = 3600 * SECOND

    def unplug(self) -> None:
        lines.SILENCE = 0

    def write(self, text: bytes) -> None:
        self._socket.sendto(text, ("127.0.0.1", self._port))

    def close(self) -> None:
        self._socket.close()


class SerialBench(LinesBench):
    """A board on a pseudo-terminal, which has another name each time."""

    def __init__(self, place: str) -> None:
        super().__init__()
        self._place = place
        self._line: Line | None = None
        self._cables: list[Any] = []

    def make(self) -> ImuSource:
        return SerialSource(f"//{self._place}")

    def plug_in(self) -> None:
        self.unplug()
        cable = serial_line()
        self._line = cable.__enter__()
        self._cables.append(cable)
        os.symlink(self._line.name, self._place)
        self._is_opened = False

    def is_heard(self) -> bool:
        return super().is_heard() and self.statuses[-1].detail.startswith("Waiting for lines")

    def unplug(self) -> None:
        if self._line:
            os.unlink(self._place)
            self._line.unplug()
        self._line = None

    def write(self, text: bytes) -> None:
        assert self._line
        if not self._is_opened:
            text = b"\n" + text
        self._is_opened = True
        os.write(self._line._box, text)


class LslBench(SensorBench):
    """An outlet, made anew each time."""

    rate_hz = 100.0
    patience_s = PATIENCE_S

    def __init__(self, name: str) -> None:
        super().__init__()
        self._stream = name
        self._outlet: Any = None

    def make(self) -> ImuSource:
        return LslSource(f"//{self._stream}")

    def plug_in(self) -> None:
        self._outlet = outlet(self._stream, rate_hz=self.rate_hz)

    def is_heard(self) -> bool:
        return bool(self._outlet.have_consumers())

    def unplug(self) -> None:
        self._outlet = None

    def measure(self, device_ms: float, acceleration: Vector, rate: Vector) -> None:
        values = [*(axis / G for axis in acceleration), *(axis / DEGREE for axis in rate)]
        self._outlet.push_sample(values, 500 + device_ms / 1000)


@contextmanager
def ros_bench() -> Iterator[SensorBench]:
    with ros_bridge() as server:
        yield RosBench(server)


@contextmanager
def phone_bench() -> Iterator[SensorBench]:
    with phone() as it:
        yield PhoneBench(it)


@contextmanager
def udp_bench() -> Iterator[SensorBench]:
    with udp_receiver() as receiver:  # skips where there is no loopback
        port = int(receiver.address.rpartition(":")[2])
    bench = UdpBench(port)
    try:
        yield bench
    finally:
        bench.close()
