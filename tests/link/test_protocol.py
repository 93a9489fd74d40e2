"""Messages of the link survive a round trip, or are refused."""

import io

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.protocol import ProtocolError
from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ALL, COMMAND, DECISION, KEY, NOTE_ADDED, REMARK, TRIAL
from sar_tui.model import messages as m
from sar_tui.model.messages import Message

NOTE = m.NoteAdded(text="The left hand tires.\nSince trial 4.", at=5)


def raw(message: object) -> msgspec.Raw:
    """Encode a message as in an act."""
    return msgspec.Raw(protocol.encode(message))


def test_frame_round_trip() -> None:
    record = Record(7, 123_456_789_012, NOTE_ADDED, NOTE)
    sent = protocol.encode(protocol.Batch(1, protocol.encode_frames([record])))
    decoded = protocol.decode(sent, protocol.SessionMessage)
    (frame,) = protocol.decode_frames(decoded.frames, ALL)
    assert tuple(frame) == tuple(record)


def test_unknown_or_invalid_frames_are_skipped() -> None:
    frames = [
        (1, 1, "another/version", raw(NOTE)),
        (2, 2, TRIAL.name, raw(NOTE)),
        (3, 3, NOTE_ADDED.name, raw(NOTE)),
    ]
    assert [frame.seq for frame in protocol.decode_frames(frames, ALL)] == [3]


@pytest.mark.parametrize(
    ("topic", "message", "why"),
    [
        (KEY.name, m.KeyPressed(key="f", at=1), "An operator may not send it"),
        ("no/topic", NOTE, "An operator may not send it"),
        (DECISION.name, NOTE, "cannot be read"),
        (NOTE_ADDED.name, {"text": 5}, "cannot be read"),
        (NOTE_ADDED.name, m.NoteAdded(text="x" * 4001), "longer than 4000 characters"),
        (REMARK.name, m.Remark(text="x" * 1001), "longer than 1000 characters"),
        (REMARK.name, m.Remark(text="red \x1b[31m"), "control characters"),
        (REMARK.name, m.Remark(text="one line\nand another"), "control characters"),
        (REMARK.name, m.Remark(text="turned \u202e round"), "control characters"),
        (NOTE_ADDED.name, m.NoteAdded(text="bell \a"), "control characters"),
        (NOTE_ADDED.name, m.NoteAdded(actor="\0"), "control characters"),
        (NOTE_ADDED.name, m.NoteAdded(), "A note is empty"),
        (NOTE_ADDED.name, m.NoteAdded(text=" \n", label=" "), "A note is empty"),
        (COMMAND.name, m.SessionCommand(command="pause", reason="sensor"), "not a valid reason"),
    ],
)
def test_invalid_act_is_refused_with_a_reason(topic: str, message: Message, why: str) -> None:
    with pytest.raises(ProtocolError, match=why):
        protocol.decode_act(topic, raw(message))


@pytest.mark.parametrize("text", ["¿Qué tal? Très bien, größer: 好", "👍🏽 👩‍🔬"])
def test_text_of_any_language_is_accepted(text: str) -> None:
    assert protocol.decode_act(REMARK.name, raw(m.Remark(text=text))) == m.Remark(text=text)


def test_a_deeply_nested_message_is_refused() -> None:
    with pytest.raises(ProtocolError):
        protocol.decode(b"\x91" * 19_000 + b"\xc0", protocol.ActRequest)


@pytest.mark.parametrize("cut_off", [0, 1])
def test_frames_on_a_pipe_are_read_one_by_one_until_it_ends_even_within_one(cut_off: int) -> None:
    parts = [
        protocol.Heartbeat(),
        protocol.PeerJoined("operator.anna"),
        protocol.BrokerStarted("no"),
    ]
    data = b"".join(map(protocol.pack_frame, parts))
    pipe = io.BytesIO(data[: len(data) - cut_off])
    for part in parts[: 3 - cut_off]:
        assert protocol.read_frame(pipe, protocol.BrokerEvent) == part
    assert protocol.read_frame(pipe, protocol.BrokerEvent) is None


def test_a_frame_of_an_impossible_length_is_refused_unread() -> None:
    with pytest.raises(ProtocolError, match="too long"):
        protocol.read_frame(io.BytesIO(b"\xff\xff\xff\xff"), protocol.BrokerEvent)
