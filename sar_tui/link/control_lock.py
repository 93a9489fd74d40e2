"""Who of several operators acts: pure bookkeeping of who is there, and who holds the baton."""

from sar_tui.framework.messages import Role


class ControlLock:
    """Held by at most one operator. The first to come gets it; when its holder is gone, another who is there does.

    Attributes:
        peers: who is there, operators and observers, in the order in which they came.
        holder: who has it; empty where nobody does.
    """

    def __init__(self) -> None:
        self.peers: dict[str, Role] = {}
        self.holder = ""

    def join(self, name: str, role: Role) -> None:
        """Somebody came."""
        self.peers[name] = role
        self._hand_on()

    def leave(self, name: str) -> None:
        """Somebody is gone, or no longer heard."""
        self.peers.pop(name, None)
        if self.holder == name:
            self.holder = ""
            self._hand_on()

    def take(self, name: str) -> bool:
        """An operator takes it, whoever had it; False where that is none, or not there."""
        if self.peers.get(name) != "operator":
            return False
        self.holder = name
        return True

    def _hand_on(self) -> None:
        if not self.holder:
            self.holder = next((name for name, role in self.peers.items() if role == "operator"), "")
