"""A panel's connection itself: Zenoh, on threads of its own. It knows bytes and keys, and not what they mean."""

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
from sar_tui.link.settings import LinkKeys, config, network_settings, socket_settings

if TYPE_CHECKING:
    import zenoh

_RETRY_S = 0.5
_MOST_WAITING = 200
_CLOSES_S = 1.0
_ANSWERED_S = 0.5

_TELLS_S = 15.0
"""How often it is looked into why there is no connection, which takes another process."""
_NO_SESSION = "The session does not answer: it may be over."
_LETS_IN_S = 1.5
"""Who has come in, and sees nothing of the session by then, is not let in: it tells strangers nothing of itself."""

Received = SessionMessage | Connection


class ConnectionTarget(NamedTuple):
    """How a session can be reached: the id of its link, and Zenoh's settings for each place where it may be.

    ``socket``: on this machine.
    """

    link: str
    places: tuple[str, ...]
    socket: Path | None = None


def connection_target(where: JoinableSession | Invitation) -> ConnectionTarget:
    """The ways to a session. Raises LinkError: what the link needs is not installed."""
    need_packages()
    if isinstance(where, JoinableSession):
        return ConnectionTarget(where.link, (socket_settings(where.socket),), where.socket)
    return ConnectionTarget(where.link, tuple(network_settings(place, where.credentials) for place in where.where))


class Transport:
    """Opens the connection, again and again until it can be; Zenoh keeps it then, and seeks it when it breaks.

    Args:
        ways: to the session.
        name: of the peer, as in keys.
        arrived: is given what comes, on any thread.
    """

    def __init__(self, ways: ConnectionTarget, name: str, arrived: Callable[[Received], object]) -> None:
        self._ways, self._arrived = ways, arrived
        self._keys = LinkKeys(ways.link)
        self._name = name
        self._outbox: queue.Queue[tuple[str, bytes] | None] = queue.Queue(_MOST_WAITING)
        self._closed = threading.Event()
        self._answered = threading.Event()
        self._is_let_in = False
        self._thread = threading.Thread(target=self._run, name="link", daemon=True)

    def open(self) -> None:
        """Begin."""
        self._thread.start()

    def send_hello(self, payload: bytes) -> None:
        """Send a sign of life; it is left out where too much waits already."""
        self._put(self._keys.hello(self._name), payload)

    def send_act(self, payload: bytes) -> None:
        """Send an act."""
        self._put(self._keys.act(self._name), payload)

    def close(self, *, awaits_answer: bool) -> None:
        """Send what waits, and let go; not for longer than a moment.

        ``awaits_answer``: only once ``let_go`` is called, or what was sent last may be overtaken by the end.
        """
        if not awaits_answer:
            self.let_go()
        self._closed.set()
        self._outbox_put(None)
        if self._thread.ident:
            self._thread.join(_CLOSES_S)

    def let_go(self) -> None:
        """What was sent last has come to the session; on any thread."""
        self._answered.set()

    def _put(self, key: str, payload: bytes) -> None:
        if not self._closed.is_set() or self._thread.is_alive():
            self._outbox_put((key, payload))

    def _outbox_put(self, what: "tuple[str, bytes] | None") -> None:
        with contextlib.suppress(queue.Full):
            self._outbox.put_nowait(what)

    # --- on the line's thread -------------------------------------------------------------------------------------

    def _run(self) -> None:
        told_at = time.monotonic() - _TELLS_S + _RETRY_S / 2  # a session that is just beginning is there next time
        for settings in itertools.cycle(self._ways.places):
            if self._closed.is_set():
                return
            if session := self._try(settings):
                try:
                    self._serve(session)
                finally:
                    session.close()  # type: ignore[no-untyped-call]
                return
            if time.monotonic() - told_at > _TELLS_S:
                self._arrived(Connection("connecting", self._why_not(settings)))
                told_at = time.monotonic()
            self._closed.wait(_RETRY_S)

    def _try(self, settings: str) -> "zenoh.Session | None":
        """Open Zenoh; None where that cannot be."""
        import zenoh

        try:
            return zenoh.open(config(settings))
        except zenoh.ZError:
            return None

    def _why_not(self, settings: str) -> str:
        """Why there is no connection: Zenoh tells only its log, which can be read only in another process."""
        if self._ways.socket:
            return _NO_SESSION
        from sar_tui.link.probe import probe

        try:
            probe(settings, self._ways.link)
        except LinkError as error:
            return str(error)
        return ""

    def _serve(self, session: "zenoh.Session") -> None:
        """Send what there is to send; signs of life come by all the time, so that this never sleeps for long."""
        import zenoh

        from sar_tui.link.probe import NOT_LET_IN

        keys, name = self._keys, self._name
        held: list[Any] = [
            session.declare_subscriber(key, zenoh.handlers.Callback(self._received, indirect=False))
            for key in (keys.out, keys.back(name))
        ]
        held.append(session.liveliness().declare_token(keys.hello(name)))
        watch = zenoh.handlers.Callback(self._seen, indirect=False)
        held.append(session.liveliness().declare_subscriber(keys.out, watch, history=True))
        told_by = time.monotonic() + _LETS_IN_S
        while (parcel := self._outbox.get()) is not None:
            if not self._is_let_in and time.monotonic() > told_by:
                self._arrived(Connection("connecting", _NO_SESSION if self._ways.socket else NOT_LET_IN))
                told_by += _TELLS_S
            with contextlib.suppress(zenoh.ZError):
                session.put(*parcel, congestion_control=zenoh.CongestionControl.BLOCK, express=True)
        self._answered.wait(_ANSWERED_S)  # before what is held is let go of, which tells the session so

    def _received(self, sample: "zenoh.Sample") -> None:
        with contextlib.suppress(ProtocolError):  # of a newer version, or damaged: the numbers tell what is missing
            self._arrived(protocol.decode(sample.payload.to_bytes(), SessionMessage))

    def _seen(self, sample: "zenoh.Sample") -> None:
        """The session's side of the link is there, or gone."""
        state: Literal["connected", "lost"] = "lost" if "DELETE" in str(sample.kind) else "connected"
        self._is_let_in = self._is_let_in or state == "connected"
        self._arrived(Connection(state, "" if state == "connected" else "The connection broke."))
