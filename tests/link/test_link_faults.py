"""Real processes: what becomes of a link whose panel or whose own process is killed, frozen, or floods it."""

import asyncio
import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zenoh

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Record, Topic
from sar_tui.framework.clock import MS, LiveClock
from sar_tui.framework.topics import NOTE_ADDED, PRESENCE, REFUSED, SESSION
from sar_tui.link import protocol
from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.client import connect
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.node import LinkNode
from sar_tui.link.peer import Connection, Frame, Peer, PeerEvent, Welcome
from sar_tui.link.server import ListenOptions, open_link
from sar_tui.link.settings import LinkKeys, config, host_settings, socket_settings
from tests.link.test_node import ABOUT, STARTED
from tests.link.tls_fixtures import eventually

LOST_MS = 800
ANNA, OLAF = "operator.anna", "observer.olaf"


async def until(true: Callable[[], object], seconds: float = 60) -> None:
    """Wait for something to become true; fail where it does not."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, "it did not happen"
        await asyncio.sleep(0.01)


class Panel:
    """A panel in this process."""

    def __init__(self, live: JoinableSession, name: str, role: m.Role = "operator") -> None:
        self.heard: list[PeerEvent] = []
        self.peer: Peer = connect(live, name, role, self.heard.append, asyncio.get_running_loop())

    @property
    def states(self) -> list[str]:
        return [each.state for each in self.heard if isinstance(each, Connection)]

    @property
    def frames(self) -> list[Frame]:
        return [frame for each in self.heard if isinstance(each, list) for frame in each]


class Onlooker:
    """A panel in a process of its own."""

    def __init__(self, live: JoinableSession, name: str, role: m.Role = "operator") -> None:
        program = [sys.executable, "-m", "tests.link.panel_process", live.session, live.link, name, role]
        self.process = subprocess.Popen(
            program, bufsize=0, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=Path(__file__).parents[2]
        )
        assert self.process.stdout
        os.set_blocking(self.process.stdout.fileno(), False)
        self._said = b""

    def said(self) -> list[str]:
        assert self.process.stdout
        self._said += self.process.stdout.read() or b""
        return self._said.decode().split()

    def tell(self, note: str) -> None:
        assert self.process.stdin
        self.process.stdin.write(f"{note}\n".encode())

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


class Sitting:
    """A session's side: a bus on the live clock, the node, and the link's own process."""

    def __init__(self, host: BrokerProcess, live: JoinableSession) -> None:
        self.host, self.live = host, live
        clock = LiveClock(asyncio.get_running_loop())
        self.running = asyncio.create_task(clock.run())
        self.bus = Bus(clock)
        self.log: list[Record] = []
        self.bus.tap(self.log.extend)
        self.node = LinkNode(host)
        self.node.welcome = msgspec.structs.replace(ABOUT, link=live.link, session=live.session)
        self.node.attach(self.bus)
        self.bus.publish(SESSION, STARTED)
        self.panels: list[Panel] = []
        self.onlookers: list[Onlooker] = []

    def of(self, topic: Topic[Any]) -> list[Any]:
        return [record.message for record in self.log if record.topic is topic]

    def states(self, name: str) -> list[str]:
        """What was told of somebody."""
        return [changed.state for changed in self.of(PRESENCE) if changed.actor == name]

    async def panel(self, name: str, role: m.Role = "operator") -> Panel:
        """A panel of this process that has been welcomed."""
        self.panels.append(panel := Panel(self.live, name, role))
        await until(lambda: "connected" in panel.states)
        return panel

    async def onlooker(self, name: str, role: m.Role = "operator") -> Onlooker:
        """One of another process that has been welcomed."""
        self.onlookers.append(onlooker := Onlooker(self.live, name, role))
        await until(lambda: "welcome" in onlooker.said())
        return onlooker

    def leave(self) -> None:
        for panel in self.panels:
            panel.peer.close()
        for onlooker in self.onlookers:
            onlooker.end()
        self.node.detach()
        self.running.cancel()


@pytest.fixture
async def sitting(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Sitting]:
    folder = Path(tempfile.mkdtemp(prefix="sar"))  # a socket's path has to be short
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    session = secrets.token_hex(5)
    with open_link(folder, session, "keyboard", ListenOptions.parse(operator=True, listen=None), LOST_MS) as host:
        live = JoinableSession(session=session, task="keyboard", link=host.link, pid=os.getpid())
        sitting = Sitting(host, live)
        try:
            yield sitting
        finally:
            sitting.leave()
    shutil.rmtree(folder)


async def test_who_comes_late_is_welcomed_and_told_how_things_stand(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    (welcome,) = (each for each in panel.heard if isinstance(each, Welcome))
    assert (welcome.name, welcome.role, welcome.session) == (ANNA, "operator", sitting.live.session)
    await until(lambda: STARTED in [frame.message for frame in panel.frames])
    assert sitting.states(ANNA) == ["joined", "baton"]


async def test_an_act_is_posted_and_comes_back_to_the_panel(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    at = panel.peer.now()
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="well", at=at))
    expected = m.NoteAdded(text="well", actor=ANNA, at=at)
    await until(lambda: expected in [frame.message for frame in panel.frames])
    assert sitting.of(NOTE_ADDED) == [expected]


async def test_when_the_links_process_is_killed_another_takes_its_place_and_panels_come_back(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    assert sitting.host.pid
    os.kill(sitting.host.pid, signal.SIGKILL)
    await until(lambda: panel.states[-2:] == ["lost", "connected"])
    assert sitting.states(ANNA) == ["joined", "baton", "lost", "joined", "baton"]
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="again"))
    await until(lambda: sitting.of(NOTE_ADDED))


async def test_when_the_links_process_is_frozen_it_is_ended_and_another_takes_its_place(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    frozen = sitting.host.pid
    assert frozen
    os.kill(frozen, signal.SIGSTOP)
    await until(lambda: panel.states[-2:] == ["lost", "connected"])
    assert sitting.host.pid != frozen
    assert sitting.states(ANNA) == ["joined", "baton", "lost", "joined", "baton"]


async def test_a_panel_that_is_frozen_is_lost_and_comes_back_with_the_baton(sitting: Sitting) -> None:
    onlooker = await sitting.onlooker("anna")
    onlooker.process.send_signal(signal.SIGSTOP)
    await until(lambda: "lost" in sitting.states(ANNA))
    assert sitting.of(PRESENCE)[-1].operated is False
    onlooker.process.send_signal(signal.SIGCONT)
    await until(lambda: sitting.states(ANNA)[-2:] == ["joined", "baton"])
    onlooker.tell("here I am")
    await until(lambda: sitting.of(NOTE_ADDED))


async def test_a_panel_that_is_killed_is_lost_and_another_operator_has_the_baton(sitting: Sitting) -> None:
    onlooker = await sitting.onlooker("anna")
    await sitting.panel("ben")
    onlooker.end()
    await until(lambda: sitting.states("operator.ben") == ["joined", "baton"])
    assert sitting.states(ANNA) == ["joined", "baton", "lost"]


async def test_a_panel_that_is_closed_has_left(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    panel.peer.close()
    await until(lambda: sitting.states(ANNA) == ["joined", "baton", "left"])


async def test_what_an_observer_does_is_refused_and_logged(sitting: Sitting) -> None:
    panel = await sitting.panel("olaf", "observer")
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="me, too"))
    panel.peer.take_control()
    await until(lambda: sitting.of(REFUSED))
    assert {refused.actor for refused in sitting.of(REFUSED)} == {OLAF}
    assert sitting.of(NOTE_ADDED) == []
    assert sitting.of(PRESENCE)[-1].operated is False


async def test_of_ten_thousand_messages_few_reach_the_program_and_an_operator_still_can_act(sitting: Sitting) -> None:
    ben = await sitting.panel("ben")
    keys = LinkKeys(sitting.live.link)
    note = msgspec.Raw(protocol.encode(m.NoteAdded(text="flood")))
    act = protocol.encode(protocol.ActRequest("1", NOTE_ADDED.name, note))
    reached: list[object] = []
    hear = sitting.node.receive
    sitting.node.receive = lambda news: (reached.append(news), hear(news))  # type: ignore[method-assign,assignment]

    def flood() -> None:
        with zenoh.open(config(socket_settings(sitting.live.socket))) as session:
            matched = session.declare_publisher(keys.act(ANNA), congestion_control=zenoh.CongestionControl.BLOCK)
            deadline = time.monotonic() + 5
            while not matched.matching_status.matching and time.monotonic() < deadline:
                time.sleep(0.01)
            for what in (act, b"\xc1", b"x" * 100_000):
                for _ in range(4_000):
                    matched.put(what)

    started = time.monotonic()
    flooding = asyncio.create_task(asyncio.to_thread(flood))
    await until(lambda: any("more than" in refused.why for refused in sitting.of(REFUSED)))
    ben.peer.send(NOTE_ADDED, m.NoteAdded(text="calm"))
    await until(lambda: "calm" in [note.text for note in sitting.of(NOTE_ADDED)])
    await flooding
    await until(lambda: sum(refused.count for refused in sitting.of(REFUSED) if refused.actor == ANNA) > 10_000)
    assert len(reached) < 100 + 50 * (time.monotonic() - started)


async def test_each_thing_that_cannot_be_taken_is_refused_and_logged(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="x" * 100_000))
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="x" * 5_000))
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="\x1b[2J"))
    with zenoh.open(config(socket_settings(sitting.live.socket))) as session:
        for key in ("act/operator.anna", "act/nobody", "act/*"):
            session.put(f"sar-tui/{sitting.live.link}/{key}", b"nonsense")
        whys = ("20000 bytes", "4000 characters", "control characters", "cannot be read", "who sent it")
        await until(lambda: all(any(why in each.why for each in sitting.of(REFUSED)) for why in whys))
    assert sitting.of(NOTE_ADDED) == []


async def test_a_session_that_ends_is_away_to_its_panels(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    sitting.node.detach()
    sitting.host.close()
    await until(lambda: panel.states[-1] == "ended")


async def test_a_session_that_was_left_and_is_resumed_is_joined_again_by_its_panels(sitting: Sitting) -> None:
    panel = await sitting.panel("anna")
    sitting.node.detach()
    sitting.host.close()
    await until(lambda: panel.states[-1] == "ended")
    live = sitting.live
    host = BrokerProcess(protocol.Setup(host_settings(live.link, socket=live.socket), live.link, LOST_MS * MS))
    resumed = LinkNode(host)
    resumed.welcome = sitting.node.welcome
    try:
        host.open()
        resumed.attach(sitting.bus)
        await until(lambda: panel.states[-1] == "connected")
        panel.peer.send(NOTE_ADDED, m.NoteAdded(text="well again"))
        await until(lambda: sitting.of(NOTE_ADDED))
    finally:
        resumed.detach()
        host.close()


def test_when_the_program_is_killed_the_links_process_ends_with_it(tmp_path: Path) -> None:
    program = (
        "import sys, time; from sar_tui.link.broker_process import BrokerProcess;"
        "from sar_tui.link.settings import host_settings;"
        "from sar_tui.link.protocol import Setup;"
        "host = BrokerProcess(Setup(host_settings('link'), 'link', 10**9)); host.open();"
        "print(host.pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout
        try:
            child = int(parent.stdout.readline())
            os.kill(child, 0)
        finally:
            parent.kill()
    assert eventually(lambda: not _is_running(child))


def _is_running(pid: int) -> bool:
    """A process that has ended and was not asked for its end yet does not run."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_a_link_that_cannot_listen_says_so_before_the_session_begins(tmp_path: Path) -> None:
    program = (sys.executable, "-c", "raise SystemExit(3)")
    with pytest.raises(LinkError, match="ended at once"):
        BrokerProcess(protocol.Setup("{}", "link", LOST_MS * MS), program).open()


def test_a_port_that_is_taken_and_an_authority_that_is_not_there_are_told_in_a_sentence(tmp_path: Path) -> None:
    import socket

    from sar_tui.link.authority import Authority

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        listening = ListenOptions.parse(operator=False, listen=f"tls/127.0.0.1:{port}")
        with (
            pytest.raises(LinkError, match="Nobody has been invited"),
            open_link(tmp_path, "s", "t", listening, LOST_MS),
        ):
            pass
        Authority.open_or_create(tmp_path)
        with (
            pytest.raises(LinkError, match=f"127.0.0.1:{port}. Another program"),
            open_link(tmp_path, "s", "t", listening, LOST_MS),
        ):
            pass
