"""A fake servo controller: the methods of Phidget22's ``RCServo``."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from benchmarks.fake_phidget import SERVO_LIMITS
from sar_tui.loop.clock import Clock, VirtualClock
from sar_tui.model.units import MS
from sar_tui.outputs.servo.servo import Servo
from tests.drivers.fake_phidget import FakeChannel, PhidgetError
from tests.outputs.contract import Rig, host_clock

UNSUPPORTED = PhidgetError(20, "Unsupported")
NOT_ATTACHED = PhidgetError(52, "Device not Attached")


class FakeServo(FakeChannel):
    """A channel and its motor. ``calls``: the calls in order, with their times (ns of
    ``clock``).
    """

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self.clock = clock
        self.plugged_in = False
        device = {"DeviceName": "16x RC Servo Phidget", "DeviceSKU": "RCC1000_0"}
        self.facts |= {**device, **SERVO_LIMITS, "Engaged": False, "DeviceSerialNumber": 620_001}

    def note(self, name: str, arguments: tuple[Any, ...]) -> None:
        self.calls.append((self.clock.now(), name, arguments))

    def plug_in(self) -> None:
        self.plugged_in = True
        super().plug_in()

    def pull_out(self) -> None:
        self.plugged_in = self.facts["Engaged"] = False
        self.failing["setTargetPosition"] = self.failing["setEngaged"] = NOT_ATTACHED
        super().pull_out()

    def put_back(self) -> None:
        self.failing.clear()
        self.plug_in()

    def sent(self, name: str) -> list[Any]:
        """Return the arguments of all calls of a method."""
        return [(*given, None)[0] for _, called, given in self.calls if called == name]

    @property
    def targets(self) -> list[tuple[float, float]]:
        """Return each target sent while the motor was engaged, in ms and degrees, with the
        first.
        """
        found, engaged, target = [], False, 90.0
        for at, name, arguments in self.calls:
            if name == "setEngaged":
                engaged = arguments[0]
            elif name == "setTargetPosition":
                target = arguments[0]
            if engaged and name in ("setEngaged", "setTargetPosition"):
                found.append((at / MS, target))
        return found


class ServoBench:
    """A servo output on fake channels, on a clock that a test advances."""

    def __init__(
        self, address: str = "", plug: bool = True, denied: bool = False, clock: Clock | None = None
    ) -> None:
        self.time = clock or VirtualClock()
        self.channels: list[FakeServo] = []
        self.plug = plug
        self.failing: dict[str, Exception] = {}
        self.servo = Servo(address, make=self.make, denied=lambda: denied)
        self.rig = Rig(self.servo, self.time, lasting=["gesture"])
        self.rig.wait(
            lambda: len(self.channels) == len(self.servo._address.joint_channels) and self.settled()
        )

    def settled(self) -> bool:
        return all(channel.plugged_in or not self.plug for channel in self.channels)

    def make(self) -> FakeServo:
        channel = FakeServo(self.time)
        channel.failing = self.failing
        if self.plug:
            channel.during["open"] = channel.plug_in
        self.channels.append(channel)
        return channel


@contextmanager
def servo_rig(live: bool = False) -> Iterator[Rig]:
    """Provide a robot with a right arm that is plugged in; a live one has a thread of its own."""
    with host_clock() if live else nullcontext(VirtualClock()) as clock:
        bench = ServoBench(clock=clock)
        try:
            yield bench.rig
        finally:
            bench.servo.close()
