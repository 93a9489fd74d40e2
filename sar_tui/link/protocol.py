"""What crosses the link, as bytes: MessagePack over Zenoh, and in frames with a length over the pipes to the broker.

Nothing here trusts what it reads: a message is decoded into exactly its type, or it is refused in words.
"""

import struct
import unicodedata
from collections.abc import Iterable
from typing import IO, Any, Literal, TypeVar

import msgspec

from sar_tui.framework.bus import Record, Topic
from sar_tui.framework.messages import Message, Operator
from sar_tui.framework.topics import DECISION, MODE, NOTE_ADDED, OPERATOR, PROPOSAL_SEEN, REMARK
from sar_tui.link.peer import Frame, MotionTrace, Welcome

T = TypeVar("T")
M = TypeVar("M", bound=Message)

MAX_ACT_BYTES = 20_000
"""Bytes of a message from a peer; more are refused unread."""
MAX_NOTE_CHARS = 4_000
MAX_TEXT_CHARS = 1_000
"""Characters of a note; and of any other text: words to be said, the name of a phrase or of a mark."""
MAX_FRAME_BYTES = 16_000_000
"""Bytes between the program and its broker; a greeting carries a whole theme."""

OPERATOR_TOPICS: dict[str, Topic[Any]] = {
    topic.name: topic for topic in (OPERATOR, DECISION, REMARK, MODE, PROPOSAL_SEEN, NOTE_ADDED)
}
"""What an operator may send."""
TAKE_CONTROL = "baton"
"""In the place of a topic: an operator takes the baton."""


class ProtocolError(ValueError):
    """What came cannot be taken; ``why`` in a few plain words, none of them the sender's."""


class _LinkMessage(msgspec.Struct, frozen=True, tag_field="is", tag=str.lower):
    """One message of the link itself."""


# --- from the session to its peers ---------------------------------------------------------------------------

EncodedFrame = tuple[int, int, str, msgspec.Raw]
"""A frame as it crosses: number, time, name of the topic, message."""


class Batch(_LinkMessage, frozen=True):
    """What happened, to everybody. ``number`` counts batches, so that a peer sees when one is missing."""

    number: int
    frames: list[EncodedFrame]


class Snapshot(_LinkMessage, frozen=True):
    """How things stand, to one peer: all that happened up to batch ``number``, as far as it matters now."""

    number: int
    welcome: Welcome
    frames: list[EncodedFrame]


class MotionTraces(_LinkMessage, frozen=True):
    """How hands move, to everybody."""

    traces: list[MotionTrace]


class Pong(_LinkMessage, frozen=True):
    """The answer to a Ping. ``ping``: as it came. ``clock``: the session's, when it was answered (ns).

    ``host``: on which machine's clock that is. ``number``: of the last batch. ``who``: whom it answers, of several
    that have a name. ``refusal``: why that one is not let in.
    """

    ping: int
    clock: int
    host: str
    number: int
    who: str
    refusal: str = ""


class LinkClosed(_LinkMessage, frozen=True):
    """The session is over, to everybody."""


SessionMessage = Batch | Snapshot | MotionTraces | Pong | LinkClosed


# --- from a peer to the session ------------------------------------------------------------------------------


class Ping(_LinkMessage, frozen=True):
    """A sign of life. ``who`` is the program's own id; ``ping`` its clock (ns).

    ``wants``: it has to be told how things stand. ``leaves``: it is going.
    """

    who: str
    ping: int
    wants: bool = False
    leaves: bool = False


class ActRequest(_LinkMessage, frozen=True):
    """What an operator does: ``topic`` is one of ``OPERATOR_TOPICS``, or ``TAKE_CONTROL``."""

    who: str
    topic: str
    message: msgspec.Raw = msgspec.Raw(b"\xc0")


# --- from the program to its broker --------------------------------------------------------------------------


class Setup(_LinkMessage, frozen=True):
    """The first frame. ``settings``: as `settings.host_settings` makes them. ``link``: its id.

    ``patience``: a peer that was silent for so long (ns) is lost. ``guests``: who may come over the network; None
    where it does not listen there.
    """

    settings: str
    link: str
    patience: int
    guests: tuple[str, ...] | None = None


class Publish(_LinkMessage, frozen=True):
    """Send this to everybody; it is a Batch of that number."""

    number: int
    payload: bytes


class SendTo(_LinkMessage, frozen=True):
    """Send this to one peer."""

    name: str
    payload: bytes


class SensorSamples(_LinkMessage, frozen=True):
    """A sensor's samples, as `motion.samples.pack` lays them out: peers are sent what an eye can follow of them."""

    seat: str
    samples: bytes


BrokerCommand = Setup | Publish | SendTo | SensorSamples


# --- from the broker to its program --------------------------------------------------------------------------


class BrokerStarted(_LinkMessage, frozen=True):
    """It listens; or it does not: ``why``."""

    why: str = ""


class Heartbeat(_LinkMessage, frozen=True):
    """The broker lives."""


class PeerJoined(_LinkMessage, frozen=True):
    """A peer is there."""

    name: str


class PeerLeft(_LinkMessage, frozen=True):
    """A peer is not there any more: ``left``, or ``lost`` for a reason."""

    name: str
    state: Literal["left", "lost"]
    detail: str = ""


class SnapshotRequested(_LinkMessage, frozen=True):
    """A peer has to be greeted."""

    name: str


class ActReceived(_LinkMessage, frozen=True):
    """An operator's act, looked at and found well."""

    name: str
    topic: str
    message: msgspec.Raw


class RequestRefused(_LinkMessage, frozen=True):
    """What a peer sent was refused, so often since it was last told."""

    name: str
    what: str
    why: str
    count: int


BrokerEvent = BrokerStarted | Heartbeat | PeerJoined | PeerLeft | SnapshotRequested | ActReceived | RequestRefused

encode = msgspec.msgpack.encode
_decoders: dict[Any, msgspec.msgpack.Decoder[Any]] = {}


def decode(data: bytes, kind: Any) -> Any:
    """Read a message of a type. Raises WireError for anything else."""
    if kind not in _decoders:
        _decoders[kind] = msgspec.msgpack.Decoder(kind)
    try:
        return _decoders[kind].decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ProtocolError("It cannot be read.") from error


def encode_frames(records: Iterable[Record]) -> list[EncodedFrame]:
    """Messages of the bus, ready to cross."""
    return [(each.seq, each.at, each.topic.name, msgspec.Raw(encode(each.message))) for each in records]


def decode_frames(crossed: Iterable[EncodedFrame], topics: dict[str, Topic[Any]]) -> list[Frame]:
    """The inverse. What another version of the program alone knows is left out."""
    found = []
    for seq, at, name, raw in crossed:
        if topic := topics.get(name):
            try:
                found.append(Frame(seq, at, topic, decode(bytes(raw), topic.type)))
            except ProtocolError:
                continue
    return found


def decode_act(topic: str, raw: msgspec.Raw) -> Message:
    """An operator's act, decoded into its type and looked at. Raises WireError."""
    if topic not in OPERATOR_TOPICS:
        raise ProtocolError("It is not among what an operator may send.")
    message: Message = decode(bytes(raw), OPERATOR_TOPICS[topic].type)
    for field in message.__struct_fields__:
        if isinstance(value := getattr(message, field), str):
            is_note = topic == NOTE_ADDED.name and field == "text"
            most = MAX_NOTE_CHARS if is_note else MAX_TEXT_CHARS
            if len(value) > most:
                raise ProtocolError(f"A text is longer than {most} characters.")
            if not all(_is_plain(each) for each in value if not (is_note and each in "\n\t")):
                raise ProtocolError("A text holds control characters.")
    if isinstance(message, Operator) and message.command == "pause" and message.reason not in _PAUSES:
        raise ProtocolError("That is no reason for a pause.")
    return message


def _is_plain(character: str) -> bool:
    """No control character, and nothing that turns the direction of the text around it."""
    return unicodedata.category(character) not in ("Cc", "Cs", "Zl", "Zp") and character not in _TURNS


_TURNS = "".join(map(chr, (*range(0x202A, 0x202F), *range(0x2066, 0x206A))))

_PAUSES = ("", "tired", "pain", "finished")
"""What an operator can say of a pause: other reasons are the session's own, and it acts on them."""

_LENGTH = struct.Struct("<I")


def pack_frame(part: BrokerCommand | BrokerEvent) -> bytes:
    """A frame for a pipe."""
    body = encode(part)
    return _LENGTH.pack(len(body)) + body


def read_frame(pipe: IO[bytes], kind: Any) -> Any:
    """The next frame of a pipe, or None at its end. Raises WireError for one that is none; OSError."""
    head = _exactly(pipe, _LENGTH.size)
    if head is None:
        return None
    (length,) = _LENGTH.unpack(head)
    if length > MAX_FRAME_BYTES:
        raise ProtocolError("A frame is too long.")
    body = _exactly(pipe, length)
    return None if body is None else decode(body, kind)


def _exactly(pipe: IO[bytes], length: int) -> bytes | None:
    """So many bytes; None if the pipe ends before."""
    parts: list[bytes] = []
    while length:
        if not (part := pipe.read(length)):
            return None
        parts.append(part)
        length -= len(part)
    return b"".join(parts)
