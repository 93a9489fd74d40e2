"""Peers that are at the link, tracked by their heartbeats and by the answers of their terminals."""

from typing import Literal

import msgspec

from sar_tui.model.messages import Message, Role, SessionCommand
from sar_tui.model.units import MS, SECOND

SILENT_AFTER = 500 * MS
"""A peer without a heartbeat for this long is silent (ns). Below Zenoh's lease, above several ping
intervals.
"""
FIRST_ANSWER_WITHIN = 5 * SECOND
"""A terminal that has not answered by then answers no queries (ns)."""
HeartbeatResult = Literal["joined", "present", "taken", "full", "unattended"]
LossCause = Literal["silent", "unattended"]
Doubt = Literal["never answered", "relayed"]
MAX_PEERS = 16


class _Present(msgspec.Struct):
    """Peer at the link. ``answered``: when its terminal last answered (ns), or None if it never
    has.
    """

    client_id: str
    joined: int
    heard: int
    answered: int | None = None
    is_relayed: bool = False
    is_reported: bool = False


class Presence:
    """Peers that sent a heartbeat lately, by name.

    A name belongs to one program at a time, identified by a random id (``client_id``): a second
    program with the same name is not admitted while the first is present.

    A heartbeat proves that the panel's program runs, an answer of its terminal that a person's
    terminal is connected to it: ssh or a browser may be frozen while the program goes on.

    Args:
        lost_after: silence (ns) after which a peer is lost.
    """

    def __init__(self, lost_after: int) -> None:
        self._lost_after = lost_after
        self._peers: dict[str, _Present] = {}

    @property
    def names(self) -> list[str]:
        """Names of the peers at the link."""
        return list(self._peers)

    def is_present(self, name: str, client_id: str) -> bool:
        """Return whether this very program is at the link."""
        return name in self._peers and self._peers[name].client_id == client_id

    def heartbeat(
        self,
        name: str,
        client_id: str,
        now: int,
        silence: int | None = None,
        *,
        is_relayed: bool | None = None,
    ) -> HeartbeatResult:
        """Record a heartbeat.

        Args:
            name, client_id: of the peer.
            now: time of the heartbeat (ns).
            silence: time since the peer's terminal answered (ns); None if it never has.
            is_relayed: another program answers in place of the terminal; None if this heartbeat
                does not say.

        Returns:
            ``taken`` if another program has that name, ``full`` if there are too many peers,
            ``unattended`` if the
            peer's terminal has been silent for too long to be admitted.
        """
        peer = self._peers.get(name)
        if peer is None:
            if silence is not None and silence > self._lost_after:
                return "unattended"
            if len(self._peers) >= MAX_PEERS:
                return "full"
        elif peer.client_id != client_id:
            return "taken"
        present = self._peers.setdefault(name, _Present(client_id, now, now))
        present.heard = now
        if silence is not None:
            present.answered = max(present.answered or 0, now - silence)
        if is_relayed is not None:
            present.is_relayed = is_relayed
        return "joined" if peer is None else "present"

    def is_silent(self, name: str, now: int) -> bool:
        """Return True if a peer has stopped sending heartbeats, though not for long enough to be
        lost.
        """
        return name in self._peers and now - self._peers[name].heard > SILENT_AFTER

    def leave(self, name: str) -> bool:
        """Remove a peer; False if it was not present."""
        return self._peers.pop(name, None) is not None

    def expire(self, now: int) -> list[tuple[str, LossCause]]:
        """Remove the peers that have been silent for too long, or whose terminals have; return them
        with the cause.
        """
        lost: list[tuple[str, LossCause]] = []
        for name, peer in self._peers.items():
            if now - peer.heard > self._lost_after:
                lost.append((name, "silent"))
            elif peer.answered is not None and now - peer.answered > self._lost_after:
                lost.append((name, "unattended"))
        for name, _ in lost:
            del self._peers[name]
        return lost

    def unproven(self, now: int) -> list[tuple[str, Doubt]]:
        """Return the peers, once each, of whom nothing proves that a person's terminal is
        connected.
        """
        found: list[tuple[str, Doubt]] = []
        for name, peer in self._peers.items():
            is_mute = peer.answered is None and now - peer.joined > FIRST_ANSWER_WITHIN
            if not peer.is_reported and (peer.is_relayed or is_mute):
                peer.is_reported = True
                found.append((name, "relayed" if peer.is_relayed else "never answered"))
        return found


def needs_control(act: Message) -> bool:
    """Return False for a stop of the agent: whoever sees that something goes wrong may stop it,
    observers too.
    """
    return not (isinstance(act, SessionCommand) and act.command == "stop")


class ControlLock:
    """Lock held by at most one operator: the first to join, and after its holder leaves, the next
    one present.

    Attributes:
        peers: roles of the operators and observers present, in the order in which they joined.
        holder: name of the operator in control, or empty.
    """

    def __init__(self) -> None:
        self.peers: dict[str, Role] = {}
        self.holder = ""

    def join(self, name: str, role: Role) -> None:
        """Add a peer."""
        self.peers[name] = role
        self._assign()

    def leave(self, name: str) -> None:
        """Remove a peer that left or was lost."""
        self.peers.pop(name, None)
        if self.holder == name:
            self.holder = ""
            self._assign()

    def take(self, name: str) -> bool:
        """Give control to an operator, even if another has it; False if no such operator is
        present.
        """
        if self.peers.get(name) != "operator":
            return False
        self.holder = name
        return True

    def _assign(self) -> None:
        if not self.holder:
            self.holder = next(
                (name for name, role in self.peers.items() if role == "operator"), ""
            )
