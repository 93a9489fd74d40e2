"""A servo motor on a channel of a Phidget controller: one joint of the robot."""

import re
from collections.abc import Callable
from contextlib import suppress
from typing import Annotated, Any, NamedTuple
from urllib.parse import parse_qsl

import msgspec
from msgspec import Meta

from sar_tui.drivers.phidget import describe
from sar_tui.model.gesture import JOINTS
from sar_tui.model.units import MS
from sar_tui.outputs.output import OutputError

_CHANNEL = re.compile("-?[0-9]{1,2}")
_HOW = (
    f"Use servo, or servo:SERIAL?right_arm=0&left_arm=-1: joints are {', '.join(JOINTS[:-1])} and "
    f"{JOINTS[-1]}, each with its channel on the controller (- before the number reverses the "
    "joint); range=45 is how many degrees it moves to either side (5 to 90), speed=180 how many "
    "per second (30 to 360)."
)


class JointChannel(NamedTuple):
    """A joint, its channel on the controller, and whether its direction is reversed."""

    joint: str
    channel: int
    reverse: bool


class ServoAddress(NamedTuple):
    """The controller, its joints, and the limits of their movement.

    ``serial``: None for any controller. ``range_deg``: degrees to either side of the middle.
    ``speed_deg_s``: greatest speed, degrees per second.
    """

    serial: int | None
    joint_channels: tuple[JointChannel, ...]
    range_deg: float
    speed_deg_s: float


class _Options(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Options after the question mark."""

    nod: str = ""
    turn: str = ""
    left_arm: str = ""
    right_arm: str = ""
    lean: str = ""
    range: Annotated[float, Meta(ge=5, le=90)] = 45.0
    speed: Annotated[float, Meta(ge=30, le=360)] = 180.0


def parse(text: str) -> ServoAddress:
    """Parse the text after ``servo:``. Empty text means the right arm on channel 0 of any
    controller.

    Raises OutputError, with the allowed forms.
    """
    serial, _, query = text.partition("?")
    try:
        if serial and not (serial.isascii() and serial.isdigit()):
            raise ValueError(f'"{serial}" is not a serial number')
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query))
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a name is used twice")
        options = msgspec.convert(dict(pairs), _Options, strict=False)
        channels = tuple(
            _joint_channel(joint, getattr(options, joint))
            for joint in JOINTS
            if joint in dict(pairs)
        )
        if len({each.channel for each in channels}) < len(channels):
            raise ValueError("two joints have the same channel")
    except (ValueError, msgspec.ValidationError) as error:
        raise OutputError(f"There is no output servo:{text} ({error}). {_HOW}") from error
    return ServoAddress(
        serial=int(serial) if serial else None,
        joint_channels=channels or (JointChannel("right_arm", 0, reverse=False),),
        range_deg=options.range,
        speed_deg_s=options.speed,
    )


def _joint_channel(joint: str, channel: str) -> JointChannel:
    if not _CHANNEL.fullmatch(channel):
        raise ValueError(f'{joint} needs a channel number, not "{channel}"')
    return JointChannel(joint, abs(int(channel)), channel.startswith("-"))


FAILSAFE_MS = 1000
"""Time without a sign of life after which a controller releases the motor."""
FEED_MS = 250
"""Interval of signs of life. Phidgets advises at most a third of the failsafe time."""
_ACCELERATION = 10.0
"""Factor of the speed limit, giving degrees per second squared: full speed after a tenth of a
second.
"""
_UNSUPPORTED, _NOT_ATTACHED, _FAILSAFE = 20, 52, 59
_FAILSAFE_EVENT, _CLEARED = 4108, 4096
_ADVICE = {
    1: " Install the same version of Phidget22 here and on the network server.",
    2: " Close the other program that uses it.",
}
_TRIES = 3
_FAILSAFE_TEXT = "Its failsafe released it because this program did not run for a second."


class ServoChannel:
    """One motor: attached or not, engaged or limp.

    On attaching, its middle, range, velocity and acceleration limits are set, and the failsafe if
    the controller has one. It holds its position only while engaged; otherwise a hand may move it.
    All methods are called by one thread; the driver's threads only call the handlers.

    Args:
        joint_channel: the joint, its channel and direction.
        address: the controller, and the limits of movement.
        failsafe: True if the controller releases the motor when it gets no sign of life; False on a
            virtual clock.
        changed: called by the driver's thread when the channel is attached or detached.
    """

    def __init__(
        self,
        joint_channel: JointChannel,
        address: ServoAddress,
        failsafe: bool,
        changed: Callable[[], None],
    ) -> None:
        self.joint = joint_channel.joint
        self.attached = False
        self.engaged = False
        self.has_failsafe = False
        self.trouble = ""
        self.model = ""
        self._joint_channel = joint_channel
        self._address = address
        self._failsafe = failsafe
        self._changed = changed
        self._channel: Any = None
        self._middle = self._range = 0.0
        self._target: float | None = None
        self._fed_at = 0
        self._needs_reopening = False

    @property
    def place(self) -> str:
        """Its name in a sentence."""
        return f"{self.joint} on channel {self._joint_channel.channel}"

    def open(self, channel: Any) -> None:
        """Wait in the background for the motor's controller. ``channel``: an unopened ``RCServo``
        of Phidget22.
        """
        self._channel = channel
        channel.setOnAttachHandler(self._on_attach)
        channel.setOnDetachHandler(self._on_detach)
        channel.setOnErrorHandler(self._on_error)
        channel.setIsLocal(True)
        channel.setIsRemote(False)
        channel.setChannel(self._joint_channel.channel)
        if self._address.serial is not None:
            channel.setDeviceSerialNumber(self._address.serial)
        channel.open()

    def close(self) -> None:
        """Release the motor and close the channel."""
        channel, self._channel = self._channel, None
        self.attached = False
        if channel is None:
            return
        for forget in (
            channel.setOnAttachHandler,
            channel.setOnDetachHandler,
            channel.setOnErrorHandler,
        ):
            with suppress(Exception):
                forget(None)
        with suppress(Exception):
            channel.close()

    def engage(self, value: float) -> None:
        """Hold the motor at ``value`` (-1 to 1 of its range)."""
        self.move(value)
        self.engaged = True
        self._call(self._channel.setEngaged, True)

    def move(self, value: float) -> None:
        """Send the motor to ``value`` (-1 to 1 of its range), unless that is its target already."""
        value = max(-1.0, min(1.0, -value if self._joint_channel.reverse else value))
        target = self._middle + self._range * value
        if target != self._target:
            self._call(self._channel.setTargetPosition, target)
            self._target = target

    def release(self) -> str:
        """Make the motor limp. An unplugged motor is limp.

        If it refuses, it is asked again; then its channel is closed and no longer fed, so that a
        failsafe releases it.

        Returns:
            Why it may not be limp, and what to do; empty if it is.
        """
        refusal = ""
        for _ in range(_TRIES if self.engaged and self.attached else 0):
            try:
                self._call(self._channel.setEngaged, False)
            except Exception as error:
                gone = getattr(error, "code", None) in (_NOT_ATTACHED, _FAILSAFE)
                refusal = "" if gone else describe(error)
            else:
                refusal = ""
            if not refusal:
                break
        self.engaged = False
        return refusal and self._abandon(refusal)

    def reopen(self) -> bool:
        """Reopen a channel that its failsafe released or that was closed. Returns True if it was.

        Called only when the channel is needed: a motor that could not be made limp is not fed until
        then.
        """
        if not self._needs_reopening:
            return False
        self._needs_reopening, self.trouble = False, ""
        try:
            self._channel.close()
            self._channel.open()
        except Exception as error:
            self.trouble = f"It cannot be opened again: {describe(error)}."
        return True

    def feed(self, now: int) -> None:
        """Send the failsafe its sign of life if one is due at ``now`` (ns)."""
        if self.attached and self.has_failsafe and now >= self._fed_at + FEED_MS * MS:
            self._fed_at = now
            with suppress(Exception):
                self._call(self._channel.resetFailsafe)

    def _abandon(self, refusal: str) -> str:
        """Close the channel of a motor that does not become limp, and stop feeding it."""
        closed = "its channel was closed"
        try:
            self._channel.close()
        except Exception:
            closed = "its channel could not be closed"
        failsafe = " Its failsafe releases it within some seconds." if self.has_failsafe else ""
        what = (
            f"The servo for {self.place} could not be made limp ({refusal}), and {closed}: "
            f"unplug it.{failsafe}"
        )
        self._mark_lost(what)
        return what

    def _call(self, function: Callable[..., None], *arguments: Any) -> None:
        try:
            function(*arguments)
        except Exception as error:
            if getattr(error, "code", None) == _FAILSAFE:
                self._mark_lost(_FAILSAFE_TEXT)
            elif getattr(error, "code", None) == _NOT_ATTACHED:
                self.attached = False
            raise

    def _on_attach(self, channel: Any) -> None:
        try:
            self._configure(channel)
        except Exception as error:
            self.trouble = f"It cannot be set up: {describe(error)}."
        else:
            self.trouble = ""
            self.engaged = False
            self.attached = True
        self._changed()

    def _configure(self, channel: Any) -> None:
        lowest, highest = sorted((channel.getMinPosition(), channel.getMaxPosition()))
        self._middle = (lowest + highest) / 2
        self._range = min(self._address.range_deg, (highest - lowest) / 2)
        speed = self._address.speed_deg_s
        _is_supported(lambda: channel.setSpeedRampingState(True))
        _is_supported(lambda: _set_within(channel, "VelocityLimit", speed))
        _is_supported(lambda: _set_within(channel, "Acceleration", _ACCELERATION * speed))
        channel.setTargetPosition(self._middle)
        self._target = self._middle
        self.model = (
            f"{channel.getDeviceName()} ({channel.getDeviceSKU()}), serial "
            f"{channel.getDeviceSerialNumber()}"
        )
        self.has_failsafe = self._failsafe and _is_supported(
            lambda: channel.enableFailsafe(max(FAILSAFE_MS, channel.getMinFailsafeTime()))
        )
        self._fed_at = 0

    def _on_detach(self, _channel: Any) -> None:
        self.attached = self.engaged = False
        self.trouble = ""
        self._changed()

    def _on_error(self, _channel: Any, code: int, description: str) -> None:
        if code == _FAILSAFE_EVENT:
            self._mark_lost(_FAILSAFE_TEXT)
        elif code == _CLEARED:
            self.trouble = ""
        else:
            self.trouble = f"It reports: {description.rstrip('.')}.{_ADVICE.get(code, '')}"
        self._changed()

    def _mark_lost(self, why: str) -> None:
        """Mark the channel as unusable until it is reopened."""
        self.trouble = why
        self.attached = self.engaged = False
        self._needs_reopening = True


def _set_within(channel: Any, what: str, value: float) -> None:
    lowest, highest = getattr(channel, f"getMin{what}")(), getattr(channel, f"getMax{what}")()
    getattr(channel, f"set{what}")(max(lowest, min(highest, value)))


def _is_supported(call: Callable[[], None]) -> bool:
    """Make a call that some controllers do not support. Returns False if this one does not."""
    try:
        call()
    except Exception as error:
        if getattr(error, "code", None) != _UNSUPPORTED:
            raise
        return False
    return True
