"""Damaged and forged messages: none ends the link, none lets an observer act, and what is taken is
what was meant.
"""

import io
import random
from collections.abc import Callable

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.protocol import ActReceived, PeerJoined, Ping, ProtocolError
from sar_tui.loop.bus import Record
from sar_tui.loop.topics import (
    ALL,
    COMMAND,
    DECISION,
    LEVEL,
    MODE,
    NOTE_ADDED,
    PRESENCE,
    PROPOSAL_SEEN,
    PROTOCOL,
    PROTOCOL_TICKED,
    REASON,
    REMARK,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import Message
from sar_tui.model.protocol import ProtocolStep, WizardProtocol
from sar_tui.model.units import MS
from tests.examples import fewer, first
from tests.link.test_admission import ANNA, OLAF
from tests.link.test_admission import Bench as AdmissionBench
from tests.link.test_node import Bench as NodeBench

FRAMES = fewer(10_000)
WIZARD_PROTOCOL = WizardProtocol("p", 1, "ab", steps=(ProtocolStep("start", "say greeting"),))
ACTS: tuple[tuple[str, Message], ...] = (
    (COMMAND.name, m.SessionCommand(command="pause", reason="tired", at=5)),
    (COMMAND.name, m.SessionCommand(command="level", value=3, at=5)),
    (
        DECISION.name,
        m.Decision(action="a1", verdict="edit", text="Well done.", valence="positive", at=5),
    ),
    (REMARK.name, m.Remark(text="Keep on like this.", source="free text", at=5)),
    (MODE.name, m.ModeChanged(kind="feedback", mode="veto", at=5)),
    (PROPOSAL_SEEN.name, m.ProposalSeen(action="a1", at=5)),
    (NOTE_ADDED.name, m.NoteAdded(text="rubs the left wrist", at=5)),
    (PROTOCOL.name, m.ProtocolChosen(protocol=WIZARD_PROTOCOL, at=5)),
    (PROTOCOL_TICKED.name, m.ProtocolTicked(due="d1", outcome="done", at=5)),
    (REASON.name, m.ReasonGiven(action="a1", verdict="veto", digit=1, text="technical", at=5)),
)


def valid_acts() -> list[bytes]:
    acts = [
        protocol.ActRequest("1", topic, msgspec.Raw(protocol.encode(act)), 7 * MS)
        for topic, act in ACTS
    ]
    return [
        protocol.encode(each) for each in (*acts, protocol.ActRequest("1", protocol.TAKE_CONTROL))
    ]


def valid_pings() -> list[bytes]:
    pings = (
        Ping("1", 77),
        Ping("1", 77, wants_snapshot=True, silence=7 * MS),
        Ping("2", 77, is_leaving=True),
    )
    return [protocol.encode(each) for each in pings]


def mutated(data: bytes, others: list[bytes], rng: random.Random) -> bytes:
    """Return a message with one to four faults: bits flipped, bytes lost, doubled, inserted, or of
    another message.
    """
    found = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(found) + 1)
        length = rng.randint(1, 8)
        fault = rng.randrange(6)
        if fault == 0 and found:
            found[at % len(found)] ^= 1 << rng.randrange(8)
        elif fault == 1:
            del found[at : at + length]
        elif fault == 2:
            found[at:at] = found[at : at + length]
        elif fault == 3:
            found[at:at] = rng.randbytes(length)
        elif fault == 4:
            found[at : at + length] = rng.randbytes(length)
        else:
            found[at:] = rng.choice(others)[at:]
    return bytes(found)


def names(rng: random.Random) -> str:
    """Return the name of a peer, or what somebody might send in its place."""
    forged = (
        "operator.",
        "director.anna",
        "operator.anna/x",
        "observer.olaf\n",
        "operator.\x1b[31m",
        "",
        "*",
        "o" * 500,
    )
    return rng.choice((ANNA, OLAF, OLAF, rng.choice(forged)))


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_no_mutated_message_of_a_peer_ends_the_link_or_lets_an_observer_act(seed: int) -> None:
    rng = random.Random(seed)
    gate, session = AdmissionBench(), NodeBench()
    acts, pings = valid_acts(), valid_pings()
    everything = [*acts, *pings]
    session.receive(PeerJoined(ANNA), PeerJoined(OLAF))
    taken = 0
    for number in range(FRAMES):
        now = number * 100 * MS  # slow enough for none to be refused as too many
        name = names(rng)
        if rng.random() < 0.7:
            gate.admission.receive_act(name, mutated(rng.choice(acts), everything, rng), now)
        else:
            gate.admission.receive_ping(name, mutated(rng.choice(pings), everything, rng), now)
        gate.admission.tick(now)
        for event in gate.take():
            if isinstance(event, ActReceived):
                taken += 1
                assert event.name.startswith("operator.")
                assert event.topic in (*protocol.OPERATOR_TOPICS, protocol.TAKE_CONTROL)
                session.receive(event)
    assert taken, "some faults leave a message that can be read"
    published = [
        record for record in session.records if record.topic.name in protocol.OPERATOR_TOPICS
    ]
    assert published
    assert {record.message.actor for record in published} == {ANNA}
    assert {type(record.message) for record in published} <= {
        topic.type for topic in protocol.OPERATOR_TOPICS.values()
    }
    assert OLAF not in {each.holder for each in session.of(PRESENCE)}
    session.node.detach()


def _level(number: int) -> Record:
    return Record(number, number, LEVEL, m.LevelChanged(previous=0, level=number, reason="success"))


def _read_pipe(data: bytes) -> None:
    pipe = io.BytesIO(data)
    while protocol.read_frame(pipe, protocol.BrokerEvent) is not None:
        pass


def _read_batch(data: bytes) -> None:
    received = protocol.decode(data, protocol.SessionMessage)
    protocol.decode_frames(getattr(received, "frames", ()), ALL)


FROM_SESSION = [
    protocol.encode(each)
    for each in (
        protocol.Batch(3, protocol.encode_frames([_level(1), _level(2)])),
        protocol.Pong(77, 5, "here", 3, "1"),
        protocol.Answers([m.ActAnswered(id="1", actor=ANNA, outcome="done", at=5)]),
        protocol.LinkClosed(),
    )
]
FROM_BROKER = [
    b"".join(
        map(
            protocol.pack_frame,
            (protocol.Heartbeat(), PeerJoined(ANNA), protocol.PeerLeft(ANNA, "lost", "x")),
        )
    ),
    protocol.pack_frame(protocol.PeerUnproven(ANNA, "x")),
]


@pytest.mark.parametrize(
    ("valid", "read"), [(FROM_SESSION, _read_batch), (FROM_BROKER, _read_pipe)]
)
def test_mutated_messages_of_a_session_or_a_broker_are_read_or_refused(
    valid: list[bytes], read: Callable[[bytes], None]
) -> None:
    rng = random.Random(7)
    for _ in range(FRAMES):
        try:
            read(mutated(rng.choice(valid), valid, rng))
        except ProtocolError:
            continue
