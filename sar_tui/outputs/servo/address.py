"""How a servo is wired, as it is written after ``servo:`` in settings."""

import re
from typing import Annotated, NamedTuple
from urllib.parse import parse_qsl

import msgspec
from msgspec import Meta

from sar_tui.framework.gesture import JOINTS
from sar_tui.outputs.output import OutputError

_CHANNEL = re.compile("-?[0-9]{1,2}")
_HOW = (
    "Say servo, or servo:SERIAL?right_arm=0&left_arm=-1: joints are "
    f"{', '.join(JOINTS[:-1])} and {JOINTS[-1]}, each with its channel on the controller (with - before it, the joint "
    "moves the other way); range=45 is how many degrees it moves to either side (5 to 90), speed=180 how many a second "
    "(30 to 360)."
)


class Wire(NamedTuple):
    """A joint, the controller's channel that moves it, and whether it moves the other way round."""

    joint: str
    channel: int
    reverse: bool


class ServoAddress(NamedTuple):
    """Which controller (``serial``: any if None), which joints, and how far and fast they may move.

    ``range_deg``: degrees to either side of the middle. ``speed_deg_s``: degrees a second, never more.
    """

    serial: int | None
    wires: tuple[Wire, ...]
    range_deg: float
    speed_deg_s: float


class _Options(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What may follow the question mark."""

    nod: str = ""
    turn: str = ""
    left_arm: str = ""
    right_arm: str = ""
    lean: str = ""
    range: Annotated[float, Meta(ge=5, le=90)] = 45.0
    speed: Annotated[float, Meta(ge=30, le=360)] = 180.0


def parse(text: str) -> ServoAddress:
    """What follows ``servo:``; nothing means the right arm on channel 0 of whichever controller is plugged in.

    Raises OutputError, saying what may stand there.
    """
    serial, _, query = text.partition("?")
    try:
        if serial and not (serial.isascii() and serial.isdigit()):
            raise ValueError(f'"{serial}" is no serial number')
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query))
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a name stands there twice")
        options = msgspec.convert(dict(pairs), _Options, strict=False)
        wires = tuple(_wire(joint, getattr(options, joint)) for joint in JOINTS if joint in dict(pairs))
        if len({wire.channel for wire in wires}) < len(wires):
            raise ValueError("two joints have the same channel")
    except (ValueError, msgspec.ValidationError) as error:
        raise OutputError(f"There is no output servo:{text} ({error}). {_HOW}") from error
    return ServoAddress(
        serial=int(serial) if serial else None,
        wires=wires or (Wire("right_arm", 0, reverse=False),),
        range_deg=options.range,
        speed_deg_s=options.speed,
    )


def _wire(joint: str, channel: str) -> Wire:
    if not _CHANNEL.fullmatch(channel):
        raise ValueError(f'{joint} needs the number of a channel, not "{channel}"')
    return Wire(joint, abs(int(channel)), channel.startswith("-"))
