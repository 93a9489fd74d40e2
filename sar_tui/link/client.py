"""A panel's side of the link: what the session tells comes in on the panel's own loop, what an operator does goes out.

All that may wait is done on other threads: a panel never stands still because of the link.
"""

import asyncio
import contextlib
import re
import secrets
from typing import Any, TypeVar

import msgspec

from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import SECOND, host_now
from sar_tui.framework.messages import Message, Role
from sar_tui.framework.topics import ALL
from sar_tui.link import protocol
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import Connection, Peer, PeerListener
from sar_tui.link.protocol import Batch, LinkClosed, MotionTraces, Ping, Pong, Snapshot
from sar_tui.link.remote_clock import RemoteClock
from sar_tui.link.transport import ConnectionTarget, Received, Transport, connection_target

M = TypeVar("M", bound=Message)

BEAT_S = 0.15
"""How often a panel gives a sign of life, from its own loop: one that hangs gives none. However short a silence a
session is set to take for a loss, a few signs come within it."""
SILENT = 2 * SECOND
"""A session that has told nothing for so long is lost; it answers every sign of life."""

_LONGEST_NAME = 32
_SILENT = "Nothing is heard from the session."
_OVER = "The session is over."


def connect(
    where: JoinableSession | Invitation, name: str, role: Role, hear: PeerListener, loop: asyncio.AbstractEventLoop
) -> Peer:
    """Join a session: one of this machine (see `folder.live_sessions`), or another's that one was invited to.

    Args:
        where: the session.
        name: what to be called there, as far as a key can say it; with an invitation, name and role are what that says.
        role: operator or observer.
        hear: is told all that comes, in order, on ``loop``, first that the link is ``connecting``.
        loop: the panel's.

    Raises:
        LinkError: what the link needs is not installed.
    """
    if isinstance(where, Invitation):
        name, role = where.name, where.role
    returns = isinstance(where, JoinableSession)
    return _Client(connection_target(where), f"{role}.{part_of_key(name)}", role, hear, loop, returns=returns)


def part_of_key(name: str) -> str:
    """A name as it can be a part of a key: ``jörg m.`` becomes ``j-rg-m``."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-_")[:_LONGEST_NAME] or "somebody"


class _Client:
    """See `peer.Peer`. Everything here happens on the panel's loop; the line has threads of its own.

    ``returns``: what is over may be resumed, and is joined again then. An invitation opens whatever session is there
    next, which may be another person's.
    """

    def __init__(
        self,
        ways: ConnectionTarget,
        name: str,
        role: Role,
        hear: PeerListener,
        loop: asyncio.AbstractEventLoop,
        *,
        returns: bool,
    ) -> None:
        self.name, self.role, self._returns = name, role, returns
        self._hear, self._loop = hear, loop
        self._who = secrets.token_hex(8)
        self._clock = RemoteClock()
        self._state = Connection("connecting")
        self._is_let_in = False
        self._number: int | None = None
        self._heard_at = 0
        self._is_closed = False
        self._goodbye: int | None = None
        self._line = Transport(ways, name, self._arrived_elsewhere)
        loop.call_soon(self._begin)

    def send(self, topic: Topic[M], message: M) -> None:
        """See `Peer`. What is sent while there is no link is lost: done later, it would come as a surprise."""
        if topic.name not in protocol.OPERATOR_TOPICS:
            raise ValueError(f"{topic.name} is not among what an operator may send")
        self._act(topic.name, protocol.encode(message))

    def take_control(self) -> None:
        """See `Peer`."""
        self._act(protocol.TAKE_CONTROL, protocol.encode(None))

    def now(self) -> int:
        """See `Peer`."""
        return self._clock.now()

    def close(self) -> None:
        """See `Peer`. Harmless twice."""
        if not self._is_closed:
            self._is_closed = True
            self._goodbye = host_now()
            self._line.send_hello(protocol.encode(Ping(self._who, self._goodbye, leaves=True)))
            self._line.close(awaits_answer=self._state.state == "connected")

    # --- on the loop --------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        if self._is_closed:
            return
        self._hear(self._state)
        self._line.open()
        self._beat()

    def _act(self, topic: str, message: bytes) -> None:
        if self._state.state == "connected":
            self._line.send_act(protocol.encode(protocol.ActRequest(self._who, topic, msgspec.Raw(message))))

    def _beat(self) -> None:
        if self._is_closed:
            return
        if self._state.state == "connected" and host_now() - self._heard_at > SILENT:
            self._lost(_SILENT)
        self._say_hello()
        self._loop.call_later(BEAT_S, self._beat)

    def _say_hello(self) -> None:
        self._line.send_hello(protocol.encode(Ping(self._who, host_now(), wants=self._number is None)))

    def _lost(self, why: str) -> None:
        self._is_let_in, self._number = False, None
        if self._state.state in ("connected", "lost"):
            self._turn(Connection("lost", why))

    def _turn(self, state: Connection) -> None:
        if state != self._state:
            self._state = state
            self._hear(state)

    def _arrived_elsewhere(self, arrived: Received) -> None:
        """From the line's threads."""
        if isinstance(arrived, Pong) and arrived.ping == self._goodbye:
            self._line.let_go()
        with contextlib.suppress(RuntimeError):  # the loop is closed, and with it the panel
            self._loop.call_soon_threadsafe(self._arrived, arrived)

    def _arrived(self, arrived: Received) -> None:
        if self._is_closed:
            return
        match arrived:
            case Connection(state="connecting", why=why):
                if self._state.state == "connecting":
                    self._turn(Connection("connecting", why))
            case Connection(state="connected"):
                self._say_hello()
            case Connection(why=why):
                self._lost(why)
            case Pong():
                self._answered(arrived)
            case _:
                self._told(arrived)

    def _answered(self, pong: Pong) -> None:
        if pong.who != self._who:
            return
        self._heard_at = host_now()
        self._is_let_in = not pong.refusal
        if pong.refusal:
            self._number = None
            self._turn(Connection("connecting", pong.refusal))
            return
        self._clock.update(pong)
        if self._number is not None and pong.number > self._number:
            self._number = None  # something did not come through: the next sign of life asks for it

    def _told(self, told: Any) -> None:
        self._heard_at = host_now()
        match told:
            case Snapshot(number=number, welcome=welcome, frames=frames) if self._is_let_in:  # else another's
                self._number = number
                self._turn(Connection("connected"))
                self._hear(welcome)
                self._hear(protocol.decode_frames(frames, ALL))
            case Batch(number=number, frames=frames) if self._number is not None and number > self._number:
                if number != self._number + 1:
                    self._number = None  # one is missing: what comes has to wait until all is told anew
                    self._say_hello()
                    return
                self._number = number
                if heard := protocol.decode_frames(frames, ALL):
                    self._hear(heard)
            case MotionTraces(traces=traces) if self._number is not None:
                for trace in traces:
                    self._hear(trace)
            case LinkClosed():
                self._is_let_in, self._number = False, None
                self._turn(Connection("ended", _OVER))
                if not self._returns:
                    self.close()
