"""Peers that are at the link, tracked by their heartbeats."""

from typing import Literal

from sar_tui.framework.clock import MS

SILENT_AFTER = 500 * MS
"""A peer without a heartbeat for this long is silent (ns). Below Zenoh's lease, above several ping intervals."""
HeartbeatResult = Literal["joined", "present", "taken", "full"]
MAX_PEERS = 16


class Presence:
    """Peers that sent a heartbeat lately, by name.

    A name belongs to one program at a time, identified by a random id (``client_id``): a second program with the same
    name is not admitted while the first is present.

    Args:
        lost_after: silence (ns) after which a peer is lost.
    """

    def __init__(self, lost_after: int) -> None:
        self._lost_after = lost_after
        self._peers: dict[str, tuple[str, int]] = {}

    def __contains__(self, name: str) -> bool:
        return name in self._peers

    def is_present(self, name: str, client_id: str) -> bool:
        """Return whether this very program is at the link."""
        return name in self._peers and self._peers[name][0] == client_id

    def heartbeat(self, name: str, client_id: str, now: int) -> HeartbeatResult:
        """Record a heartbeat; ``taken`` if another program has that name, ``full`` if there are too many peers."""
        if name in self._peers:
            if self._peers[name][0] != client_id:
                return "taken"
            self._peers[name] = (client_id, now)
            return "present"
        if len(self._peers) >= MAX_PEERS:
            return "full"
        self._peers[name] = (client_id, now)
        return "joined"

    def is_silent(self, name: str, now: int) -> bool:
        """Return True if a peer has stopped sending heartbeats, though not for long enough to be lost."""
        return name in self._peers and now - self._peers[name][1] > SILENT_AFTER

    def leave(self, name: str) -> bool:
        """Remove a peer; False if it was not present."""
        return self._peers.pop(name, None) is not None

    def expire(self, now: int) -> list[str]:
        """Remove and return the peers that have been silent for too long."""
        lost = [name for name, (_, at) in self._peers.items() if now - at > self._lost_after]
        for name in lost:
            del self._peers[name]
        return lost
