"""A panel's side of the link, with a line that only remembers in the place of Zenoh."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Record
from sar_tui.framework.parameters import TaskParameters, fields
from sar_tui.framework.topics import KEY, LEVEL, NOTE_ADDED
from sar_tui.link import client, protocol
from sar_tui.link.authority import Authority
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import Connection, Frame, MotionTrace, Peer, PeerEvent, Welcome
from sar_tui.link.protocol import ActRequest, Batch, LinkClosed, MotionTraces, Ping, Pong, Snapshot
from sar_tui.link.settings import Endpoint, Guest
from sar_tui.link.transport import Received
from tests.link.test_node import ABOUT, ANNA

HERE = JoinableSession(session="s1", task="keyboard", link="link", pid=1)
WELCOME: Welcome = msgspec.structs.replace(ABOUT, name=ANNA, role="operator")


class Transport:
    """In the place of a connection."""

    made: list["Transport"] = []

    def __init__(self, ways: object, name: str, arrived: Callable[[Received], object]) -> None:
        self.name, self.arrived = name, arrived
        self.pings: list[Ping] = []
        self.acts: list[ActRequest] = []
        self.is_closed = False
        self.made.append(self)

    def open(self) -> None: ...

    def send_ping(self, payload: bytes) -> None:
        self.pings.append(protocol.decode(payload, Ping))

    def send_act(self, payload: bytes) -> None:
        self.acts.append(protocol.decode(payload, ActRequest))

    def close(self, *, awaits_answer: bool) -> None:
        self.is_closed = True
        self.awaits_answer = awaits_answer

    def acknowledge(self) -> None:
        self.awaits_answer = False


class Panel:
    """A peer, and what it was told."""

    def __init__(self, where: JoinableSession | Invitation = HERE) -> None:
        self.heard: list[PeerEvent] = []
        loop = asyncio.get_running_loop()
        self.peer: Peer = client.connect(where, "anna", "operator", self.heard.append, loop)
        self.line = Transport.made[-1]

    async def arrives(self, *what: Received) -> None:
        for each in what:
            self.line.arrived(each)
        for _ in range(3):
            await asyncio.sleep(0)

    def pong(self, number: int = 0, refusal: str = "") -> Pong:
        """The answer to its first sign of life."""
        return Pong(0, 0, "elsewhere", number, self.line.pings[0].client_id, refusal)

    async def welcomed(self) -> None:
        await self.arrives(self.pong(), Snapshot(3, WELCOME, protocol.encode_frames([level(1)])))
        self.heard.clear()

    def levels(self) -> list[int]:
        frames = [frame for each in self.heard if isinstance(each, list) for frame in each]
        return [frame.message.level for frame in frames if isinstance(frame.message, m.LevelChanged)]

    def wants(self) -> bool:
        return self.line.pings[-1].wants_snapshot


def level(number: int) -> Record:
    return Record(number, number, LEVEL, m.LevelChanged(previous=0, level=number, reason="success"))


def batch(number: int) -> Batch:
    return Batch(number, protocol.encode_frames([level(number)]))


@pytest.fixture
async def panel(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(client, "Transport", Transport)
    monkeypatch.setattr(client, "connection_target", lambda where: where)
    panel = Panel()
    await panel.arrives()
    yield panel
    panel.peer.close()


async def test_it_is_connected_once_it_is_greeted_and_told_all_in_order(panel: Panel) -> None:
    assert panel.heard == [Connection("connecting")]
    assert panel.wants()
    await panel.arrives(
        panel.pong(), batch(2), Snapshot(3, WELCOME, protocol.encode_frames([level(1)])), batch(3), batch(4)
    )
    frames = [each for each in panel.heard if isinstance(each, list)]
    assert panel.heard[1:3] == [Connection("connected"), WELCOME]
    assert frames == [[Frame(*level(1))], [Frame(*level(4))]]  # what the greeting holds is not told again


async def test_when_a_batch_is_missing_nothing_more_is_told_until_all_is_told_anew(panel: Panel) -> None:
    await panel.welcomed()
    await panel.arrives(batch(5), batch(6))
    assert panel.levels() == []
    assert panel.wants()
    await panel.arrives(Snapshot(6, WELCOME, protocol.encode_frames([level(6)])), batch(7))
    assert panel.levels() == [6, 7]


async def test_a_pong_tells_of_a_batch_that_was_missed_though_none_follows(panel: Panel) -> None:
    await panel.welcomed()
    await panel.arrives(panel.pong(number=4), batch(5))
    assert panel.levels() == []


async def test_an_act_is_sent_as_it_is_while_there_is_a_link_and_else_not_at_all(panel: Panel) -> None:
    note = m.NoteAdded(text="well", at=panel.peer.now())
    panel.peer.send(NOTE_ADDED, note)
    assert panel.line.acts == []
    await panel.welcomed()
    panel.peer.send(NOTE_ADDED, note)
    panel.peer.take_control()
    sent = panel.line.acts
    assert [(act.topic, act.client_id) for act in sent] == [
        (topic, panel.line.pings[0].client_id) for topic in (NOTE_ADDED.name, protocol.TAKE_CONTROL)
    ]
    assert protocol.decode_act(sent[0].topic, sent[0].message) == note


async def test_what_is_no_act_cannot_be_sent(panel: Panel) -> None:
    with pytest.raises(ValueError, match="input/key"):
        panel.peer.send(KEY, m.KeyPressed(key="f", at=1))


async def test_a_link_that_breaks_is_lost_and_connected_again_when_it_is_greeted_anew(panel: Panel) -> None:
    await panel.welcomed()
    await panel.arrives(Connection("lost", "The connection broke."), batch(4))
    assert panel.heard == [Connection("lost", "The connection broke.")]
    await panel.arrives(Connection("connected"))
    assert panel.wants()
    await panel.arrives(panel.pong(), Snapshot(9, WELCOME, []))
    assert panel.heard[1:3] == [Connection("connected"), WELCOME]


async def test_why_there_is_no_link_yet_is_told_once(panel: Panel) -> None:
    await panel.arrives(*[Connection("connecting", "Nothing listens there.")] * 3)
    assert panel.heard[1:] == [Connection("connecting", "Nothing listens there.")]


async def test_who_is_not_let_in_is_told_why_and_another_program_of_that_name_is_not(panel: Panel) -> None:
    await panel.arrives(Pong(0, 0, "h", 0, "another", "The name is taken."))
    assert panel.heard == [Connection("connecting")]
    await panel.arrives(panel.pong(refusal="The name is taken."), Snapshot(1, WELCOME, []))  # which is the other's
    assert panel.heard[1:] == [Connection("connecting", "The name is taken.")]


async def test_traces_are_told_one_by_one(panel: Panel) -> None:
    await panel.welcomed()
    traces = [MotionTrace("A", 5, 50.0, (0.1, 0.2)), MotionTrace("B", 6, 50.0, (0.3,))]
    await panel.arrives(MotionTraces(traces))
    assert panel.heard == traces


async def test_a_session_of_this_machine_that_is_over_is_joined_again_when_it_is_resumed(panel: Panel) -> None:
    await panel.welcomed()
    await panel.arrives(LinkClosed(), batch(4), Connection("lost", "The connection broke."))
    assert [each.state for each in panel.heard if isinstance(each, Connection)] == ["ended"]
    assert panel.levels() == []
    assert not panel.line.is_closed
    await panel.arrives(Connection("connected"))
    assert panel.wants()
    await panel.arrives(panel.pong(), Snapshot(1, WELCOME, protocol.encode_frames([level(1)])))
    assert [each.state for each in panel.heard if isinstance(each, Connection)] == ["ended", "connected"]


async def test_with_an_invitation_a_session_that_is_over_is_away_for_good(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(client, "Transport", Transport)
    monkeypatch.setattr(client, "connection_target", lambda where: where)
    invitation = Authority.open_or_create(tmp_path).invite(Guest("anna", "operator"), [Endpoint("127.0.0.1", 7447)], 30)
    panel = Panel(invitation)
    await panel.arrives()
    await panel.welcomed()
    await panel.arrives(LinkClosed(), batch(4))
    assert [each.state for each in panel.heard if isinstance(each, Connection)] == ["ended"]
    assert panel.line.is_closed


async def test_who_closes_says_goodbye_and_waits_until_that_is_heard(panel: Panel) -> None:
    await panel.welcomed()
    panel.peer.close()
    panel.peer.close()
    *_, hello = panel.line.pings
    assert [hello.is_leaving for hello in panel.line.pings].count(True) == 1
    assert (panel.line.is_closed, panel.line.awaits_answer) == (True, True)
    await panel.arrives(Pong(hello.sent_at, 0, "h", 3, hello.client_id))
    assert not panel.line.awaits_answer


@pytest.mark.parametrize(
    ("name", "part"),
    [("anna", "anna"), ("jörg m.", "j-rg-m"), ("*/**", "somebody"), ("", "somebody"), ("x" * 99, "x" * 32)],
)
def test_a_name_is_a_part_of_a_key_whatever_it_is(name: str, part: str) -> None:
    assert client.to_key_part(name) == part


async def test_who_closes_without_a_link_waits_for_nothing(panel: Panel) -> None:
    panel.peer.close()
    assert (panel.line.is_closed, panel.line.awaits_answer) == (True, False)


def test_a_few_signs_of_life_come_within_the_shortest_silence_that_a_session_takes_for_a_loss() -> None:
    (lost,) = [field for field in fields(TaskParameters) if field.name == "operator_lost_ms"]
    assert lost.ge is not None
    assert lost.ge >= 3 * 1000 * client.PING_INTERVAL_S
