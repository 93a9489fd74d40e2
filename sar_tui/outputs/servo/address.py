"""Wiring of a servo output, as written after ``servo:`` in settings."""

import re
from typing import Annotated, NamedTuple
from urllib.parse import parse_qsl

import msgspec
from msgspec import Meta

from sar_tui.model.gesture import JOINTS
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
