"""Who is at the link: pure bookkeeping of signs of life."""

from typing import Literal

Heard = Literal["joined", "there", "taken", "full"]
MOST_PEERS = 16
"""More than these are not let in."""


class Presence:
    """The peers that were heard of lately, by name.

    A name belongs to one program at a time, known by an id that it drew for itself (``who``): a second one that calls
    itself the same is not let in for as long as the first lives.

    Args:
        patience: a peer that was not heard of for so long (ns) is lost.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience
        self._heard: dict[str, tuple[str, int]] = {}

    def __contains__(self, name: str) -> bool:
        return name in self._heard

    def is_there(self, name: str, who: str) -> bool:
        """Whether this very program is at the link."""
        return name in self._heard and self._heard[name][0] == who

    def hear(self, name: str, who: str, now: int) -> Heard:
        """A sign of life: ``taken`` where another program has that name, ``full`` where there are too many."""
        if name in self._heard:
            if self._heard[name][0] != who:
                return "taken"
            self._heard[name] = (who, now)
            return "there"
        if len(self._heard) >= MOST_PEERS:
            return "full"
        self._heard[name] = (who, now)
        return "joined"

    def leave(self, name: str) -> bool:
        """It is gone; False if it was not there."""
        return self._heard.pop(name, None) is not None

    def overdue(self, now: int) -> list[str]:
        """Who has not been heard of for too long: they are lost now."""
        lost = [name for name, (_, at) in self._heard.items() if now - at > self._patience]
        for name in lost:
            del self._heard[name]
        return lost
