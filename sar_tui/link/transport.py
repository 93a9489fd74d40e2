"""A panel's Zenoh connection, on threads of its own. It carries encoded messages."""

import contextlib
import itertools
import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from sar_tui.link import protocol
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import Connection
from sar_tui.link.protocol import ProtocolError, SessionMessage
from sar_tui.link.zenoh_settings import LinkKeys, config, network_settings, socket_settings

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

    ``socket``: if it is on this machine.
    """

    link: str
    settings: tuple[str, ...]
    socket: Path | None = None


def connection_target(where: JoinableSession | Invitation) -> ConnectionTarget:
    """Return how to connect to a session. Raises LinkError if the link's packages are not
    installed.
    """
    need_packages()
    if isinstance(where, JoinableSession):
        return ConnectionTarget(where.link, (socket_settings(where.socket),), where.socket)
    return ConnectionTarget(
        where.link, tuple(network_settings(place, where.credentials) for place in where.where)
    )


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
        from sar_tui.link.probe import probe

        try:
            probe(settings, self._target.link)
        except LinkError as error:
            return str(error)
        return ""

    def _serve(self, session: "zenoh.Session") -> None:
        """Send what is queued until closed. Heartbeats are queued all the time, so this never
        blocks for long.
        """
        import zenoh

        from sar_tui.link.probe import NOT_ADMITTED

        keys, name = self._keys, self._name
        declared: list[Any] = [
            session.declare_subscriber(key, zenoh.handlers.Callback(self._received, indirect=False))
            for key in (keys.broadcast, keys.reply(name))
        ]
        declared.append(session.liveliness().declare_token(keys.ping(name)))
        handler = zenoh.handlers.Callback(self._liveliness_changed, indirect=False)
        declared.append(
            session.liveliness().declare_subscriber(keys.broadcast, handler, history=True)
        )
        report_at = time.monotonic() + _ADMISSION_TIMEOUT_S
        while (message := self._outbox.get()) is not None:
            if not self._is_admitted and time.monotonic() > report_at:
                self._on_receive(
                    Connection("connecting", _NO_SESSION if self._target.socket else NOT_ADMITTED)
                )
                report_at += _PROBE_INTERVAL_S
            with contextlib.suppress(zenoh.ZError):
                session.put(
                    *message, congestion_control=zenoh.CongestionControl.BLOCK, express=True
                )
        # before the token is dropped, which looks like a lost connection
        self._acknowledged.wait(_GOODBYE_TIMEOUT_S)

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
