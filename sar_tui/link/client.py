"""A panel's side of the link: receives the session's messages on the panel's event loop, and sends
operators' acts.

Everything that may block runs on other threads, so that the panel never freezes.
"""

import asyncio
import contextlib
import itertools
import os
import queue
import re
import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

import msgspec

from sar_tui.drivers import child_process
from sar_tui.link import protocol
from sar_tui.link.admission import DECLINED, VISIT_ENDED
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import Connection, Frame, Peer, PeerListener, TerminalState
from sar_tui.link.protocol import (
    Answers,
    Batch,
    LinkClosed,
    MotionTraces,
    Ping,
    Pong,
    ProtocolError,
    SessionMessage,
    Snapshot,
)
from sar_tui.link.refusals import GUEST_LOG, log_environment, why_not_connected
from sar_tui.link.remote_clock import RemoteClock
from sar_tui.link.visits import HomeVisit
from sar_tui.link.zenoh_settings import (
    LinkKeys,
    config,
    home_link,
    network_settings,
    socket_settings,
)
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import host_now
from sar_tui.loop.topics import ALL, ANSWERED
from sar_tui.model.messages import ActAnswered, Message, Role
from sar_tui.model.units import SECOND

if TYPE_CHECKING:
    import zenoh


_RETRY_S = 0.5
_MAX_QUEUED = 200
_CLOSE_TIMEOUT_S = 1.0
_GOODBYE_TIMEOUT_S = 0.5

_PROBE_INTERVAL_S = 15.0
"""Time between two probes of why there is no connection; each takes another process."""
_NO_SESSION = "The session does not answer: it may be over."
_ADMISSION_TIMEOUT_S = 1.5
"""A peer that is connected but sees nothing of the session for longer was not admitted."""

Received = SessionMessage | Connection


class ConnectionTarget(NamedTuple):
    """A session to connect to: its link's id, and Zenoh settings for each address to try.

    ``socket``: if it is on this machine. ``is_visit``: it is at home, through a router.
    """

    link: str
    settings: tuple[str, ...]
    socket: Path | None = None
    is_visit: bool = False


Where = JoinableSession | Invitation | HomeVisit
"""A session: on this machine, at the address of an invitation, or at home."""


def connection_target(where: Where) -> ConnectionTarget:
    """Return how to connect to a session. Raises LinkError if the link's packages are not
    installed.
    """
    need_packages()
    if isinstance(where, JoinableSession):
        return ConnectionTarget(where.link, (socket_settings(where.socket),), where.socket)
    if isinstance(where, Invitation):
        return ConnectionTarget(
            where.link, tuple(network_settings(place, where.credentials) for place in where.where)
        )
    invitation = where.invitation
    settings = tuple(
        network_settings(place, invitation.credentials, through_router=True)
        for place in invitation.where
    )
    return ConnectionTarget(home_link(invitation.link, where.home), settings, is_visit=True)


class Transport:
    """Opens the connection, retrying until it succeeds; from then on Zenoh reconnects by itself.

    Args:
        target: the session.
        name: the peer's name, as in keys.
        on_receive: called on any thread with what is received.
    """

    def __init__(
        self, target: ConnectionTarget, name: str, on_receive: Callable[[Received], object]
    ) -> None:
        self._target, self._on_receive = target, on_receive
        self._keys = LinkKeys(target.link)
        self._name = name
        self._outbox: queue.Queue[tuple[str, bytes] | None] = queue.Queue(_MAX_QUEUED)
        self._closed = threading.Event()
        self._acknowledged = threading.Event()
        self._is_admitted = False
        self._thread = threading.Thread(target=self._run, name="link", daemon=True)

    def open(self) -> None:
        """Start to connect."""
        self._thread.start()

    def send_ping(self, payload: bytes) -> None:
        """Send a heartbeat; it is dropped if the queue is full."""
        self._put(self._keys.ping(self._name), payload)

    def send_act(self, payload: bytes) -> None:
        """Send an act; it is dropped if the queue is full."""
        self._put(self._keys.act(self._name), payload)

    def close(self, *, awaits_answer: bool) -> None:
        """Send what is queued and close the connection, within about a second.

        ``awaits_answer``: wait for ``acknowledge``; otherwise closing may overtake the last
        message.
        """
        if not awaits_answer:
            self.acknowledge()
        self._closed.set()
        self._enqueue(None)
        if self._thread.ident:
            self._thread.join(_CLOSE_TIMEOUT_S)

    def acknowledge(self) -> None:
        """Let ``close`` finish: the session has received the last message. Thread-safe."""
        self._acknowledged.set()

    def _put(self, key: str, payload: bytes) -> None:
        if not self._closed.is_set() or self._thread.is_alive():
            self._enqueue((key, payload))

    def _enqueue(self, message: "tuple[str, bytes] | None") -> None:
        with contextlib.suppress(queue.Full):
            self._outbox.put_nowait(message)

    # --- on the transport's thread

    def _run(self) -> None:
        # not at once: the session may be starting
        probed_at = time.monotonic() - _PROBE_INTERVAL_S + _RETRY_S / 2
        for settings in itertools.cycle(self._target.settings):
            if self._closed.is_set():
                return
            if session := self._try(settings):
                try:
                    self._serve(session)
                finally:
                    session.close()  # type: ignore[no-untyped-call]
                return
            if time.monotonic() - probed_at > _PROBE_INTERVAL_S:
                self._on_receive(Connection("connecting", self._failure_reason(settings)))
                probed_at = time.monotonic()
            self._closed.wait(_RETRY_S)

    def _try(self, settings: str) -> "zenoh.Session | None":
        """Open Zenoh, or return None."""
        import zenoh

        try:
            return zenoh.open(config(settings))
        except zenoh.ZError:
            return None

    def _failure_reason(self, settings: str) -> str:
        """Return why there is no connection, if known."""
        if self._target.socket:
            return _NO_SESSION

        try:
            probe(settings, self._target.link, through_router=self._target.is_visit)
        except LinkError as error:
            return str(error)
        return ""

    def _serve(self, session: "zenoh.Session") -> None:
        """Send what is queued until closed. Heartbeats are queued all the time, so this never
        blocks for long.
        """
        import zenoh

        keys, name = self._keys, self._name
        heard = [keys.reply(name)] if self._target.is_visit else [keys.broadcast, keys.reply(name)]
        declared: list[Any] = [
            session.declare_subscriber(key, zenoh.handlers.Callback(self._received, indirect=False))
            for key in heard
        ]
        declared.append(session.liveliness().declare_token(keys.ping(name)))
        handler = zenoh.handlers.Callback(self._liveliness_changed, indirect=False)
        declared.append(
            session.liveliness().declare_subscriber(keys.broadcast, handler, history=True)
        )
        report_at = time.monotonic() + _ADMISSION_TIMEOUT_S
        while (message := self._outbox.get()) is not None:
            if not self._is_admitted and time.monotonic() > report_at:
                self._on_receive(Connection("connecting", self._why_not_admitted))
                report_at += _PROBE_INTERVAL_S
            with contextlib.suppress(zenoh.ZError):
                session.put(
                    *message, congestion_control=zenoh.CongestionControl.BLOCK, express=True
                )
        # before the token is dropped, which looks like a lost connection
        self._acknowledged.wait(_GOODBYE_TIMEOUT_S)

    @property
    def _why_not_admitted(self) -> str:
        if self._target.is_visit:
            return NOBODY_THERE
        return _NO_SESSION if self._target.socket else NOT_ADMITTED

    def _received(self, sample: "zenoh.Sample") -> None:
        # of a newer version, or damaged: batch numbers show what is missing
        with contextlib.suppress(ProtocolError):
            self._on_receive(protocol.decode(sample.payload.to_bytes(), SessionMessage))

    def _liveliness_changed(self, sample: "zenoh.Sample") -> None:
        """Handle that the session's end of the link appeared or disappeared."""
        state: Literal["connected", "lost"] = (
            "lost" if "DELETE" in str(sample.kind) else "connected"
        )
        self._is_admitted = self._is_admitted or state == "connected"
        self._on_receive(Connection(state, "" if state == "connected" else "The connection broke."))


M = TypeVar("M", bound=Message)

PING_INTERVAL_S = 0.15
"""Several pings fit into the shortest ``operator_lost_ms``. They are sent from the panel's own
loop, so that a panel that hangs is noticed.
"""
ASK_AFTER = SECOND
"""Time after which the answer to an act is asked for, and asked for again."""
SILENCE_TIMEOUT = 2 * SECOND
"""Silence (ns) after which a session, which answers every ping, is lost."""

_MAX_NAME = 32
_SILENT = "The session does not answer."
_OVER = "The session is over."


def connect(
    where: Where,
    name: str,
    role: Role,
    listener: PeerListener,
    loop: asyncio.AbstractEventLoop,
) -> Peer:
    """Join a session, on this machine (see ``discovery.live_sessions``), by invitation, or at home.

    Args:
        where: the session.
        name: the peer's name; characters that a key cannot hold are replaced. An invitation
            overrides name and role.
        role: operator or observer.
        listener: called on ``loop`` with each event, in order, first with the state ``connecting``.
        loop: the panel's event loop.

    Raises:
        LinkError: the link's packages are not installed.
    """
    if not isinstance(where, JoinableSession):
        invitation = where if isinstance(where, Invitation) else where.invitation
        if invitation.role == "home":
            raise LinkError(IS_FOR_A_HOME)
        name, role = invitation.name, invitation.role
    rejoins = isinstance(where, JoinableSession)
    return _Client(
        connection_target(where),
        f"{role}.{to_key_part(name)}",
        role,
        listener,
        loop,
        rejoins=rejoins,
    )


def to_key_part(name: str) -> str:
    """Return a name as it can be part of a key: ``jörg m.`` becomes ``j-rg-m``."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-_")[:_MAX_NAME] or "somebody"


class _Client:
    """Implements ``Peer``. Everything here runs on the panel's loop; the transport has threads of
    its own.

    ``rejoins``: rejoin the session if it is resumed. False for an invitation, which would join any
    session that runs next, perhaps of another participant.
    """

    def __init__(
        self,
        target: ConnectionTarget,
        name: str,
        role: Role,
        listener: PeerListener,
        loop: asyncio.AbstractEventLoop,
        *,
        rejoins: bool,
    ) -> None:
        self.name, self.role, self._rejoins = name, role, rejoins
        self._is_visit = target.is_visit
        self._listener, self._loop = listener, loop
        self._id = secrets.token_hex(8)
        self._clock = RemoteClock()
        self._connection = Connection("connecting")
        self._is_admitted = False
        self._number: int | None = None
        """Number of the last batch; None if a snapshot is needed."""
        self._received_at = 0
        self._unanswered: dict[str, int] = {}
        """Ids of acts that the session has not answered, and when they were sent or asked for
        last."""
        self._run = ""
        self._is_closed = False
        self._goodbye_at: int | None = None
        self._terminal: Callable[[], TerminalState] = TerminalState
        self._transport = Transport(target, name, self._receive_from_thread)
        loop.call_soon(self._start)

    def send(self, topic: Topic[M], message: M) -> None:
        """See `Peer`. Without a connection the act is dropped, so that nothing is done unexpectedly
        late.
        """
        if topic.name not in protocol.OPERATOR_TOPICS:
            raise ValueError(f"An operator may not send {topic.name}.")
        self._send_act(topic.name, protocol.encode(message), getattr(message, "id", ""))

    def watch_terminal(self, state: Callable[[], TerminalState]) -> None:
        """See `Peer`."""
        self._terminal = state

    def take_control(self) -> None:
        """See `Peer`."""
        self._send_act(protocol.TAKE_CONTROL, protocol.encode(None))

    def now(self) -> int:
        """See `Peer`."""
        return self._clock.now()

    def close(self, *, says_goodbye: bool = True) -> None:
        """See `Peer`. May be called twice."""
        if self._is_closed:
            return
        self._is_closed = True
        if says_goodbye:
            self._goodbye_at = host_now()
            self._transport.send_ping(
                protocol.encode(Ping(self._id, self._goodbye_at, is_leaving=True))
            )
        self._transport.close(awaits_answer=says_goodbye and self._connection.state == "connected")

    # --- on the loop

    def _start(self) -> None:
        if self._is_closed:
            return
        self._listener(self._connection)
        self._transport.open()
        self._tick()

    def _send_act(self, topic: str, message: bytes, id: str = "") -> None:
        if self._connection.state == "connected":
            if id:
                self._unanswered[id] = host_now()
            act = protocol.ActRequest(
                self._id, topic, msgspec.Raw(message), self._terminal().silence, id
            )
            self._transport.send_act(protocol.encode(act))

    def _tick(self) -> None:
        if self._is_closed:
            return
        if (
            self._connection.state == "connected"
            and host_now() - self._received_at > SILENCE_TIMEOUT
        ):
            self._lost(_SILENT)
        self._ping()
        self._loop.call_later(PING_INTERVAL_S, self._tick)

    def _ping(self) -> None:
        silence, is_relayed = self._terminal()
        ping = Ping(
            self._id,
            host_now(),
            wants_snapshot=self._number is None,
            silence=silence,
            is_relayed=is_relayed,
            unanswered=self._to_ask_for(),
        )
        self._transport.send_ping(protocol.encode(ping))

    def _to_ask_for(self) -> tuple[str, ...]:
        """Return the ids of acts whose answers are due to be asked for."""
        if self._connection.state != "connected":
            return ()
        now = host_now()
        due = [id for id, at in self._unanswered.items() if now - at >= ASK_AFTER]
        asked = tuple(due[: protocol.MAX_ASKED])
        self._unanswered |= dict.fromkeys(asked, now)
        return asked

    def _lost(self, why: str) -> None:
        self._is_admitted, self._number = False, None
        if self._connection.state in ("connected", "lost"):
            self._set_connection(Connection("lost", why))
        elif self._is_visit and self._connection.state == "connecting":
            self._set_connection(Connection("connecting", NOBODY_THERE))

    def _set_connection(self, connection: Connection) -> None:
        if connection != self._connection:
            self._connection = connection
            self._listener(connection)

    def _receive_from_thread(self, received: Received) -> None:
        """Called on the transport's threads."""
        if isinstance(received, Pong) and received.ping_sent_at == self._goodbye_at:
            self._transport.acknowledge()
        with contextlib.suppress(RuntimeError):  # the loop, and the panel with it, is closed
            self._loop.call_soon_threadsafe(self._receive, received)

    def _receive(self, received: Received) -> None:
        if self._is_closed:
            return
        match received:
            case Connection(state="connecting", why=why):
                if self._connection.state == "connecting":
                    self._set_connection(Connection("connecting", why))
            case Connection(state="connected"):
                self._ping()
            case Connection(why=why):
                self._lost(why)
            case Pong():
                self._receive_pong(received)
            case _:
                self._receive_message(received)

    def _receive_pong(self, pong: Pong) -> None:
        if pong.client_id != self._id:
            return
        self._received_at = host_now()
        self._is_admitted = not pong.refusal
        if pong.refusal:
            self._number = None
            is_final = self._is_visit and pong.refusal in (DECLINED, VISIT_ENDED)
            self._set_connection(Connection("ended" if is_final else "connecting", pong.refusal))
            if is_final:
                self.close()
            return
        self._clock.update(pong)
        if self._number is not None and pong.number > self._number:
            self._number = None  # a batch was lost: the next ping asks for a snapshot

    def _receive_message(self, message: Any) -> None:
        self._received_at = host_now()
        match message:
            # else another program's
            case Snapshot(number=number, welcome=welcome, frames=frames) if self._is_admitted:
                self._number = number
                self._set_connection(Connection("connected"))
                if welcome.run != self._run:
                    self._run = welcome.run
                    self._unanswered.clear()
                self._listener(welcome)
                self._deliver(protocol.decode_frames(frames, ALL))
            case Batch(number=number, frames=frames) if (
                self._number is not None and number > self._number
            ):
                if number != self._number + 1:
                    self._number = None  # one is missing: ignore batches until the snapshot
                    self._ping()
                    return
                self._number = number
                self._deliver(protocol.decode_frames(frames, ALL))
            case Answers(answers=answers):
                awaited = [each for each in answers if each.id in self._unanswered]
                self._deliver([Frame(0, each.at, ANSWERED, each) for each in awaited])
            case MotionTraces(traces=traces) if self._number is not None:
                for trace in traces:
                    self._listener(trace)
            case LinkClosed():
                self._is_admitted, self._number = False, None
                self._set_connection(Connection("ended", _OVER))
                if not self._rejoins:
                    self.close()

    def _deliver(self, frames: list[Frame]) -> None:
        for frame in frames:
            if isinstance(frame.message, ActAnswered):
                self._unanswered.pop(frame.message.id, None)
        if frames:
            self._listener(frames)


# --- a probe of why a session admits no guest; Zenoh tells it only in the log of a process


_TIMEOUT_S = 10.0
_ANSWER_TIMEOUT_S = 2.0
_LOOK_AGAIN_S = 0.1
_CONNECTED, _ADMITTED = "connected", "admitted"
_SILENT_SESSION = "The session there does not answer."
_SILENT_ROUTER = "The router there does not answer."
NOBODY_THERE = (
    "Nobody is training there now. If somebody is, this invitation was revoked: ask for a new one."
)
IS_FOR_A_HOME = (
    "This invitation is for a home, and no panel can use it. Keep it there: sar-tui link home FILE"
)
NOT_ADMITTED_BY_ROUTER = (
    "The router there does not accept this invitation: it was revoked. Ask for a new one."
)
NOT_ADMITTED = (
    "The session there does not accept this invitation: it was revoked, or made after that "
    "session began. Ask for a "
    "new one, or have the session restarted."
)


def probe(settings: str, link: str, guest: str = "", *, through_router: bool = False) -> None:
    """Connect once to a link with a guest's Zenoh settings. Takes up to ten seconds.

    Args:
        settings, link: of the link.
        guest: name of the guest; see whether a router lets them in, whether or not anybody else is
            there.
        through_router: the link is through a router.

    Raises:
        LinkError: the session does not admit the guest; the message says why, as far as is known.
    """
    need_packages()
    with subprocess.Popen(
        child_process.python("sar_tui.link.client"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **log_environment(GUEST_LOG)},
        text=True,
        errors="replace",
    ) as child:
        try:
            log, _ = child.communicate(f"{link}\n{guest}\n{settings}", timeout=_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            child.kill()
            is_router = through_router or bool(guest)
            raise LinkError(_SILENT_ROUTER if is_router else _SILENT_SESSION) from None
    lines = log.splitlines()
    if _ADMITTED in lines:
        return
    if _CONNECTED in lines:
        if guest:
            raise LinkError(NOT_ADMITTED_BY_ROUTER)
        raise LinkError(NOBODY_THERE if through_router else NOT_ADMITTED)
    raise LinkError(why_not_connected(log, to_router=through_router or bool(guest)))


def main() -> None:
    """Run the child: reads the link's id, the guest or an empty line, and settings from standard
    input, prints Zenoh's log and the outcome.
    """
    import zenoh

    from sar_tui.link.zenoh_settings import LinkKeys, config

    link, guest = (sys.stdin.readline().strip() for _ in range(2))
    settings = sys.stdin.read()
    keys = LinkKeys(link)
    zenoh.init_log_from_env_or(GUEST_LOG)
    with contextlib.ExitStack() as stack:
        try:
            session = stack.enter_context(zenoh.open(config(settings)))
            key = keys.broadcast
            if guest:  # another connection must see what this one announces
                key = keys.ping(guest)
                announcing = stack.enter_context(zenoh.open(config(settings)))
                token = announcing.liveliness().declare_token(key)
        except zenoh.ZError:
            return
        print(_CONNECTED, flush=True)
        latest = time.monotonic() + _ANSWER_TIMEOUT_S
        while not (is_there := _is_announced(session, key)) and guest:
            if time.monotonic() > latest:
                break
            time.sleep(_LOOK_AGAIN_S)  # what is announced takes a moment to reach the router
        if is_there:
            print(_ADMITTED, flush=True)
        if guest:
            token.undeclare()  # type: ignore[no-untyped-call]


def _is_announced(session: Any, key: str) -> bool:
    found = session.liveliness().get(key, timeout=_ANSWER_TIMEOUT_S)
    return any(reply.ok for reply in found)


if __name__ == "__main__":
    main()
