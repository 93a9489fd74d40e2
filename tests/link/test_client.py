"""Panel's side of the link, with a fake transport."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.link import client, protocol
from sar_tui.link.authority import Authority
from sar_tui.link.client import Received
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import (
    Connection,
    Frame,
    MotionTrace,
    Peer,
    PeerEvent,
    TerminalState,
    Welcome,
)
from sar_tui.link.protocol import (
    ActRequest,
    Answers,
    Batch,
    LinkClosed,
    MotionTraces,
    Ping,
    Pong,
    Snapshot,
)
from sar_tui.link.remote_clock import RemoteClock
from sar_tui.link.zenoh_settings import Endpoint, Guest
from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ANSWERED, KEY, LEVEL, NOTE_ADDED
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.parameters import TaskParameters, fields
from tests.link.test_node import ANNA
from tests.link.test_node import WELCOME as BASE_WELCOME

HERE = JoinableSession(session="s1", task="keyboard", link="link", pid=1)
WELCOME: Welcome = msgspec.structs.replace(BASE_WELCOME, name=ANNA, role="operator")


class FakeTransport:
    """Fake transport that records what is sent."""

    made: list["FakeTransport"] = []

    def __init__(self, target: object, name: str, on_receive: Callable[[Received], object]) -> None:
        self.name, self.on_receive = name, on_receive
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
    """Peer that records its events."""

    def __init__(self, where: JoinableSession | Invitation = HERE) -> None:
        self.events: list[PeerEvent] = []
        self.hours = 0
        loop = asyncio.get_running_loop()
        self.peer: Peer = client.connect(where, "anna", "operator", self.events.append, loop)
        self.transport = FakeTransport.made[-1]

    async def receive(self, *messages: Received) -> None:
        for each in messages:
            self.transport.on_receive(each)
        for _ in range(3):
            await asyncio.sleep(0)

    def pong(self, number: int = 0, refusal: str = "") -> Pong:
        """Return the answer to its first ping."""
        return Pong(0, 0, "elsewhere", number, self.transport.pings[0].client_id, refusal)

    async def connect(self) -> None:
        await self.receive(self.pong(), Snapshot(3, WELCOME, protocol.encode_frames([level(1)])))
        self.events.clear()

    def levels(self) -> list[int]:
        return [each.level for each in self.messages() if isinstance(each, m.LevelChanged)]

    def messages(self) -> list[Any]:
        frames = [frame for each in self.events if isinstance(each, list) for frame in each]
        return [frame.message for frame in frames]

    def states(self) -> list[str]:
        return [each.state for each in self.events if isinstance(each, Connection)]

    def wants_snapshot(self) -> bool:
        return self.transport.pings[-1].wants_snapshot


def level(number: int) -> Record:
    return Record(number, number, LEVEL, m.LevelChanged(previous=0, level=number, reason="success"))


def batch(number: int) -> Batch:
    return Batch(number, protocol.encode_frames([level(number)]))


@pytest.fixture
async def panel(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(client, "Transport", FakeTransport)
    monkeypatch.setattr(
        client, "connection_target", lambda where: client.ConnectionTarget(where.link, ())
    )
    panel = Panel()
    host_now = client.host_now
    monkeypatch.setattr(client, "host_now", lambda: host_now() + panel.hours * 3600 * SECOND)
    await panel.receive()
    yield panel
    panel.peer.close()


async def test_snapshot_connects_and_messages_follow_in_order(panel: Panel) -> None:
    assert panel.events == [Connection("connecting")]
    assert panel.wants_snapshot()
    await panel.receive(
        panel.pong(),
        batch(2),
        Snapshot(3, WELCOME, protocol.encode_frames([level(1)])),
        batch(3),
        batch(4),
    )
    frames = [each for each in panel.events if isinstance(each, list)]
    assert panel.events[1:3] == [Connection("connected"), WELCOME]
    # batches within the snapshot are skipped
    assert frames == [[Frame(*level(1))], [Frame(*level(4))]]


@pytest.mark.parametrize("is_last", [False, True])
async def test_missing_batch_stops_messages_until_a_snapshot(panel: Panel, is_last: bool) -> None:
    await panel.connect()
    # nothing follows the last one, but the answer to a ping tells its number
    await panel.receive(panel.pong(number=4) if is_last else batch(5), batch(6))
    assert panel.levels() == []
    if is_last:
        await panel.receive(Connection("connected"))  # a ping follows
    assert panel.wants_snapshot()
    await panel.receive(Snapshot(6, WELCOME, protocol.encode_frames([level(6)])), batch(7))
    assert panel.levels() == [6, 7]


async def test_act_is_sent_only_while_connected_and_with_the_silence_of_the_terminal(
    panel: Panel,
) -> None:
    note = m.NoteAdded(text="well", at=panel.peer.now())
    panel.peer.send(NOTE_ADDED, note)
    assert panel.transport.acts == []
    assert panel.transport.pings[-1].silence is None
    panel.peer.watch_terminal(lambda: TerminalState(7, is_relayed=True))
    await panel.connect()
    await panel.receive(Connection("connected"))
    ping = panel.transport.pings[-1]
    assert (ping.silence, ping.is_relayed) == (7, True)
    panel.peer.send(NOTE_ADDED, note)
    panel.peer.take_control()
    sent = panel.transport.acts
    assert [(act.topic, act.silence) for act in sent] == [
        (NOTE_ADDED.name, 7),
        (protocol.TAKE_CONTROL, 7),
    ]
    assert {act.client_id for act in sent} == {panel.transport.pings[0].client_id}
    assert protocol.decode_act(sent[0].topic, sent[0].message) == note
    with pytest.raises(ValueError, match="input/key"):
        panel.peer.send(KEY, m.KeyPressed(key="f", at=1))


# --- answers


async def send_note(panel: Panel, id: str) -> None:
    """Send a note that is not answered in time."""
    panel.peer.send(NOTE_ADDED, m.NoteAdded(id=id, text="well"))
    panel.hours += 1
    await panel.receive(Connection("connected"))  # a ping follows


def answer(id: str, outcome: m.ActOutcome = "done") -> m.ActAnswered:
    return m.ActAnswered(id=id, actor=ANNA, outcome=outcome, at=5)


async def test_an_act_that_is_not_answered_is_asked_for(panel: Panel) -> None:
    await panel.connect()
    panel.peer.send(NOTE_ADDED, m.NoteAdded(id="a1", text="well"))
    assert panel.transport.acts[-1].id == "a1"
    await panel.receive(Connection("connected"))
    assert panel.transport.pings[-1].unanswered == (), "not at once"
    await send_note(panel, "a2")
    assert panel.transport.pings[-1].unanswered == ("a1", "a2")
    await panel.receive(Connection("connected"))
    assert panel.transport.pings[-1].unanswered == (), "not with each ping"
    answered = Record(9, 9, ANSWERED, answer("a1"))
    await panel.receive(
        Batch(4, protocol.encode_frames([answered])),
        Answers([answer("a2", "refused"), answer("ff")]),
    )
    # another program of this name sent ff
    assert panel.messages() == [answer("a1"), answer("a2", "refused")]
    await send_note(panel, "a3")
    assert panel.transport.pings[-1].unanswered == ("a3",)


@pytest.mark.parametrize(("run", "asked"), [("1", ("a1",)), ("2", ())])
async def test_after_a_loss_answers_are_asked_for_unless_the_program_was_started_again(
    panel: Panel, run: str, asked: tuple[str, ...]
) -> None:
    first = msgspec.structs.replace(WELCOME, run="1")
    await panel.receive(panel.pong(), Snapshot(3, first, []))
    await send_note(panel, "a1")
    await panel.receive(Connection("lost", "The connection broke."))
    panel.hours += 1
    await panel.receive(Connection("connected"))
    assert panel.transport.pings[-1].unanswered == ()
    await panel.receive(panel.pong(), Snapshot(9, msgspec.structs.replace(first, run=run), []))
    await panel.receive(Connection("connected"))
    assert panel.transport.pings[-1].unanswered == asked


@pytest.mark.parametrize("end", ["terminal silent", "link lost", "session over"])
async def test_a_panel_on_this_machine_shows_the_present_state_when_it_is_back(
    panel: Panel, end: str
) -> None:
    await panel.connect()
    if end == "terminal silent":
        await panel.receive(panel.pong(refusal="The terminal does not answer."), batch(4))
        assert panel.events == [Connection("connecting", "The terminal does not answer.")]
    elif end == "link lost":
        await panel.receive(Connection("lost", "The connection broke."), batch(4))
        assert panel.events == [Connection("lost", "The connection broke.")]
    else:
        await panel.receive(LinkClosed(), batch(4), Connection("lost", "The connection broke."))
        assert panel.states() == ["ended"]
        assert panel.levels() == []
        assert not panel.transport.is_closed
    if end != "terminal silent":
        await panel.receive(Connection("connected"))
        assert panel.wants_snapshot()
    await panel.receive(panel.pong(), Snapshot(9, WELCOME, protocol.encode_frames([level(9)])))
    assert panel.events[1:3] == [Connection("connected"), WELCOME]
    assert panel.levels() == [9]


async def test_reason_for_no_connection_is_reported_once_and_to_the_program_it_is_for(
    panel: Panel,
) -> None:
    await panel.receive(Pong(0, 0, "h", 0, "another", "The name is taken."))
    assert panel.events == [Connection("connecting")]
    await panel.receive(*[Connection("connecting", "Nothing listens there.")] * 3)
    await panel.receive(panel.pong(refusal="The name is taken."), Snapshot(1, WELCOME, []))
    assert panel.events[1:] == [
        Connection("connecting", "Nothing listens there."),
        Connection("connecting", "The name is taken."),
    ]


async def test_traces_are_delivered_one_by_one(panel: Panel) -> None:
    await panel.connect()
    traces = [MotionTrace("A", 5, 50.0, (0.1, 0.2)), MotionTrace("B", 6, 50.0, (0.3,))]
    await panel.receive(MotionTraces(traces))
    assert panel.events == traces


async def test_by_invitation_a_session_that_is_over_is_not_rejoined(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(client, "Transport", FakeTransport)
    monkeypatch.setattr(
        client, "connection_target", lambda where: client.ConnectionTarget(where.link, ())
    )
    invitation = Authority.open_or_create(tmp_path).invite(
        Guest("anna", "operator"), [Endpoint("127.0.0.1", 7447)], 30
    )
    panel = Panel(invitation)
    await panel.receive()
    await panel.connect()
    await panel.receive(LinkClosed(), batch(4))
    assert panel.states() == ["ended"]
    assert panel.transport.is_closed


async def test_close_says_goodbye_and_waits_for_the_answer(panel: Panel) -> None:
    await panel.connect()
    panel.peer.close()
    panel.peer.close()
    *_, ping = panel.transport.pings
    assert [each.is_leaving for each in panel.transport.pings].count(True) == 1
    assert (panel.transport.is_closed, panel.transport.awaits_answer) == (True, True)
    await panel.receive(Pong(ping.sent_at, 0, "h", 3, ping.client_id))
    assert not panel.transport.awaits_answer


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("anna", "anna"),
        ("jörg m.", "j-rg-m"),
        ("*/**", "somebody"),
        ("", "somebody"),
        ("x" * 99, "x" * 32),
    ],
)
def test_name_as_part_of_a_key(name: str, part: str) -> None:
    assert client.to_key_part(name) == part


@pytest.mark.parametrize("is_connected", [True, False], ids=["terminal lost", "not connected"])
async def test_without_terminal_or_connection_nothing_is_waited_for_at_the_end(
    panel: Panel, is_connected: bool
) -> None:
    if is_connected:
        await panel.connect()
    panel.peer.close(says_goodbye=not is_connected)
    assert any(each.is_leaving for each in panel.transport.pings) is not is_connected
    assert (panel.transport.is_closed, panel.transport.awaits_answer) == (True, False)


def test_several_pings_fit_into_the_shortest_operator_lost_ms() -> None:
    (lost,) = [field for field in fields(TaskParameters) if field.name == "operator_lost_ms"]
    assert lost.ge is not None
    assert lost.ge >= 3 * 1000 * client.PING_INTERVAL_S


# --- the session's clock


AHEAD = 1000 * SECOND


class Watch:
    """Clock set by hand."""

    now = 5 * SECOND

    def __call__(self) -> int:
        return self.now


def exchange_ping(
    clock: RemoteClock, watch: Watch, outward: int, back: int, clock_id: str = "there"
) -> None:
    """Exchange a ping with these travel times (ns)."""
    sent = watch.now
    watch.now += outward + back
    clock.update(Pong(sent, sent + outward + AHEAD, clock_id, 0, "1"))


def test_it_is_the_clock_of_this_host_or_that_of_another_by_half_of_the_shortest_round_trip() -> (
    None
):
    watch = Watch()
    clock = RemoteClock(watch, "here")
    exchange_ping(clock, watch, 100 * MS, 1 * MS, clock_id="here")
    assert clock.now() == watch.now
    elsewhere = RemoteClock(watch, "here")
    for there, back in ((40, 2), (3, 1), (90, 5)):
        exchange_ping(elsewhere, watch, there * MS, back * MS)
    assert abs(elsewhere.now() - (watch.now + AHEAD)) <= 2 * MS


def test_pings_from_before_a_restart_of_the_sessions_machine_do_not_count() -> None:
    watch = Watch()
    clock = RemoteClock(watch, "here")
    exchange_ping(clock, watch, 1, 1)
    sent = watch.now
    watch.now += 10 * MS
    clock.update(Pong(sent, 7, "there, restarted", 0, "1"))
    assert abs(clock.now() - 7) <= 10 * MS
