"""Recovery of the link with real processes: panel or broker killed or frozen, floods of
messages.
"""

import asyncio
import os
import secrets
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import zenoh

from sar_tui.link import protocol
from sar_tui.link.authority import Authority
from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.client import connect
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import Invitation
from sar_tui.link.listening import ListenOptions, open_link
from sar_tui.link.node import LinkNode
from sar_tui.link.peer import Connection, Frame, MotionTrace, Peer, PeerEvent, Welcome
from sar_tui.link.zenoh_settings import (
    Guest,
    LinkKeys,
    config,
    host_settings,
    network_settings,
    socket_settings,
)
from sar_tui.loop.bus import Bus, Record, Topic
from sar_tui.loop.clock import LiveClock
from sar_tui.loop.nodes.arbiter import Arbiter
from sar_tui.loop.topics import ANSWERED, IMU, NOTE_ADDED, PRESENCE, REFUSED, SESSION
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.motion.samples import SAMPLE, pack
from sar_tui.rules.parameters import TaskParameters
from tests.link.test_node import STARTED, WELCOME
from tests.link.tls_fixtures import eventually, invite_guests, visiting, without_certificate
from tests.outputs.voice_fixtures import is_alive

LOST_MS = 800
ANNA = "operator.anna"


async def until(condition: Callable[[], object], seconds: float = 60) -> None:
    """Wait until a condition holds, or fail."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not happen"
        await asyncio.sleep(0.01)


class Panel:
    """Panel in this process."""

    def __init__(
        self, where: JoinableSession | Invitation, name: str = "", role: m.Role = "operator"
    ) -> None:
        self.events: list[PeerEvent] = []
        self.peer: Peer = connect(where, name, role, self.events.append, asyncio.get_running_loop())

    @property
    def states(self) -> list[str]:
        return [each.state for each in self.events if isinstance(each, Connection)]

    @property
    def answers(self) -> dict[str, tuple[str, str]]:
        """Outcome and reason of each answered act, by its id."""
        answers = [each.message for each in self.frames if each.topic is ANSWERED]
        return {each.id: (each.outcome, each.why) for each in answers}  # type: ignore[attr-defined]

    @property
    def frames(self) -> list[Frame]:
        return [frame for each in self.events if isinstance(each, list) for frame in each]


class PanelProcess:
    """Panel in a process of its own."""

    def __init__(self, live: JoinableSession, name: str) -> None:
        program = [sys.executable, "-m", "tests.link.panel_process", live.session, live.link, name]
        pipes: Any = {"bufsize": 0, "stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        folder = Path(__file__).parents[2]
        self.process = subprocess.Popen(program, cwd=folder, **pipes)
        assert self.process.stdout
        os.set_blocking(self.process.stdout.fileno(), False)
        self._output = b""

    def output(self) -> list[str]:
        assert self.process.stdout
        self._output += self.process.stdout.read() or b""
        return self._output.decode().split()

    def has_rejoined(self) -> bool:
        """Return True if the panel lost its connection and has another."""
        output = self.output()
        return "lost" in output and "welcome" in output[output.index("lost") :]

    def send(self, note: str) -> None:
        assert self.process.stdin
        self.process.stdin.write(f"{note}\n".encode())

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


class LinkSession:
    """Session's side: a bus on the live clock, the node, and the broker process."""

    def __init__(self, broker: BrokerProcess, live: JoinableSession) -> None:
        self.broker, self.live = broker, live
        clock = LiveClock(asyncio.get_running_loop())
        self.running = asyncio.create_task(clock.run())
        self.bus = Bus(clock)
        self.log: list[Record] = []
        self.bus.tap(self.log.extend)
        self.node = LinkNode(broker)
        self.node.welcome = msgspec.structs.replace(WELCOME, link=live.link, session=live.session)
        self.node.attach(self.bus)
        self.bus.publish(SESSION, STARTED)
        self.panels: list[Panel] = []
        self.panel_processes: list[PanelProcess] = []

    def of(self, topic: Topic[Any]) -> list[Any]:
        return [record.message for record in self.log if record.topic is topic]

    @property
    def refusals(self) -> set[tuple[str, str]]:
        """Peers of whom something was refused, with the reasons; each may be reported again."""
        return {(refused.actor, refused.why) for refused in self.of(REFUSED)}

    def states(self, name: str) -> list[str]:
        """Return the states reported of a peer; no terminal proves its presence."""
        changes = (changed for changed in self.of(PRESENCE) if changed.actor == name)
        return [changed.state for changed in changes if changed.state != "unproven"]

    async def panel(self, name: str) -> Panel:
        """Start an operator's panel in this process and wait until it is connected."""
        self.panels.append(panel := Panel(self.live, name))
        await until(lambda: "connected" in panel.states)
        return panel

    async def panel_process(self, name: str) -> PanelProcess:
        """Start an operator's panel in another process and wait until it is connected."""
        self.panel_processes.append(panel_process := PanelProcess(self.live, name))
        await until(lambda: "welcome" in panel_process.output())
        return panel_process

    def leave(self) -> None:
        for panel in self.panels:
            panel.peer.close()
        for panel_process in self.panel_processes:
            panel_process.end()
        self.node.detach()
        self.running.cancel()


@pytest.fixture
async def session(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[LinkSession]:
    lost_ms = getattr(request, "param", LOST_MS)
    folder = Path(tempfile.mkdtemp(prefix="sar"))  # a socket's path must be short
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    session_id = secrets.token_hex(5)
    with open_link(
        folder,
        session_id,
        "keyboard",
        ["P01"],
        ListenOptions.parse(operator=True, listen=None),
        lost_ms,
    ) as broker:
        live = JoinableSession(
            session=session_id, task="keyboard", link=broker.link, pid=os.getpid()
        )
        session = LinkSession(broker, live)
        try:
            yield session
        finally:
            session.leave()
    shutil.rmtree(folder)


async def test_a_peer_gets_welcome_and_snapshot_and_its_act_returns_until_it_leaves(
    session: LinkSession,
) -> None:
    panel = await session.panel("anna")
    files = list(session.live.socket.parent.iterdir())
    assert session.live.socket in files
    assert {stat.S_IMODE(each.stat().st_mode) & 0o177 for each in files} == {0}, "private"
    welcomes = [each for each in panel.events if isinstance(each, Welcome)]
    distinct = {(welcome.name, welcome.role, welcome.session) for welcome in welcomes}
    assert distinct == {(ANNA, "operator", session.live.session)}, (
        "on a busy machine it may come twice"
    )
    await until(lambda: STARTED in [frame.message for frame in panel.frames])
    at = panel.peer.now()
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="well", at=at))
    expected = m.NoteAdded(text="well", actor=ANNA, at=at)
    await until(lambda: expected in [frame.message for frame in panel.frames])
    assert session.of(NOTE_ADDED) == [expected]
    panel.peer.close()
    await until(lambda: session.states(ANNA) == ["joined", "baton", "left"])


async def test_a_sensors_samples_arrive_as_a_trace(session: LinkSession) -> None:
    panel = await session.panel("anna")
    samples = np.zeros(100, SAMPLE)
    samples["at"] = session.bus.clock.now() + np.arange(100) * 4 * MS
    samples["rate"][:, 2] = 1.5
    session.bus.publish(IMU, m.ImuBlock(samples=pack(samples)))
    await until(lambda: any(isinstance(each, MotionTrace) for each in panel.events))
    trace = next(each for each in panel.events if isinstance(each, MotionTrace))
    assert trace.rates == pytest.approx([1.5] * len(trace.rates))
    assert "lost" not in panel.states


@pytest.mark.parametrize(
    "fault", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.slow)]
)
async def test_killed_or_frozen_broker_is_restarted_and_panels_reconnect(
    session: LinkSession, fault: signal.Signals
) -> None:
    panel = await session.panel("anna")
    broker = session.broker.pid
    assert broker
    os.kill(broker, fault)
    await until(lambda: panel.states[-2:] == ["lost", "connected"])
    assert session.broker.pid != broker
    assert session.states(ANNA) == ["joined", "baton", "lost", "joined", "baton"]
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="again"))
    await until(lambda: session.of(NOTE_ADDED))


async def test_control_passes_on_when_a_panel_freezes_and_it_may_come_back_until_it_is_killed(
    session: LinkSession,
) -> None:
    panel_process = await session.panel_process("anna")
    await session.panel("ben")
    panel_process.process.send_signal(signal.SIGSTOP)
    await until(lambda: session.states("operator.ben") == ["joined", "baton"])
    assert session.states(ANNA) == ["joined", "baton", "lost"]
    panel_process.process.send_signal(signal.SIGCONT)
    await until(lambda: session.states(ANNA)[3:] == ["joined"])
    panel_process.end()
    await until(lambda: session.states(ANNA)[4:] == ["lost"])


@pytest.mark.parametrize("session", [60_000], indirect=True)
async def test_panel_that_reconnects_in_time_is_not_lost(session: LinkSession) -> None:
    """Zenoh drops the connection of a silent panel long before the operator counts as lost."""
    panel_process = await session.panel_process("anna")
    changes: list[str] = []
    socket = session.live.socket
    with zenoh.open(config(socket_settings(socket))) as watcher:
        handler = zenoh.handlers.Callback(
            lambda sample: changes.append(str(sample.kind)), indirect=False
        )
        tokens = LinkKeys(session.live.link).ping("*")
        watching = watcher.liveliness().declare_subscriber(tokens, handler)
        panel_process.process.send_signal(signal.SIGSTOP)
        await until(lambda: any("DELETE" in kind for kind in changes))
        watching.undeclare()
    panel_process.process.send_signal(signal.SIGCONT)
    await until(panel_process.has_rejoined)
    panel_process.send("here I am")
    await until(lambda: session.of(NOTE_ADDED))
    assert session.states(ANNA) == ["joined", "baton"]


# --- answers


async def test_of_too_many_acts_each_is_answered(session: LinkSession, calm: Theme) -> None:
    Arbiter(TaskParameters(), calm).attach(session.bus)
    panel = await session.panel("anna")
    ids = [f"{number:x}" for number in range(100)]
    for id in ids:
        panel.peer.send(NOTE_ADDED, m.NoteAdded(id=id, text="hm"))
    await until(lambda: len(panel.answers) == len(ids))
    outcomes = {id: outcome for id, (outcome, _) in panel.answers.items()}
    assert outcomes == {
        id: "done" if id in {note.id for note in session.of(NOTE_ADDED)} else "refused"
        for id in ids
    }
    assert set(outcomes.values()) == {"done", "refused"}


async def test_acts_around_the_end_of_the_broker_are_carried_out_or_answered_as_lost(
    session: LinkSession, calm: Theme
) -> None:
    Arbiter(TaskParameters(), calm).attach(session.bus)
    panel = await session.panel("anna")
    sent = 0
    assert session.broker.pid
    while panel.states[-1] == "connected" and sent < 30:
        sent += 1
        panel.peer.send(NOTE_ADDED, m.NoteAdded(id=f"{sent:x}", text="hm"))
        if sent == 3:
            os.kill(session.broker.pid, signal.SIGKILL)
        await asyncio.sleep(0)
    await until(lambda: panel.states[-2:] == ["lost", "connected"])
    await until(lambda: len(panel.answers) == sent)
    done = {id for id, (outcome, _) in panel.answers.items() if outcome == "done"}
    assert done == {note.id for note in session.of(NOTE_ADDED)}
    whys = {why for outcome, why in panel.answers.values() if outcome == "refused"}
    assert whys == {"It did not arrive."}


async def test_flood_is_held_back_and_an_operator_can_still_act(session: LinkSession) -> None:
    ben = await session.panel("ben")
    keys = LinkKeys(session.live.link)
    note = msgspec.Raw(protocol.encode(m.NoteAdded(text="flood")))
    act = protocol.encode(protocol.ActRequest("1", NOTE_ADDED.name, note))
    received: list[object] = []
    receive = session.node.receive
    session.node.receive = lambda event: (received.append(event), receive(event))  # type: ignore[method-assign,assignment]

    def flood() -> None:
        with zenoh.open(config(socket_settings(session.live.socket))) as flooder:
            publisher = flooder.declare_publisher(
                keys.act(ANNA), congestion_control=zenoh.CongestionControl.BLOCK
            )
            deadline = time.monotonic() + 60
            while not publisher.matching_status.matching and time.monotonic() < deadline:
                time.sleep(0.01)
            for what in (act, b"\xc1", b"x" * 100_000):
                for _ in range(4_000):
                    publisher.put(what)

    started = time.monotonic()
    flooding = asyncio.create_task(asyncio.to_thread(flood))
    await until(lambda: any("more than" in refused.why for refused in session.of(REFUSED)))
    ben.peer.send(NOTE_ADDED, m.NoteAdded(text="calm"))
    await until(lambda: "calm" in [note.text for note in session.of(NOTE_ADDED)])
    await flooding
    await until(
        lambda: (
            sum(refused.count for refused in session.of(REFUSED) if refused.actor == ANNA) > 10_000
        )
    )
    assert len(received) < 100 + 50 * (time.monotonic() - started)


async def test_messages_that_are_too_long_or_unsigned_are_refused_and_logged(
    session: LinkSession,
) -> None:
    panel = await session.panel("anna")
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="x" * 100_000))
    with zenoh.open(config(socket_settings(session.live.socket))) as guest:
        guest.put(f"sar-tui/{session.live.link}/act/nobody", b"nonsense")
        refused = {
            (ANNA, "It is longer than 20000 bytes."),
            ("unknown", "It does not say who sent it."),
        }
        await until(lambda: session.refusals == refused)
    assert session.of(NOTE_ADDED) == []


async def test_over_the_network_invited_guests_join_and_others_are_refused_with_the_reason(
    tmp_path: Path,
) -> None:
    at = invite_guests(tmp_path)
    anna, eve, keys = str(at.anna.guest), str(at.eve.guest), at.keys
    stranger = Authority.open_or_create(tmp_path / "elsewhere").invite(
        Guest("anna", "operator"), [at.where], 30
    )
    pretender = msgspec.structs.replace(
        stranger.credentials, authority=at.anna.credentials.authority
    )
    listening = ListenOptions.parse(operator=False, listen=at.where.locator)
    with open_link(tmp_path, "s1", "keyboard", ["P01"], listening, LOST_MS) as broker:
        session = LinkSession(broker, JoinableSession("s1", "keyboard", broker.link, os.getpid()))
        try:
            panels = [Panel(at.anna), Panel(at.eve)]
            session.panels += panels
            await until(lambda: all("connected" in panel.states for panel in panels))
            for panel in panels:
                panel.peer.send(NOTE_ADDED, m.NoteAdded(text=panel.peer.name))
            with visiting(at.gone, at.eve) as [_, forger]:
                key = forger.declare_keyexpr(keys.act(anna))  # sent even if nobody subscribes
                forger.put(key, b"evil", congestion_control=zenoh.CongestionControl.BLOCK)
                await until(lambda: len(session.refusals) == 3)
            for settings in (
                without_certificate(at.anna),
                network_settings(at.where, at.late.credentials),
                network_settings(at.where, pretender),
                network_settings(at.where, stranger.credentials),
            ):
                with pytest.raises(zenoh.ZError):
                    await asyncio.to_thread(zenoh.open, config(settings))
            await until(lambda: len(session.refusals) == 7)
        finally:
            session.leave()
    assert [note.text for note in session.of(NOTE_ADDED)] == [anna]
    assert session.refusals == {
        (eve, "An observer can only stop the agent."),
        (eve, "It may not send among the acts of operator.anna."),
        ("operator.gone", "Its invitation was revoked, or is not known here."),
        ("unknown", "It has no certificate."),
        ("unknown", "Its invitation has expired."),
        ("unknown", "Its certificate was made by another authority."),
        ("unknown", "It does not trust this host's certificate."),
    }


async def test_panels_rejoin_a_resumed_session(session: LinkSession) -> None:
    panel = await session.panel("anna")
    session.node.detach()
    session.broker.close()
    await until(lambda: panel.states[-1] == "ended")
    live = session.live
    host = BrokerProcess(
        protocol.Setup(host_settings(live.link, socket=live.socket), live.link, LOST_MS * MS)
    )
    resumed = LinkNode(host)
    resumed.welcome = session.node.welcome
    try:
        host.open()
        resumed.attach(session.bus)
        await until(lambda: panel.states[-1] == "connected")
        panel.peer.send(NOTE_ADDED, m.NoteAdded(text="well again"))
        await until(lambda: session.of(NOTE_ADDED))
    finally:
        resumed.detach()
        host.close()


def test_broker_ends_when_the_program_is_killed(tmp_path: Path) -> None:
    program = (
        "import sys, time; from sar_tui.link.broker_process import BrokerProcess;"
        "from sar_tui.link.zenoh_settings import host_settings;"
        "from sar_tui.link.protocol import Setup;"
        "host = BrokerProcess(Setup(host_settings('link'), 'link', 10**9)); host.open();"
        "print(host.pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout
        try:
            child = int(parent.stdout.readline())
            os.kill(child, 0)
        finally:
            parent.kill()
    assert eventually(lambda: not is_alive(child))


def test_a_link_that_cannot_listen_a_taken_port_and_a_missing_authority_are_reported(
    tmp_path: Path,
) -> None:
    program = (sys.executable, "-c", "raise SystemExit(3)")
    with pytest.raises(LinkError, match="ended at once"):
        BrokerProcess(protocol.Setup("{}", "link", LOST_MS * MS), program).open()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        listening = ListenOptions.parse(operator=False, listen=f"tls/127.0.0.1:{port}")
        with (
            pytest.raises(LinkError, match="Nobody has been invited"),
            open_link(tmp_path, "s", "t", ["P01"], listening, LOST_MS),
        ):
            pass
        Authority.open_or_create(tmp_path)
        with (
            pytest.raises(LinkError, match=f"127.0.0.1:{port}. Another program"),
            open_link(tmp_path, "s", "t", ["P01"], listening, LOST_MS),
        ):
            pass
