"""Messages of the link: MessagePack over Zenoh, and length-prefixed frames over the pipes to the
broker.

Input is never trusted: a message is decoded into exactly its type, or refused with a reason.
"""

import struct
from collections.abc import Iterable
from typing import IO, Annotated, Any, Literal, TypeVar

import msgspec

from sar_tui.link.peer import Frame, MotionTrace, Welcome
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import (
    COMMAND,
    DECISION,
    MODE,
    NOTE_ADDED,
    PROPOSAL_SEEN,
    PROTOCOL,
    PROTOCOL_TICKED,
    REASON,
    REMARK,
)
from sar_tui.model.messages import (
    ActAnswered,
    Message,
    NoteAdded,
    ProtocolChosen,
    SessionCommand,
)
from sar_tui.model.visible_text import obeyed

T = TypeVar("T")
M = TypeVar("M", bound=Message)

MAX_ACT_BYTES = 20_000
"""Longer messages from a peer are refused unread."""
MAX_NOTE_CHARS = 4_000
MAX_TEXT_CHARS = 1_000
"""For every text except a note: an utterance, the name of a phrase or of a mark."""
MAX_FRAME_BYTES = 16_000_000
"""Between the program and its broker; a snapshot carries a whole theme."""

OPERATOR_TOPICS: dict[str, Topic[Any]] = {
    topic.name: topic
    for topic in (
        COMMAND,
        DECISION,
        REMARK,
        MODE,
        PROPOSAL_SEEN,
        NOTE_ADDED,
        PROTOCOL,
        PROTOCOL_TICKED,
        REASON,
    )
}
"""Topics that an operator may publish on."""
TAKE_CONTROL = "baton"
"""Sent in place of a topic to take control of the session."""


class ProtocolError(ValueError):
    """A message is refused; the text says why in plain words, none of them the sender's."""


class _LinkMessage(msgspec.Struct, frozen=True, tag_field="is", tag=str.lower):
    """Base of the messages of the link itself."""


# --- from the session to its peers

EncodedFrame = tuple[int, int, str, msgspec.Raw]
"""Sequence number, time (ns), name of the topic, message."""


class Batch(_LinkMessage, frozen=True):
    """Messages of the bus, sent to all peers; ``number`` counts batches, so that a peer notices a
    missing one.
    """

    number: int
    frames: list[EncodedFrame]


class Snapshot(_LinkMessage, frozen=True):
    """State of the session after batch ``number``, sent to one peer."""

    number: int
    welcome: Welcome
    frames: list[EncodedFrame]


class MotionTraces(_LinkMessage, frozen=True):
    """Movement of the participants' hands, sent to all peers."""

    traces: list[MotionTrace]


class Pong(_LinkMessage, frozen=True):
    """Answer to a ``Ping``.

    ``ping_sent_at``: the ping's ``sent_at``. ``session_time``: when it was answered (ns), on the
    clock named by ``clock_id``. ``number``: of the last batch. ``client_id``: the program that is
    answered, as several may use one name. ``refusal``: why that program is not admitted.
    """

    ping_sent_at: int
    session_time: int
    clock_id: str
    number: int
    client_id: str
    refusal: str = ""


class Answers(_LinkMessage, frozen=True):
    """Answers to acts of one peer, sent to it alone: of those that were not let through, and of
    those that it asked for.
    """

    answers: list[ActAnswered]


class LinkClosed(_LinkMessage, frozen=True):
    """The session is over; sent to all peers."""


SessionMessage = Batch | Snapshot | MotionTraces | Pong | Answers | LinkClosed


# --- from a peer to the session


Silence = Annotated[int, msgspec.Meta(ge=0)] | None
"""Time since a peer's terminal last answered (ns); None if it never has."""
ActId = Annotated[str, msgspec.Meta(pattern=r"\A[0-9a-f]{0,32}\Z")]
"""Id of an act; empty for messages that are not answered."""
MAX_ASKED = 20
"""Number of acts whose answers a peer may ask for at once."""


class Ping(_LinkMessage, frozen=True):
    """Heartbeat of a peer.

    ``client_id``: a random id of the program. ``sent_at``: on its clock (ns). ``wants_snapshot``:
    the peer does not know the state of the session. ``is_leaving``: the peer is about to close.
    ``silence``, ``is_relayed``: of its terminal, see ``peer.TerminalState``. ``unanswered``: ids of
    acts for which the peer asks, because their answers may have been lost.
    """

    client_id: str
    sent_at: int
    wants_snapshot: bool = False
    is_leaving: bool = False
    silence: Silence = None
    is_relayed: bool = False
    unanswered: Annotated[tuple[ActId, ...], msgspec.Meta(max_length=MAX_ASKED)] = ()


class ActRequest(_LinkMessage, frozen=True):
    """An operator's message for one of ``OPERATOR_TOPICS``, or ``TAKE_CONTROL``; ``silence`` as in
    ``Ping``. ``id``: of the act, so that it can be answered unread.
    """

    client_id: str
    topic: str
    message: msgspec.Raw = msgspec.Raw(b"\xc0")
    silence: Silence = None
    id: ActId = ""


# --- from the program to its broker


class Setup(_LinkMessage, frozen=True):
    """First frame to the broker.

    ``settings``: from ``zenoh_settings.host_settings``. ``link``: its id. ``lost_after``: silence
    (ns) after which a peer is lost. ``guests``: those admitted over the network; None if it does
    not listen there. ``dials``: settings to connect with, in turn, if it is a visit: the broker
    does not listen, but connects to a router, again and again; and the participant is asked before
    anybody is admitted.
    """

    settings: str
    link: str
    lost_after: int
    guests: tuple[str, ...] | None = None
    dials: tuple[str, ...] = ()

    @property
    def is_visit(self) -> bool:
        """True if it connects to a router."""
        return bool(self.dials)


class Publish(_LinkMessage, frozen=True):
    """Send a payload, which is batch ``number``, to all peers."""

    number: int
    payload: bytes


class SendTo(_LinkMessage, frozen=True):
    """Send a payload to one peer."""

    name: str
    payload: bytes


class SensorSamples(_LinkMessage, frozen=True):
    """Sensor samples packed by ``motion.samples.pack``; the broker downsamples them for peers."""

    seat: str
    samples: bytes


class Admit(_LinkMessage, frozen=True):
    """The participant lets somebody watch, by the name, from now on."""

    name: str


class Deny(_LinkMessage, frozen=True):
    """The participant lets nobody watch, for the reason in ``why``, which those who ask are told;
    those who watch are no longer sent anything.
    """

    why: str


BrokerCommand = Setup | Publish | SendTo | SensorSamples | Admit | Deny


# --- from the broker to its program


class BrokerStarted(_LinkMessage, frozen=True):
    """The broker listens, or cannot: then ``error`` says why."""

    error: str = ""


class Heartbeat(_LinkMessage, frozen=True):
    """The broker is alive."""


class PeerJoined(_LinkMessage, frozen=True):
    """A peer was admitted."""

    name: str


class PeerLeft(_LinkMessage, frozen=True):
    """A peer ``left``, or was ``lost`` for the reason in ``detail``."""

    name: str
    state: Literal["left", "lost"]
    detail: str = ""


class PeerUnproven(_LinkMessage, frozen=True):
    """Nothing proves that a person's terminal is at an operator's panel; ``detail`` says why."""

    name: str
    detail: str


class VisitAsked(_LinkMessage, frozen=True):
    """Somebody asks to watch a session at home; ``withdrawn``: they do not any longer."""

    name: str
    withdrawn: bool = False


class SnapshotRequested(_LinkMessage, frozen=True):
    """A peer needs a snapshot."""

    name: str


class ActReceived(_LinkMessage, frozen=True):
    """An operator sent a valid act."""

    name: str
    topic: str
    message: msgspec.Raw
    id: str = ""


class AnswersRequested(_LinkMessage, frozen=True):
    """A peer asks what became of acts, by their ids."""

    name: str
    ids: tuple[str, ...]


class RequestRefused(_LinkMessage, frozen=True):
    """Requests of a peer were refused; ``count`` since the last report."""

    name: str
    what: str
    why: str
    count: int


BrokerEvent = (
    BrokerStarted
    | Heartbeat
    | PeerJoined
    | PeerLeft
    | PeerUnproven
    | VisitAsked
    | SnapshotRequested
    | ActReceived
    | AnswersRequested
    | RequestRefused
)

encode = msgspec.msgpack.encode
_decoders: dict[Any, msgspec.msgpack.Decoder[Any]] = {}


def decode(data: bytes, kind: Any) -> Any:
    """Decode a message of a type. Raises ProtocolError for anything else."""
    if kind not in _decoders:
        _decoders[kind] = msgspec.msgpack.Decoder(kind)
    try:
        return _decoders[kind].decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ProtocolError("It cannot be read.") from error


def encode_frames(records: Iterable[Record]) -> list[EncodedFrame]:
    """Encode messages of the bus."""
    return [
        (each.seq, each.at, each.topic.name, msgspec.Raw(encode(each.message))) for each in records
    ]


def decode_frames(encoded: Iterable[EncodedFrame], topics: dict[str, Topic[Any]]) -> list[Frame]:
    """Decode messages of the bus; those that only another version of the program knows are
    skipped.
    """
    found = []
    for seq, at, name, raw in encoded:
        if topic := topics.get(name):
            try:
                found.append(Frame(seq, at, topic, decode(bytes(raw), topic.type)))
            except ProtocolError:
                continue
    return found


def decode_act(topic: str, raw: msgspec.Raw) -> Message:
    """Decode and check an operator's act. Raises ProtocolError."""
    if topic not in OPERATOR_TOPICS:
        raise ProtocolError("An operator may not send it.")
    message: Message = decode(bytes(raw), OPERATOR_TOPICS[topic].type)
    for field in message.__struct_fields__:
        if isinstance(value := getattr(message, field), str):
            is_note = topic == NOTE_ADDED.name and field == "text"
            longest = MAX_NOTE_CHARS if is_note else MAX_TEXT_CHARS
            if len(value) > longest:
                raise ProtocolError(f"A text is longer than {longest} characters.")
            if obeyed(value, "\n\t" if is_note else ""):
                raise ProtocolError("A text contains control characters.")
    if (
        isinstance(message, SessionCommand)
        and message.command == "pause"
        and message.reason not in _PAUSE_REASONS
    ):
        raise ProtocolError("That is not a valid reason for a pause.")
    if isinstance(message, NoteAdded) and not (message.text.strip() or message.label.strip()):
        raise ProtocolError("A note is empty.")
    if isinstance(message, ProtocolChosen) and not message.protocol.is_showable:
        raise ProtocolError("A text contains control characters.")
    return message


_PAUSE_REASONS = ("", "tired", "pain", "finished")
"""Reasons that an operator may give; the session acts on others, such as a lost sensor, by
itself.
"""

_LENGTH = struct.Struct("<I")


def pack_frame(message: BrokerCommand | BrokerEvent) -> bytes:
    """Encode a message as a frame for a pipe."""
    body = encode(message)
    return _LENGTH.pack(len(body)) + body


def read_frame(pipe: IO[bytes], kind: Any) -> Any:
    """Return the next message of a pipe, or None at its end. Raises ProtocolError, OSError."""
    head = _read_exactly(pipe, _LENGTH.size)
    if head is None:
        return None
    (length,) = _LENGTH.unpack(head)
    if length > MAX_FRAME_BYTES:
        raise ProtocolError("A frame is too long.")
    body = _read_exactly(pipe, length)
    return None if body is None else decode(body, kind)


def _read_exactly(pipe: IO[bytes], length: int) -> bytes | None:
    """Return ``length`` bytes, or None if the pipe ends first."""
    parts: list[bytes] = []
    while length:
        if not (part := pipe.read(length)):
            return None
        parts.append(part)
        length -= len(part)
    return b"".join(parts)
