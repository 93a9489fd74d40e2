"""Lock that decides which of several operators controls the session, and the one act that does
without it.
"""

from sar_tui.model.messages import Message, Role, SessionCommand


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
